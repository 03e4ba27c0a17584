//! A program that a test has started.

use std::cell::RefCell;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

thread_local! {
    /// Every process that this thread has started. Tests run in a thread each: no test sees the processes of another.
    static STARTED: RefCell<Vec<Weak<Watched>>> = const { RefCell::new(Vec::new()) };
}

/// The last lines of a log that a report shows: a panic with a backtrace hint has three, and the cause often stands before it.
const LAST_LINES: usize = 12;

/// A program that ends with the test, and fails the test if it ends unexpectedly before.
#[derive(Debug)]
pub struct Process(Arc<Watched>);

#[derive(Debug)]
struct Watched {
    name: String,
    log: Option<PathBuf>,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    child: Child,
    /// True once the test has ended it, or permits its end.
    may_end: bool,
    /// Exit status, once it has ended.
    status: Option<ExitStatus>,
}

/// Fails the test if a process that this thread has started ended unexpectedly.
///
/// # Panics
/// Names each of them, its exit status and its last lines; `what` names the condition that the test waited for.
pub fn assert_alive(what: &str) {
    deaths().report(what);
}

/// Processes that ended unexpectedly.
pub(crate) struct Deaths(Vec<Arc<Watched>>);

/// The deaths among the processes of this thread.
pub(crate) fn deaths() -> Deaths {
    let all = started().into_iter();
    Deaths(all.filter(|one| one.is_dead()).collect())
}

impl Deaths {
    /// Fails the test if there are any. Each is reported once.
    pub(crate) fn report(&self, what: &str) {
        let report = |one: &Arc<Watched>| {
            let report = one.report(&format!(", while the test waited: {what}"));
            // Reported once: the test's own end must not fail a second time by it.
            one.state().may_end = true;
            report
        };
        let reports: Vec<_> = self.0.iter().map(report).collect();
        assert!(reports.is_empty(), "{}", reports.join("\n"));
    }
}

/// The last lines of every process of this thread.
pub(crate) fn logs() -> Vec<String> {
    let all = started().into_iter();
    all.map(|one| format!("{}: {}", one.name, one.last_lines()))
        .collect()
}

fn started() -> Vec<Arc<Watched>> {
    STARTED.with_borrow_mut(|started| {
        // Weak: a process that the test has dropped has been ended, and is no death.
        started.retain(|one| one.strong_count() > 0);
        started.iter().filter_map(Weak::upgrade).collect()
    })
}

impl Process {
    /// Starts a program with its log (standard error) in a file.
    ///
    /// # Panics
    /// The program cannot be started, or the file not be made.
    #[must_use]
    pub fn start(name: &str, command: &mut Command, log: &Path) -> Self {
        let file = File::create(log).unwrap_or_else(|error| panic!("{}: {error}", log.display()));
        // A file, not a pipe, which nobody reads while the test waits.
        let child = command.stderr(file).spawn();
        let child = child.unwrap_or_else(|error| panic!("{name} does not start: {error}"));
        Self::new(name, child, Some(log))
    }

    /// Starts a program whose standard error is set by the command.
    ///
    /// # Errors
    /// The program cannot be started: it may not be installed.
    pub fn start_without_log(name: &str, command: &mut Command) -> io::Result<Self> {
        Ok(Self::new(name, command.spawn()?, None))
    }

    fn new(name: &str, child: Child, log: Option<&Path>) -> Self {
        let state = State {
            child,
            may_end: false,
            status: None,
        };
        let watched = Arc::new(Watched {
            name: name.to_owned(),
            log: log.map(Path::to_owned),
            state: Mutex::new(state),
        });
        STARTED.with_borrow_mut(|started| started.push(Arc::downgrade(&watched)));
        Self(watched)
    }

