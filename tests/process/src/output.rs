//! A tool that a test runs to its end.

use std::io::Read;
use std::process::{Command, Output, Stdio};
use std::thread::JoinHandle;

use crate::{POLL_INTERVAL, Process, assert_alive};

/// Runs a tool to its end and returns its output, as [`Command::output`] does.
///
/// # Panics
/// The tool does not start, or a process that this thread has started is gone while the tool runs.
#[must_use]
pub fn output(command: &mut Command) -> Output {
    let name = command.get_program().to_string_lossy().into_owned();
    let words: Vec<_> = command
        .get_args()
        .map(|word| word.to_string_lossy())
        .collect();
    let what = format!("{} ends", words.join(" "));
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let tool = Process::start_without_log(&name, command);
    let tool = tool.unwrap_or_else(|error| panic!("{name} does not start: {error}"));
    // Its end is awaited; only the other processes of the test must not end meanwhile.
    tool.may_end();
    // Both at once: a full pipe of one stops the program while the other is read.
    let stdout = read_to_end(tool.take_stdout());
    let stderr = read_to_end(tool.take_stderr());
    while !tool.has_ended() {
        assert_alive(&what);
        std::thread::park_timeout(POLL_INTERVAL);
    }
    Output {
        status: tool.wait(),
        stdout: stdout.join().expect("it is read"),
        stderr: stderr.join().expect("it is read"),
    }
}

/// Reads a pipe beside the wait: a program whose pipe is full stands still.
fn read_to_end(pipe: Option<impl Read + Send + 'static>) -> JoinHandle<Vec<u8>> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            let _ = pipe.read_to_end(&mut bytes);
        }
        bytes
    })
}
