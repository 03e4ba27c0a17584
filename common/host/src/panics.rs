//! A thread that panics ends its node: what is left of it would look alive and do half of its work.

use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

/// Given to every thread that does a node's work.
#[derive(Clone)]
pub(crate) struct PanicWatch {
    sender: UnboundedSender<&'static str>,
}

/// Hears of the first one.
pub(crate) struct Panics {
    receiver: UnboundedReceiver<&'static str>,
}

/// While it lives a panic of its thread is noticed.
pub(crate) struct Watched<'a> {
    watch: &'a PanicWatch,
    thread: &'static str,
}

pub(crate) fn panics() -> (PanicWatch, Panics) {
    let (sender, receiver) = unbounded_channel();
    (PanicWatch { sender }, Panics { receiver })
}

impl PanicWatch {
    /// Watches the calling thread, which messages call by this name.
    pub(crate) const fn over(&self, thread: &'static str) -> Watched<'_> {
        Watched {
            watch: self,
            thread,
        }
    }
}

impl Panics {
    /// The name of the next thread that panics; never, if none does.
    pub(crate) async fn next(&mut self) -> &'static str {
        match self.receiver.recv().await {
            Some(thread) => thread,
            None => std::future::pending().await,
        }
    }
}

impl Drop for Watched<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            // Who is to hear of it may be gone.
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
