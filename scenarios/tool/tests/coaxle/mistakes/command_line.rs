//! Mistakes on the command line, with the files, folders and disks that it names.

use crate::mistakes::{FAILED, WRONG_ARGUMENT, WRONG_FILE};

/// The command line, the exit code, and the line that it gives.
pub(crate) const ON_THE_COMMAND_LINE: &[(&str, i32, &str)] = &[
    (
        "run beet",
        WRONG_ARGUMENT,
        "received scenario \"beet\", expected a path ending in .toml or one of: …; did you mean \"beat\"?",
    ),
    (
        "run x.toml --set receiver.swa.mode=sync",
        WRONG_ARGUMENT,
        "x.toml: --set receiver.swa.mode=sync: received \"swa\", expected one of: saw",
    ),
    (
        "run x.toml --set duration=5",
        WRONG_FILE,
        "x.toml: duration: unknown field `duration`; did you mean \"duration-s\"?",
    ),
    (
        "run x.toml --set duration-s=-1",
        WRONG_FILE,
        "x.toml: duration-s: received -1, expected a number above 0, at most 1000000",
    ),
    (
        "run x.toml --receivers swa",
        WRONG_ARGUMENT,
        "--receivers: received \"swa\", expected some of: saw",
    ),
    (
        "sender none.toml --check",
        WRONG_FILE,
        "none.toml: cannot be read: No such file or directory (os error 2)",
    ),
    (
        "sender . --check",
        WRONG_FILE,
        ".: cannot be read: received a folder, expected a file",
    ),
    (
        "sender binary.toml --check",
        WRONG_FILE,
        "binary.toml: cannot be read: line 1: received bytes that are no UTF-8, expected UTF-8 text",
    ),
    (
        "sender s.toml --for 1s --trace no/such/t.csv",
        FAILED,
        "cannot write the trace file no/such/t.csv: No such file or directory (os error 2); is its folder there?",
    ),
    (
        "sender s.toml --for 1s --trace /dev/full",
        FAILED,
        "the recorder could not keep what it recorded: the trace file /dev/full is incomplete: No space left on device (os error 28); make room there, or name a place on another disk",
    ),
    (
        "run x.toml --out s.toml",
        FAILED,
        "cannot make the folder s.toml: File exists (os error 17); expected a name that is not taken",
    ),
    (
        "receiver s.toml --check",
        WRONG_FILE,
        "s.toml: received the config of a sender, expected the config of a receiver; for this one: coaxle sender s.toml",
    ),
    (
        "run x.toml --out /sys/results",
        FAILED,
        "cannot make the folder /sys/results: …; expected one that this user may use",
    ),
    (
        "sender s.toml --for 1s --record /sys/s.mcap",
        FAILED,
        "cannot write the recording /sys/s.mcap: …; expected one that this user may use",
    ),
    (
        "cam plot cam.toml -o /sys/cam.html",
        FAILED,
        "cannot write /sys/cam.html: …; expected one that this user may use",
    ),
    (
        "run jitter --set network.jitter.normal-us=5",
        WRONG_FILE,
        "jitter.toml: network.jitter: received exponential-us and normal-us, expected one of them alone",
    ),
    (
        "schema cam --out s.toml",
        FAILED,
        "cannot write s.toml/coaxle-cam.schema.json: …",
    ),
    (
        "receiver s.tml --check",
        WRONG_FILE,
        "s.tml: cannot be read: No such file or directory (os error 2)",
    ),
    (
        "cam values camm.toml",
        WRONG_FILE,
        "camm.toml: cannot be read: No such file or directory (os error 2); did you mean cam.toml?",
    ),
    (
        "receiver etc/saw.toml --check",
        WRONG_FILE,
        "etc/saw.toml: cannot be read: No such file or directory (os error 2); there is no folder etc",
    ),
    (
        "sender s.toml --for 1s --record /dev/full",
        FAILED,
        "cannot write the recording /dev/full: …; make room there, or name a place on another disk",
    ),
    (
        "recover taken.mcap --out s.toml",
        WRONG_FILE,
        "taken.mcap: received another file, expected a recording in MCAP",
    ),
    (
        "sender s.toml --for 1s --listen tcp/192.0.2.1:7447",
        FAILED,
        "cannot open the Zenoh session, … --listen tcp/0.0.0.0:7447",
    ),
    (
        "scope --page 192.0.2.1:7480",
        FAILED,
        "--page: cannot give out a page at 192.0.2.1:7480: Cannot assign requested address (os error 99); expected an address of this PC",
    ),
];
