//! Shutdown of a node when one of its threads panics: otherwise the node would look alive and do
//! half of its work.

use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

/// Watch passed to every thread that does a node's work.
#[derive(Clone)]
pub(crate) struct PanicWatch {
    sender: UnboundedSender<&'static str>,
}

/// Receiver of the first panic.
pub(crate) struct Panics {
    receiver: UnboundedReceiver<&'static str>,
}

/// Guard that reports a panic of its thread.
pub(crate) struct Watched<'a> {
    watch: &'a PanicWatch,
    thread: &'static str,
}

pub(crate) fn panics() -> (PanicWatch, Panics) {
    // Unbounded, since a panicking thread must not wait: it sends one name, and there are few threads.
    let (sender, receiver) = unbounded_channel();
    (PanicWatch { sender }, Panics { receiver })
}

impl PanicWatch {
    /// Watches the calling thread, under this name in messages.
    pub(crate) const fn over(&self, thread: &'static str) -> Watched<'_> {
        Watched {
            watch: self,
            thread,
        }
    }
}

impl Panics {
    /// Waits for the next thread that panics, and returns its name; never returns if none does.
    pub(crate) async fn next(&mut self) -> &'static str {
        match self.receiver.recv().await {
            Some(thread) => thread,
            // All watches are gone, so that no thread can panic any more: the end comes another way.
            None => std::future::pending().await,
        }
    }
}

impl Drop for Watched<'_> {
    fn drop(&mut self) {
        // Also dropped at a regular end, which is nothing to report.
        if std::thread::panicking() {
            // The receiver may be gone.
            let _ = self.watch.sender.send(self.thread);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn only_a_thread_that_panics_is_told_of() {
        let (watch, mut panics) = panics();
        for (thread, panics) in [("well", false), ("ill", true)] {
            let watch = watch.clone();
            let work = move || {
                let _watched = watch.over(thread);
                assert!(!panics, "on purpose");
            };
            assert_eq!(std::thread::spawn(work).join().is_err(), panics);
        }
        assert_eq!(panics.next().await, "ill");
    }
}