    /// The number of the process.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.0.state().child.id()
    }

    /// The log so far.
    #[must_use]
    pub fn log(&self) -> String {
        self.0.log()
    }

    /// True if the log contains this text.
    #[must_use]
    pub fn logged(&self, what: &str) -> bool {
        self.log().contains(what)
    }

    /// The piped standard input, once.
    #[must_use]
    pub fn take_stdin(&self) -> Option<ChildStdin> {
        self.0.state().child.stdin.take()
    }

    /// The piped standard output, once.
    #[must_use]
    pub fn take_stdout(&self) -> Option<ChildStdout> {
        self.0.state().child.stdout.take()
    }

    /// The piped standard error, once.
    #[must_use]
    pub fn take_stderr(&self) -> Option<ChildStderr> {
        self.0.state().child.stderr.take()
    }

    /// Sends a signal: `TERM`, `INT`, `HUP`. The process may end from now on.
    ///
    /// # Panics
    /// The process has ended unexpectedly before, or the signal cannot be sent.
    pub fn signal(&self, signal: &str) {
        // A signal to an ended process would hide that it had ended by itself.
        self.0.assert_alive();
        self.0.state().may_end = true;
        send(signal, self.id());
    }

    /// Kills it, without time for last output, and waits until it is gone.
    ///
    /// # Panics
    /// The process has ended unexpectedly before.
    pub fn kill(&self) {
        self.0.assert_alive();
        let mut state = self.0.state();
        state.may_end = true;
        state.end();
    }

    /// Waits until it ends by itself or by a signal that the test has sent.
    ///
    /// # Panics
    /// It does not end within [`WAIT_TIMEOUT`](crate::WAIT_TIMEOUT), or another process that this thread has started is gone.
    #[must_use]
    pub fn wait(&self) -> ExitStatus {
        self.0.state().may_end = true;
        let what = format!("{} ends", self.0.name);
        // Watches the other processes meanwhile.
        crate::until(&what, || self.has_ended());
        self.0.state().status.expect("it has ended")
    }

    /// True if it has ended, which is no failure by itself.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.0.state().has_ended()
    }

    /// Permits its end from now on.
    pub fn may_end(&self) {
        self.0.state().may_end = true;
    }
}

impl Drop for Process {
    /// No program is left running, and no crash goes unnoticed.
    #[expect(
        clippy::print_stderr,
        reason = "the test fails already: this is why it may"
    )]
    fn drop(&mut self) {
        // Asked before it is ended here, which would look like a death.
        let is_dead = self.0.is_dead();
        let killed = self.0.state().end();
        // A second panic while one unwinds aborts the whole test program, without any report.
        if is_dead && std::thread::panicking() {
            eprintln!("{}", self.0.report(""));
        // An exit code of its own may be what the test is about; a signal never is.
        } else if is_dead && killed {
            panic!("{}", self.0.report(""));
        }
    }
}

impl Watched {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn log(&self) -> String {
        let read = self.log.as_deref().map(std::fs::read);
        let bytes = read.and_then(Result::ok).unwrap_or_default();
        // A killed process may leave half a character.
        String::from_utf8_lossy(&bytes).into_owned()
    }

    fn assert_alive(&self) {
        assert!(!self.is_dead(), "{}", self.report(""));
    }

    /// True if it has ended unexpectedly.
    fn is_dead(&self) -> bool {
        let mut state = self.state();
        // The permission first: it makes an end uninteresting, and saves the system call.
        !state.may_end && state.has_ended()
    }

    /// Exit status and last lines.
    fn report(&self, when: &str) -> String {
        let how = self.state().status.map(how_it_ended).unwrap_or_default();
        format!("{} {how}{when}\n{}", self.name, self.last_lines())
    }

    fn last_lines(&self) -> String {
        if self.log.is_none() {
            return "it has no log of its own".to_owned();
        }
        let log = self.log();
        let lines: Vec<_> = log.lines().collect();
        match &lines[lines.len().saturating_sub(LAST_LINES)..] {
            [] => "its log is empty".to_owned(),
            last => format!("the last lines of its log:\n  {}", last.join("\n  ")),
        }
    }
}

impl State {
    fn has_ended(&mut self) -> bool {
        if self.status.is_none() {
            // Kept, because a child can be waited for once only.
            self.status = self.child.try_wait().expect("a child can be asked");
        }
        self.status.is_some()
    }

    /// Ends it. True if it was killed by a signal before.
    fn end(&mut self) -> bool {
        if self.has_ended() {
            return self.status.is_some_and(|status| status.code().is_none());
        }
        // May have ended in between, which is as good.
        let _ = self.child.kill();
        self.status = self.child.wait().ok();
        false
    }
}

/// A process that a signal killed has no exit code; the signal has its name in the status.
fn how_it_ended(status: ExitStatus) -> String {
    match status.code() {
        Some(code) => format!("ended with exit code {code}"),
        None => format!("was killed by {status}"),
    }
}

fn send(signal: &str, process: u32) {
    let mut kill = Command::new("kill");
    let sent = kill.arg(format!("-{signal}")).arg(process.to_string());
    assert!(
        sent.status().is_ok_and(|status| status.success()),
        "SIG{signal} cannot be sent to process {process}"
    );
}
