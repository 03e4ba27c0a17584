//! Bounded set of connections to a page.

use std::convert::Infallible;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::task::{Context, Poll};

use http_body_util::combinators::UnsyncBoxBody;
use hyper::body::{Body, Bytes, Frame, SizeHint};
use tokio::task::JoinHandle;

/// Most connections at a time. With the page's own files they are its budget of descriptors.
// Browsers open at most six to an address: five of them, and a few readers of the metrics.
pub(super) const MOST_CONNECTIONS: usize = 32;

/// Number of responses that are under way on a connection.
#[derive(Clone, Debug, Default)]
pub(super) struct UnderWay(Arc<AtomicUsize>);

/// A response, counted until dropped.
#[derive(Debug)]
pub(super) struct CountedResponse(UnderWay);

impl UnderWay {
    pub(super) fn count(&self) -> CountedResponse {
        self.0.fetch_add(1, Ordering::Relaxed);
        CountedResponse(self.clone())
    }

    fn is_any(&self) -> bool {
        self.0.load(Ordering::Relaxed) > 0
    }
}

impl Drop for CountedResponse {
    fn drop(&mut self) {
        self.0.0.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Body of a counted response, which is under way until all of it is sent.
#[derive(Debug)]
pub(super) struct CountedBody {
    body: UnsyncBoxBody<Bytes, Infallible>,
    _counted: CountedResponse,
}

impl CountedBody {
    pub(super) const fn of(
        body: UnsyncBoxBody<Bytes, Infallible>,
        counted: CountedResponse,
    ) -> Self {
        Self {
            body,
            _counted: counted,
        }
    }
}

impl Body for CountedBody {
    type Data = Bytes;
    type Error = Infallible;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Infallible>>> {
        Pin::new(&mut self.body).poll_frame(context)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        // With the exact size a response has its length in the head.
        self.body.size_hint()
    }
}

/// The open connections, the oldest first.
#[derive(Debug, Default)]
pub(super) struct Connections(Vec<OpenConnection>);

#[derive(Debug)]
struct OpenConnection {
    task: JoinHandle<()>,
    under_way: UnderWay,
}

impl Connections {
    /// Makes room for another connection; false if all of them are being responded to.
    ///
    /// The oldest connection without a response under way ends: it sends its request slowly, or none. So a newcomer
    /// that sends one is served, however many others do not.
    pub(super) async fn make_room(&mut self) -> bool {
        self.0.retain(|open| !open.task.is_finished());
        if self.0.len() < MOST_CONNECTIONS {
            return true;
        }
        let Some(idle) = self.0.iter().position(|open| !open.under_way.is_any()) else {
            return false;
        };
        let OpenConnection { task, .. } = self.0.remove(idle);
        task.abort();
        // Its descriptor is free only when the task is dropped.
        let _ = task.await;
        true
    }

    pub(super) fn add(&mut self, task: JoinHandle<()>, under_way: UnderWay) {
        self.0.push(OpenConnection { task, under_way });
    }
}
