//! The thread that accepts connections and reads their first bytes.
//!
//! Apart from the threads of the links: `ZENOH_RUNTIME` of a node gives acceptor and receiver one thread, on which a
//! flood of connects would hold up the frames of established links. A handshake starts at a limited pace, on the
//! thread of its later link, so that no message of a link takes a way through this thread.

use std::io;
use std::sync::OnceLock;

use tokio::runtime::{Builder, Runtime};
use tokio::task::JoinHandle;
use zenoh_result::{ZResult, zerror};

/// For all listeners of the process. Never dropped: it ends with the process.
static RUNTIME: OnceLock<io::Result<Runtime>> = OnceLock::new();

/// Starts the thread unless it runs. It has the scheduling policy and priority of the calling thread.
///
/// Otherwise the first listener starts it, on a thread of Zenoh, which may have the real-time priority of frames.
pub fn start_accept_thread() {
    let _ = runtime();
}

/// Runs a listener on the thread.
pub(crate) fn spawn<T: Send + 'static>(
    listener: impl Future<Output = T> + Send + 'static,
) -> ZResult<JoinHandle<T>> {
    match runtime() {
        Ok(runtime) => Ok(runtime.spawn(listener)),
        Err(error) => Err(zerror!("the thread that accepts connections: {error}").into()),
    }
}

fn runtime() -> &'static io::Result<Runtime> {
    RUNTIME.get_or_init(|| {
        Builder::new_multi_thread()
            .worker_threads(1)
            .thread_name("accept")
            .enable_io()
            .enable_time()
            .build()
    })
}
