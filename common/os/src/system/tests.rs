//! Properties of every system, and of the one this was built for.

use std::process::Command;
use std::sync::mpsc;

use super::{Os, Portable, Readers, System};

#[test]
fn nobody_wakes_early() {
    fn check<S: System>() {
        // Past, now, less than a wake-up takes, and a few milliseconds.
        for after in [-1_000_000_000, 0, 300, 3_000_000] {
            let deadline = S::clock_ns() + after;
            S::sleep_until_ns(deadline);
            assert!(S::clock_ns() >= deadline);
        }
        S::sleep_until_ns(i64::MIN);
    }
    check::<Os>();
    check::<Portable>();
}

#[test]
fn wishes_that_nobody_can_grant_have_a_reason() {
    fn check<S: System>() {
        // SCHED_FIFO begins at 1, and no machine has a million processors.
        let refused = [S::set_priority(0), S::bind_to(1_000_000)];
        assert!(refused.iter().all(Result::is_err), "{refused:?}");
    }
    check::<Os>();
    check::<Portable>();
}

/// Only if it may be given a priority at all.
#[cfg(target_os = "linux")]
#[test]
fn a_thread_hands_its_priority_on_and_drops_it() {
    fn priority_of(name: &str) -> Option<u8> {
        Os::priorities()
            .into_iter()
            .find(|(of, _)| of == name)
            .map(|(_, priority)| priority)
    }
    std::thread::Builder::new()
        // A name with a parenthesis, by which the fields of `stat` are separated.
        .name("raised (1)".to_owned())
        .spawn(move || {
            if let Err(reason) = Os::set_priority(3) {
                assert!(reason.contains("CAP_SYS_NICE"), "{reason}");
                return;
            }
            // A thread has its name only once it runs itself, and is listed until it ends.
            let (runs, until_it_runs) = mpsc::channel();
            let (may_end, until_it_may_end) = mpsc::channel::<()>();
            let inherits = std::thread::Builder::new()
                .name("inherits".to_owned())
                .spawn(move || {
                    runs.send(()).unwrap();
                    until_it_may_end.recv().unwrap_err();
                });
            until_it_runs.recv().unwrap();
            assert_eq!(priority_of("raised (1)"), Some(3));
            assert_eq!(priority_of("inherits"), Some(3));
            Os::drop_priority().unwrap();
            assert_eq!(priority_of("raised (1)"), None);
            drop(may_end);
            inherits.unwrap().join().unwrap();
        })
        .unwrap()
        .join()
        .unwrap();
}

#[test]
fn files_are_made_emptied_and_held() {
    fn check<S: System>() {
        let scratch = tempfile::tempdir().unwrap();
        let folder = scratch.path().join("a/b");
        S::make_private_folder(&folder).unwrap();
        let file = folder.join("key");
        std::fs::write(&file, "old").unwrap();
        let made = S::create_file(&file, Readers::Owner).unwrap();
        assert_eq!(made.metadata().unwrap().len(), 0);
        // Systems without permissions report none, and promise nothing.
        assert!(S::permissions_of_others(&file).is_none_or(|others| !others.access));
        S::create_file(&file, Readers::All).unwrap();
        assert!(
            S::permissions_of_others(&file).is_none_or(|others| others.access && !others.write)
        );
        assert!(S::hold_folder(&folder).unwrap().is_some());
        S::hold_folder(&file.join("x")).unwrap_err();
        let kind = |path| S::kind_of(&std::fs::symlink_metadata(path).unwrap());
        assert_eq!((kind(&file), kind(&folder)), (None, Some("a folder")));
    }
    check::<Os>();
    check::<Portable>();
}

#[test]
fn the_program_that_runs_can_be_read() {
    fn check<S: System>() -> u64 {
        S::own_program().unwrap().metadata().unwrap().len()
    }
    assert!(check::<Os>() > 1_000);
    assert_eq!(check::<Os>(), check::<Portable>());
}

#[test]
fn what_a_system_does_not_have_is_an_error() {
    let scratch = tempfile::tempdir().unwrap();
    let refused = Portable::open_shared_file(&scratch.path().join("drive"), true).unwrap_err();
    assert_eq!(refused.kind(), std::io::ErrorKind::Unsupported);
    assert!(refused.to_string().contains("memory"), "{refused}");
    let error = Portable::replace_this_process(&mut Command::new("none"));
    assert_eq!(error.kind(), std::io::ErrorKind::Unsupported);
}

#[cfg(target_os = "linux")]
#[test]
fn this_process_has_memory_and_none_has_number_zero() {
    assert!(Os::resident_memory(std::process::id()).is_some_and(|bytes| bytes > 1 << 20));
    assert_eq!(Os::resident_memory(0), None);
    let time = || Os::processor_time(std::process::id()).unwrap();
    let before = time();
    // Processor time is counted in ticks of mostly 10 ms.
    while time() == before {
        std::hint::spin_loop();
    }
    assert_eq!(Os::processor_time(0), None);
}
