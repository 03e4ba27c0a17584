//! Mistakes on the command line, with what it names: files, folders, disks.

/// The command line, and the line that it gives.
pub(crate) const ON_THE_COMMAND_LINE: &[(&str, &str)] = &[
    (
        "run beet",
        "received scenario \"beet\", expected a path ending in .toml or one of: …; did you mean \"beat\"?",
    ),
    (
        "run x.toml --set receiver.swa.mode=sync",
        "x.toml: --set receiver.swa.mode=sync: received \"swa\", expected one of: saw",
    ),
    (
        "run x.toml --set duration=5",
        "x.toml: duration: unknown field `duration`; did you mean \"duration-s\"?",
    ),
    (
        "run x.toml --set duration-s=-1",
        "x.toml: duration-s: received -1, expected a number above 0, at most 1000000",
    ),
    (
        "run x.toml --receivers swa",
        "--receivers: received \"swa\", expected some of: saw",
    ),
    (
        "sender none.toml --check",
        "none.toml: cannot be read: No such file or directory (os error 2)",
    ),
    (
        "sender . --check",
        ".: cannot be read: received a folder, expected a file",
    ),
    (
        "sender binary.toml --check",
        "binary.toml: cannot be read: line 1: received bytes that are no UTF-8, expected UTF-8 text",
    ),
    (
        "sender s.toml --for 1s --trace no/such/t.csv",
        "cannot write the trace file no/such/t.csv: No such file or directory (os error 2)",
    ),
    (
        "sender s.toml --for 1s --trace /dev/full",
        "the recorder could not keep what it recorded: the trace file /dev/full is incomplete: No space left on device (os error 28)",
    ),
    (
        "run x.toml --out s.toml",
        "cannot make the folder s.toml: File exists (os error 17)",
    ),
    (
        "receiver s.toml --check",
        "s.toml:7:3: axis: unknown field `axis`, expected one of …",
    ),
    (
        "run x.toml --out /sys/results",
        "cannot make the folder /sys/results: …; expected one that this user may use",
    ),
    (
        "sender s.toml --for 1s --record /sys/s.mcap",
        "cannot write the recording /sys/s.mcap: …; expected one that this user may use",
    ),
    (
        "cam plot cam.toml -o /sys/cam.html",
        "cannot write /sys/cam.html: …; expected one that this user may use",
    ),
    (
        "run jitter --set network.jitter.normal-us=5",
        "jitter.toml: network.jitter: received exponential-us and normal-us, expected one of them alone",
    ),
    (
        "schema cam --out s.toml",
        "cannot write s.toml/coaxle-cam.schema.json: …",
    ),
];
