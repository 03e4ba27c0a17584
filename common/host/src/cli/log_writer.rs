//! A thread of its own for the log: no caller waits for a log that is full, closed or not read.

use std::io::{Result, Write};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::time::Duration;

/// Most lines that wait for the log. Lines without room are dropped; at 100 bytes a line they are some 2 MB.
const MOST_LINES: usize = 16_384;
/// Time in which the remaining lines are written at the end. A reader that has stopped must not keep the process.
const TIME_TO_END: Duration = Duration::from_secs(1);
/// Pause between attempts to enter a full queue at the end.
const RETRY: Duration = Duration::from_millis(10);

/// Makes a queue of lines, written to `log` by a thread of its own until the guard is dropped.
pub(super) fn lines_to(log: impl Write + Send + 'static) -> (LineQueue, WriterGuard) {
    let (queue, waiting) = sync_channel(MOST_LINES);
    let (ended, end) = sync_channel(1);
    // Without a thread nothing reads the queue: the node runs without a log, rather than not at all.
    let _ = std::thread::Builder::new()
        .name("log".to_owned())
        .spawn(move || write(&waiting, log, &ended));
    let guard = WriterGuard {
        queue: queue.clone(),
        end,
    };
    (LineQueue(queue), guard)
}

/// Lines on their way to the log. Each write is a line.
#[derive(Clone)]
pub(super) struct LineQueue(SyncSender<LogMessage>);

impl Write for LineQueue {
    fn write(&mut self, line: &[u8]) -> Result<usize> {
        let _ = self.0.try_send(LogMessage::Line(line.to_vec()));
        Ok(line.len())
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

/// Guard of the thread that writes: when dropped, it waits until the remaining lines are written.
pub(super) struct WriterGuard {
    queue: SyncSender<LogMessage>,
    end: Receiver<()>,
}

impl Drop for WriterGuard {
    fn drop(&mut self) {
        let attempts = TIME_TO_END.as_millis() / RETRY.as_millis();
        for _ in 0..attempts {
            match self.queue.try_send(LogMessage::End) {
                // Nothing ends before it was asked to: a pause.
                Err(TrySendError::Full(_)) => drop(self.end.recv_timeout(RETRY)),
                Ok(()) | Err(TrySendError::Disconnected(_)) => break,
            }
        }
        let _ = self.end.recv_timeout(TIME_TO_END);
    }
}

enum LogMessage {
    Line(Vec<u8>),
    End,
}

/// Writes lines until the end. An error is ignored: there is no other place for it, and the next line may have room.
fn write(waiting: &Receiver<LogMessage>, mut log: impl Write, ended: &SyncSender<()>) {
    while let Ok(LogMessage::Line(line)) = waiting.recv() {
        let _ = log.write_all(&line);
    }
    let _ = log.flush();
    let _ = ended.send(());
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;

    #[derive(Clone, Default)]
    struct Sink(Arc<Mutex<Vec<u8>>>);

    impl Write for Sink {
        fn write(&mut self, bytes: &[u8]) -> Result<usize> {
            self.0.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> Result<()> {
            Ok(())
        }
    }

    #[test]
    fn lines_before_the_end_are_written_in_their_order() {
        let sink = Sink::default();
        let (mut lines, guard) = lines_to(sink.clone());
        for k in 0..100 {
            writeln!(lines, "{k}").unwrap();
        }
        drop(guard);
        let text = String::from_utf8(sink.0.lock().unwrap().clone()).unwrap();
        let expected: String = (0..100).map(|k| format!("{k}\n")).collect();
        assert_eq!(text, expected);
    }

    #[test]
    fn a_log_that_nobody_reads_keeps_no_writer() {
        struct Stuck(Receiver<()>);
        impl Write for Stuck {
            fn write(&mut self, bytes: &[u8]) -> Result<usize> {
                let _ = self.0.recv();
                Ok(bytes.len())
            }

            fn flush(&mut self) -> Result<()> {
                Ok(())
            }
        }
        let (release, stuck) = sync_channel(1);
        let (mut lines, guard) = lines_to(Stuck(stuck));
        for _ in 0..2 * MOST_LINES {
            lines.write_all(b"line\n").unwrap();
        }
        drop(guard);
        drop(release);
    }
}
