//! A TLS stream that one task reads while another one writes.

use std::future::poll_fn;
use std::io;
use std::net::Shutdown;
use std::pin::Pin;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio_rustls::TlsStream;

/// Time for the last bytes of a link that is closed. A peer that takes none of them in this time is gone.
const CLOSE_TIMEOUT: Duration = Duration::from_millis(500);

/// A TLS stream behind a lock.
///
/// A TLS session is one state for both directions, so reading and writing exclude each other. The lock is
/// held for one poll, never across an await: the time to encrypt or decrypt the available bytes and one
/// system call. Neither direction waits for the other one's bytes. A socket knows one waiting reader and
/// one waiting writer; further ones wait for their turn.
#[derive(Debug)]
pub(crate) struct SharedStream {
    stream: Mutex<TlsStream<TcpStream>>,
    reading: tokio::sync::Mutex<()>,
    writing: tokio::sync::Mutex<()>,
}

impl SharedStream {
    pub(crate) fn new(stream: TlsStream<TcpStream>) -> Self {
        Self {
            stream: Mutex::new(stream),
            reading: tokio::sync::Mutex::new(()),
            writing: tokio::sync::Mutex::new(()),
        }
    }

    /// Reads the available bytes, at least one; 0 at the end of the stream.
    pub(crate) async fn read(&self, buffer: &mut [u8]) -> io::Result<usize> {
        let _turn = self.reading.lock().await;
        self.read_some(buffer).await
    }

    /// Fills the buffer, or fails with `UnexpectedEof`.
    pub(crate) async fn read_exact(&self, mut buffer: &mut [u8]) -> io::Result<()> {
        let _turn = self.reading.lock().await;
        while !buffer.is_empty() {
            match self.read_some(buffer).await? {
                // An end within a message; Zenoh reads lengths and bodies with this.
                0 => return Err(io::ErrorKind::UnexpectedEof.into()),
                read => buffer = &mut buffer[read..],
            }
        }
        Ok(())
    }

    /// Writes some of the bytes, and sends them.
    pub(crate) async fn write(&self, bytes: &[u8]) -> io::Result<usize> {
        let _turn = self.writing.lock().await;
        let written = self.write_some(bytes).await?;
        // Encrypted bytes may stay in the session when the socket is full, and nobody else would send them.
        self.flush().await?;
        Ok(written)
    }

    /// Writes all of the bytes, and sends them.
    pub(crate) async fn write_all(&self, mut bytes: &[u8]) -> io::Result<()> {
        let _turn = self.writing.lock().await;
        while !bytes.is_empty() {
            match self.write_some(bytes).await? {
                0 => return Err(io::ErrorKind::WriteZero.into()),
                written => bytes = &bytes[written..],
            }
        }
        // Bytes that the socket did not take are still in the session.
        self.flush().await
    }

    /// Sends the pending bytes and the end of the stream, within [`CLOSE_TIMEOUT`], and closes the connection.
    pub(crate) async fn close(&self) {
        let close = async {
            // Behind a write in progress, whose bytes would be cut off otherwise.
            let _turn = self.writing.lock().await;
            self.poll(|stream, context| stream.poll_shutdown(context))
                .await
        };
        // A frozen peer takes no bytes, and the session must end nevertheless.
        let _ = tokio::time::timeout(CLOSE_TIMEOUT, close).await;
        self.abort();
    }

    /// Ends both directions at once: readers and writers get the end of the stream.
    pub(crate) fn abort(&self) {
        let stream = self.lock();
        let socket = socket2::SockRef::from(stream.get_ref().0);
        // The socket itself, since a task that waits in a poll holds no lock: it is woken by the end of the stream.
        let _ = socket.shutdown(Shutdown::Both);
    }

    async fn read_some(&self, buffer: &mut [u8]) -> io::Result<usize> {
        self.poll(|stream, context| {
            let mut buffer = ReadBuf::new(buffer);
            ready!(stream.poll_read(context, &mut buffer))?;
            Poll::Ready(Ok(buffer.filled().len()))
        })
        .await
    }

    async fn write_some(&self, bytes: &[u8]) -> io::Result<usize> {
        self.poll(|stream, context| stream.poll_write(context, bytes))
            .await
    }

    async fn flush(&self) -> io::Result<()> {
        self.poll(|stream, context| stream.poll_flush(context))
            .await
    }

    /// Polls with the stream locked: the only access to it.
    async fn poll<T>(
        &self,
        mut step: impl FnMut(Pin<&mut TlsStream<TcpStream>>, &mut Context<'_>) -> Poll<T>,
    ) -> T {
        poll_fn(|context| step(Pin::new(&mut *self.lock()), context)).await
    }

    /// A poll that panicked leaves a session that fails by itself, so poisoning adds no information.
    fn lock(&self) -> MutexGuard<'_, TlsStream<TcpStream>> {
        self.stream.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
