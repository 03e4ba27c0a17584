//! `coaxle conform`: it finds nothing wrong with our own nodes and with a client in Python that was written by docs/WIRE.md. With
//! a sender in Python that has a fault, it finds exactly the rule that the fault breaks.

mod nodes;
mod python;

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};

use coaxle_test_process::until;
use coaxle_tests::retries;
use nodes::{Nodes, broken};
use python::Python;

/// Number of senders at a time: the machine may have two processors.
const AT_A_TIME: usize = 3;
/// Attempts at conditions that depend on time: the machine may be busy.
const ATTEMPTS: usize = 3;

/// Lock for one test at a time, as the machine may have two processors.
static TURN: Mutex<()> = Mutex::new(());

fn turn() -> MutexGuard<'static, ()> {
    TURN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Repeats the attempt until it succeeds. After the last one, panics with its message.
fn attempts(mut attempt: impl FnMut() -> Result<(), String>) {
    for n in 1.. {
        match attempt() {
            Ok(()) => return,
            Err(found) if n == ATTEMPTS => panic!("{found}"),
            Err(found) => {
                let thread = std::thread::current();
                // Repetitions are listed by `.ci/run`: one that is needed often is a fault.
                retries::note(thread.name().unwrap_or("conform"), &found);
            }
        }
    }
}

/// Checks that no rule is broken.
fn nothing(broken: &[String]) -> Result<(), String> {
    match broken {
        [] => Ok(()),
        rules => Err(rules.join(", ")),
    }
}

#[test]
fn our_own_sender_keeps_every_rule() {
    let _turn = turn();
    // A slow cycle, which a busy machine can keep.
    let sender = "cycle-time-us = 5000\n[[axis]]\nid = 3\nname = 'belt'\n[axis.program]\nstart-velocity = 10\n\
                  limits = { velocity = 100, acceleration = 100, jerk = 1000 }\nsteps = []\n";
    attempts(|| {
        let mut nodes = Nodes::default();
        nodes.start("sender", "belt", sender);
        let report = nodes.conform(&["sender", "belt", "--for", "3s"]);
        let found = broken(&report.json);
        // Both ways to say it must agree, whatever was found.
        let exit = if found.is_empty() { 0 } else { 3 };
        assert_eq!(report.exit, exit, "{report:?}");
        nothing(&found)?;
        assert_eq!(report.json["not-seen"], 0, "{report:?}");
        Ok(())
    });
}

#[test]
fn our_own_receiver_keeps_every_rule() {
    let _turn = turn();
    let receiver = "cycle-time-us = 5000\nmaster = { node = 'belt', axis = 3 }\n";
    attempts(|| {
        let mut nodes = Nodes::default();
        nodes.start("receiver", "saw", receiver);
        let report = nodes.conform(&["receiver", "saw"]);
        if !broken(&report.json).is_empty() || report.json["not-seen"] != 0 {
            return Err(format!("{report:?}"));
        }
        assert_eq!(report.exit, 0, "{report:?}");
        Ok(())
    });
}

#[test]
fn who_cannot_be_tried_is_told_and_nobody_is_no_data() {
    let _turn = turn();
    let mut nodes = Nodes::default();
    nodes.start(
        "receiver",
        "saw",
        "cycle-time-us = 5000\nmaster = { node = 'belt' }\n",
    );
    let wrong = nodes.conform(&["receiver", "saw", "--as", "press"]);
    assert_eq!(wrong.exit, 1, "{wrong:?}");
    assert!(
        wrong
            .log
            .contains("received --as press, expected one that it follows: belt"),
        "{wrong:?}"
    );
    // The receiver follows belt, and nobody publishes as belt.
    let silent = nodes.conform(&["sender", "belt", "--for", "1s"]);
    assert_eq!(silent.exit, 5, "{silent:?}");
    assert!(
        silent.log.contains("nothing came on coaxle/belt/axes"),
        "{silent:?}"
    );
}

#[test]
fn the_client_of_the_manual_keeps_every_rule_and_is_followed() {
    let Some(python) = Python::find() else {
        return;
    };
    let _turn = turn();
    attempts(|| {
        let mut nodes = Nodes::default();
        nodes.run(&python.script("client.py"), "arm", &["saw"]);
        nodes.start(
            "receiver",
            "saw",
            "cycle-time-us = 5000\nmaster = { node = 'arm' }\n",
        );
        let waited = nodes.run_tool(&["wait-sync", "saw", "--timeout", "60s"]);
        assert_eq!(waited.exit, 0, "{waited:?}");
        let report = nodes.conform(&["sender", "arm", "--for", "3s"]);
        nothing(&broken(&report.json))?;
        assert_eq!(report.json["not-seen"], 0, "{report:?}");
        until("it reads the receiver's status", || {
            nodes.printed("arm").contains("'received': ")
        });
        Ok(())
    });
}

#[test]
fn the_manual_shows_the_client_as_it_is() {
    let root = python::root();
    let read = |file: &str| std::fs::read_to_string(root.join(file)).expect(file);
    let (manual, client) = (read("docs/WIRE.md"), read("tests/python/client.py"));
    // A client in the manual that nobody runs would soon be wrong.
    assert!(
        manual.contains(&format!("```python\n{}\n```", client.trim_end())),
        "docs/WIRE.md has another client than tests/python/client.py"
    );
}

#[test]
fn each_planted_fault_is_found_and_nothing_besides() {
    let Some(python) = Python::find() else {
        return;
    };
    let _turn = turn();
    let faults: BTreeMap<String, String> = python.faults();
    // A script that fails lists nothing, and every fault would count as found.
    assert!(faults.len() >= 20, "{faults:?}");
    let mut due: VecDeque<_> = faults
        .into_iter()
        .map(|(fault, rule)| (Some(fault), vec![rule]))
        .collect();
    // Without a fault nothing may be found: the control.
    due.push_front((None, Vec::new()));
    let due = Mutex::new(due);
    let next = || {
        due.lock()
            .unwrap_or_else(PoisonError::into_inner)
            .pop_front()
    };
    let wrong = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..AT_A_TIME {
            scope.spawn(|| {
                while let Some((fault, rules)) = next() {
                    if let Err(found) = tried(&python, fault.as_deref(), &rules) {
                        let mut wrong = wrong.lock().unwrap_or_else(PoisonError::into_inner);
                        wrong.push(format!("{fault:?} breaks {rules:?}, found {found}"));
                    }
                }
            });
        }
    });
    let wrong = wrong.into_inner().unwrap_or_else(PoisonError::into_inner);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Checks that exactly these rules are found broken. The error has those that are.
fn tried(python: &Python, fault: Option<&str>, rules: &[String]) -> Result<(), String> {
    let mut told = String::new();
    for _ in 0..ATTEMPTS {
        let mut nodes = Nodes::default();
        let options: Vec<_> = fault
            .map(|fault| ["--fault", fault])
            .into_iter()
            .flatten()
            .collect();
        nodes.run(&python.script("faulty.py"), "arm", &options);
        let report = nodes.conform(&["sender", "arm", "--for", "4s"]);
        let found = broken(&report.json);
        // Exactly these: a fault that breaks further rules says that a rule is too broad.
        if found == rules {
            return Ok(());
        }
        told = format!("{found:?}: {report:?}");
        // A planted fault is found on a busy machine, too.
        if !rules.iter().all(|rule| found.contains(rule)) {
            break;
        }
        retries::note(
            "each_planted_fault_is_found",
            &format!("{found:?}, expected {rules:?}"),
        );
    }
    Err(told)
}
