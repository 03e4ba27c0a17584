//! `coaxle doctor`: fitness of a PC for cycles, openings in the configs of nodes with their remedies, and circles
//! of nodes that follow each other.

mod circles;
mod ports;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use clap::Args;
use coaxle_clock::Span;
use coaxle_host::cli::parse_duration;
use coaxle_host::machine::fitness::{self, Finding, Severity};
use coaxle_host::network::credentials::{Credentials, KEY_FILE, PROFILE_FILE, RENEW_WITHIN, date};
use coaxle_host::network::transport::{Exposure, is_local};
use coaxle_node::keys::NodeName;
use coaxle_node::lab::LabFields;
use coaxle_os::machine;
use coaxle_os::{Firewall, Os, System};
use coaxle_report::inspect;

use crate::node_config::NodeConfig;
use crate::secure::{AUTHORITY_FOLDER, AUTHORITY_KEY_FILE};
use ports::of_ports;

/// Arguments of `coaxle doctor`.
#[derive(Debug, Args)]
pub struct DoctorArgs {
    /// Config files of senders and receivers: what they leave open to others, whether they follow each other in a circle, and
    /// whether one injects or simulates anything [default: this PC, and how late it wakes a thread]
    #[arg(value_name = "CONFIG")]
    configs: Vec<PathBuf>,
    /// Wake a thread for this time
    #[arg(long, value_name = "DURATION", default_value = "5s", value_parser = parse_duration, conflicts_with = "configs")]
    measure: Span,
    /// … with this cycle …
    #[arg(long, value_name = "DURATION", default_value = "1ms", value_parser = parse_duration, conflicts_with = "configs")]
    cycle: Span,
    /// … and this real-time priority, if it is permitted; 0: none
    #[arg(long, value_name = "N", default_value_t = 80, value_parser = clap::value_parser!(u8).range(0..=99), conflicts_with = "configs")]
    priority: u8,
}

/// Longer messages than any that a node sends.
// Frames have at most 20 KiB, orders with a plate 1 MiB. Zenoh's own default is 1 GiB.
const LONG_MESSAGE: u64 = 16 << 20;

/// Prints this PC's obstacles to nodes. With configs: what is open in each of them, what others do not reach, and the
/// circles over these nodes. False if any is found.
///
/// # Errors
/// A config that no node would start with.
pub fn print(args: &DoctorArgs) -> anyhow::Result<bool> {
    if args.configs.is_empty() {
        return print_fitness(args);
    }
    let now = machine::wall_clock();
    // Read once for all configs, as they are of one PC.
    let firewall = Os::firewall();
    let (mut examined, mut configs) = (Vec::new(), Vec::new());
    for file in &args.configs {
        let config = NodeConfig::load(file)?;
        let findings = examine(file, &config, now, &firewall)?;
        examined.push((file.display().to_string(), findings));
        configs.push(config);
    }
    // After all are read: a circle is over several nodes, and none of them shows it alone.
    let circles = circles::among(&configs);
    inspect::print(|out| {
        for (file, findings) in &examined {
            write_findings(file, findings, out)?;
        }
        for circle in &circles {
            writeln!(out, "circle: 0x816f: {circle}\n    {BREAK}")?;
        }
        let all = examined.iter().flat_map(|(_, findings)| findings);
        Ok(circles.is_empty() && !all.into_iter().any(ConfigFinding::is_bad))
    })
}

/// Settings of this PC that matter, and how late a thread is woken.
fn print_fitness(args: &DoctorArgs) -> anyhow::Result<bool> {
    let found = fitness::examine();
    inspect::print(|out| {
        for finding in &found {
            write_finding(finding, out)?;
        }
        // The wake-ups take seconds, and the first findings should be seen meanwhile.
        out.flush()?;
        // Priorities of SCHED_FIFO begin at 1.
        let priority = (args.priority > 0).then_some(args.priority);
        let late = fitness::wake_ups(args.cycle, args.measure, priority)?;
        for denied in &late.denied {
            writeln!(out, "note: {} not granted: {}", denied.wish, denied.reason)?;
        }
        writeln!(
            out,
            "wake-ups: {} of {}: half within {}, 999 of 1000 within {}, all within {}; {} missed a whole cycle",
            late.count, args.cycle, late.median, late.nearly_all, late.most, late.missed
        )?;
        let verdict = late.judge(args.cycle);
        write_finding(&verdict, out)?;
        let mut all = found.iter().chain([&verdict]);
        Ok(!all.any(|finding| finding.severity == Severity::Unfit))
    })
}

fn write_finding(finding: &Finding, out: &mut dyn Write) -> anyhow::Result<()> {
    let mark = match finding.severity {
        Severity::Good => "good",
        Severity::Note => "note",
        Severity::Unfit => "against",
    };
    writeln!(out, "{mark}: {}", finding.text)?;
    Ok(finding
        .remedy
        .map_or(Ok(()), |remedy| writeln!(out, "    {remedy}"))?)
}

/// A finding about a config, for the operator of the node.
#[derive(Clone, Debug, PartialEq, Eq)]
struct ConfigFinding {
    kind: FindingKind,
    text: String,
    remedy: &'static str,
}

/// Kind of an opening.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FindingKind {
    /// Lets others in, or keeps the node itself out.
    Open,
    /// Keeps out those that are to come in.
    Shut,
    /// Injects faults or simulates inputs, as only an experiment does.
    Lab,
    /// Needs no change.
    Noted,
}

impl ConfigFinding {
    fn is_bad(&self) -> bool {
        self.kind != FindingKind::Noted
    }
}

fn open(text: String, remedy: &'static str) -> ConfigFinding {
    let kind = FindingKind::Open;
    ConfigFinding { kind, text, remedy }
}

fn shut(text: String, remedy: &'static str) -> ConfigFinding {
    let kind = FindingKind::Shut;
    ConfigFinding { kind, text, remedy }
}

fn note(text: &str, remedy: &'static str) -> ConfigFinding {
    let (kind, text) = (FindingKind::Noted, text.to_owned());
    ConfigFinding { kind, text, remedy }
}

fn write_findings(
    file: &str,
    findings: &[ConfigFinding],
    out: &mut dyn Write,
) -> anyhow::Result<()> {
    if !findings.iter().any(is_of_transport) {
        writeln!(out, "{file}: nothing is open")?;
    }
    for ConfigFinding { kind, text, remedy } in findings {
        let what = match kind {
            FindingKind::Open => "open",
            FindingKind::Shut => "shut",
            FindingKind::Lab => "lab",
            FindingKind::Noted => "note",
        };
        writeln!(out, "{file}: {what}: {text}\n    {remedy}")?;
    }
    Ok(())
}

fn examine(
    file: &Path,
    config: &NodeConfig,
    now: SystemTime,
    firewall: &Result<Firewall, String>,
) -> anyhow::Result<Vec<ConfigFinding>> {
    let mut transport = config.transport().clone();
    // Paths in a config are relative to it, not to where the tool is started.
    transport.relative_to(file.parent().unwrap_or(Path::new("")));
    let mut findings = Vec::from_iter(config.lab.as_ref().map(of_lab));
    // Before the exposure, whose profile is in this folder: a fault in it then has its reason already.
    if let Some(folder) = &transport.secure {
        findings.extend(of_folder(config.name(), folder, now));
    }
    match Exposure::of(&transport) {
        Ok(exposure) => {
            findings.extend(of_transport(&exposure));
            let mut listens = exposure.listens;
            let beacons = config.timing_listen().map(|at| format!("udp/{at}"));
            // Beacons bypass Zenoh, so its endpoints do not have their port.
            listens.extend(beacons.filter(|endpoint| !is_local(endpoint)));
            findings.extend(of_ports(&listens, firewall));
        }
        // The fault of the folder is among the findings already.
        Err(_) if findings.iter().any(is_of_transport) => {}
        Err(error) => return Err(error.context(file.display().to_string())),
    }
    Ok(findings)
}

fn is_of_transport(opening: &ConfigFinding) -> bool {
    matches!(opening.kind, FindingKind::Open | FindingKind::Shut)
}

/// A config of an experiment.
fn of_lab(fields: &LabFields) -> ConfigFinding {
    ConfigFinding {
        kind: FindingKind::Lab,
        text: format!("injected or simulated, no machine: {fields}"),
        remedy: "take [lab] out; the node refuses it without --lab",
    }
}

const BREAK: &str = "let one of them follow a sender's axis or a virtual axis";
const MAKE_SECURE: &str =
    "make the network secure with `coaxle secure init`, or stay on 127.0.0.1; docs/SECURE.md";

fn of_transport(exposure: &Exposure) -> Vec<ConfigFinding> {
    let mut findings = Vec::new();
    // Only endpoints beyond this machine are in these lists.
    let is_local = exposure.listens.is_empty() && exposure.connects.is_empty();
    let listens = exposure.without_mutual_tls(&exposure.listens);
    if !listens.is_empty() {
        let text = format!(
            "everybody who reaches {} commands this node and publishes as any other",
            listens.join(", ")
        );
        findings.push(open(text, MAKE_SECURE));
    }
    let connects = exposure.without_mutual_tls(&exposure.connects);
    if !connects.is_empty() {
        let text = format!(
            "any answer at {} is believed, and anybody on the way reads and changes everything",
            connects.join(", ")
        );
        findings.push(open(text, MAKE_SECURE));
    }
    // TLS alone lets every certificate of the authority do everything.
    if !exposure.denies_by_default && !is_local {
        let text = "no access control: everybody with a link may do everything".to_owned();
        findings.push(open(text, MAKE_SECURE));
    }
    if exposure.multicast {
        let text = "it looks for others by multicast, and takes whom it finds".to_owned();
        findings.push(open(
            text,
            "set multicast = false, and connect to endpoints",
        ));
    }
    if exposure.max_message_size > LONG_MESSAGE && !is_local {
        let text = format!(
            "messages of up to {} bytes are put together in memory before anything looks at them",
            exposure.max_message_size
        );
        let remedy = "settings = { \"transport/link/rx/max_message_size\" = 1048576 }, which the secure profile has";
        findings.push(open(text, remedy));
    }
    if is_local && !exposure.denies_by_default {
        findings.push(note(
            "it is reached from this PC alone, and any program on it may command it",
            "let nobody else log in there, or make the network secure",
        ));
    }
    findings
}

const COPY_ANEW: &str = "copy the whole folder anew from where `coaxle secure` wrote it";
const RENEW: &str = "`coaxle secure renew`, then copy the folder anew and start the node again";

fn of_folder(node: &NodeName, folder: &Path, now: SystemTime) -> Vec<ConfigFinding> {
    let mut findings = Vec::new();
    match Credentials::open(folder) {
        Ok(credentials) => findings.extend(of_credentials(node, &credentials, now)),
        Err(error) => findings.push(open(error.to_string(), COPY_ANEW)),
    }
    let others = |file: &str| Os::permissions_of_others(&folder.join(file));
    // Reading is enough to be that node.
    if others(KEY_FILE).is_some_and(|others| others.access) {
        let key = folder.join(KEY_FILE);
        let text = format!("other users of this PC may read {}", key.display());
        findings.push(open(
            text,
            "chmod 600, and renew the certificate if anybody may have",
        ));
    }
    // The profile holds no secret, but writing it is granting rights.
    if others(PROFILE_FILE).is_some_and(|others| others.write) {
        let profile = folder.join(PROFILE_FILE);
        let text = format!("other users of this PC may write {}", profile.display());
        findings.push(open(text, "chmod 644"));
    }
    let beside = folder
        // Where `coaxle secure` writes it: the folders of a network lie side by side.
        .with_file_name(AUTHORITY_FOLDER)
        .join(AUTHORITY_KEY_FILE);
    if beside.is_file() {
        findings.push(note(
            "the key of the authority is on this PC: who has it can be anybody",
            "keep that folder elsewhere, where no node runs",
        ));
    }
    findings
}

fn of_credentials(
    node: &NodeName,
    credentials: &Credentials,
    now: SystemTime,
) -> Option<ConfigFinding> {
    // First the name: another node's folder may be valid and would deny everything.
    if credentials.name() != node {
        let text = format!(
            "the certificate is of {:?}, and the node is {:?}",
            credentials.name().as_str(),
            node.as_str()
        );
        return Some(open(text, "name the node's own folder"));
    }
    if let Err(fault) = credentials.check(now) {
        return Some(open(fault.to_string(), RENEW));
    }
    // Checked again at a later time: only the end of the certificate can make the difference.
    let soon = credentials.check(now + RENEW_WITHIN).is_err();
    let end = date(credentials.not_after());
    soon.then(|| open(format!("the certificate holds until {end} only"), RENEW))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::secure::write_role;
    use coaxle_host::network::credentials::{Authority, Validity};
    use coaxle_os::Readers;
    use std::time::Duration;

    const DAY: Duration = Duration::from_secs(24 * 60 * 60);

    fn examined(folder: &Path, transport: &str, days_later: u32) -> Vec<String> {
        let file = folder.join("saw.toml");
        let text = format!(
            "name = 'saw'\ncycle-time-us = 1000\nmaster = {{ node = 'line' }}\n[transport]\n{transport}"
        );
        std::fs::write(&file, text).unwrap();
        let now = machine::wall_clock() + DAY * days_later;
        let firewall = Ok(Firewall::default());
        let config = NodeConfig::load(&file).unwrap();
        let open = examine(&file, &config, now, &firewall).unwrap().into_iter();
        let open = open.filter(ConfigFinding::is_bad);
        open.map(|finding| finding.text).collect()
    }

    fn assert_found(found: &[String], expected: &[&str]) {
        let fits = found.len() == expected.len()
            && found
                .iter()
                .zip(expected)
                .all(|(found, part)| found.contains(part));
        assert!(fits, "{found:?} but expected {expected:?}");
    }

    #[test]
    fn beacons_that_a_firewall_keeps_out_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("belt.toml");
        let firewall = Ok(Firewall {
            drops: true,
            ..Firewall::default()
        });
        for (listen, found) in [("0.0.0.0:7450", 1), ("127.0.0.1:7450", 0)] {
            let axis = "[[axis]]\nid = 1\nname = 'belt'\nprogram = { limits = { velocity = 1, acceleration = 1, jerk = 1 }, steps = [] }\n";
            let head = format!(
                "name = 'belt'\ncycle-time-us = 1000\ntiming = {{ listen = '{listen}' }}\n"
            );
            std::fs::write(&file, head + axis).unwrap();
            let config = NodeConfig::load(&file).unwrap();
            let findings = examine(&file, &config, machine::wall_clock(), &firewall).unwrap();
            let shut = findings
                .iter()
                .filter(|opening| opening.text.contains("udp port 7450"));
            assert_eq!(shut.count(), found, "{listen}");
        }
    }

    #[test]
    fn a_config_of_an_experiment_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let found = examined(
            folder.path(),
            "listen = ['tcp/127.0.0.1:7448']\n[lab]\nclock.drift-ppm = -300",
            0,
        );
        assert_found(&found, &["no machine: lab.clock.drift-ppm = -300"]);
    }

    #[test]
    fn what_a_plain_network_leaves_open_is_named() {
        let folder = tempfile::tempdir().unwrap();
        for (transport, expected) in [
            ("listen = ['tcp/127.0.0.1:7448']", &[][..]),
            (
                "listen = ['tcp/0.0.0.0:7448']",
                &[
                    "everybody who reaches tcp/0.0.0.0:7448",
                    "no access control",
                    "1073741824 bytes",
                ],
            ),
            (
                "connect = ['tcp/10.0.0.1:7448']\nmulticast = true",
                &[
                    "everybody who reaches tcp/[::]:0",
                    "any answer at tcp/10.0.0.1:7448",
                    "no access control",
                    "multicast",
                    "bytes",
                ],
            ),
        ] {
            assert_found(&examined(folder.path(), transport, 0), expected);
        }
    }

    #[test]
    fn what_is_wrong_with_a_secure_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let saw = NodeName::new("saw").unwrap();
        let now = machine::wall_clock();
        let year = Validity::days(now, 365);
        let (ours, theirs) = (Authority::new(year).unwrap(), Authority::new(year).unwrap());
        let profile = "{ transport: { link: { rx: { max_message_size: 1000 }, tls: { enable_mtls: true } } }, \
            access_control: { enabled: true, default_permission: 'deny', rules: [], subjects: [], policies: [] } }";
        let write = |name: &NodeName, by: &Authority| {
            let issued = by.issue(name, &[], Validity::days(now, 90)).unwrap();
            write_role(&folder.join("net"), &ours, &issued, profile).unwrap();
        };
        let secure =
            "secure = 'net'\nlisten = ['tls/0.0.0.0:7448']\nconnect = ['tls/10.0.0.1:7447']";
        assert_found(&examined(folder, secure, 0), &["net/ca.pem"]);
        write(&saw, &ours);
        assert_found(&examined(folder, secure, 0), &[]);
        assert_found(&examined(folder, secure, 59), &[]);
        assert_found(&examined(folder, secure, 61), &["holds until"]);
        assert_found(&examined(folder, secure, 91), &["has expired"]);
        let key = folder.join("net").join(KEY_FILE);
        let text = std::fs::read_to_string(&key).unwrap();
        let mut readable = Os::create_file(&key, Readers::All).unwrap();
        readable.write_all(text.as_bytes()).unwrap();
        assert_found(&examined(folder, secure, 0), &["may read"]);
        write(&saw, &theirs);
        assert_found(&examined(folder, secure, 0), &["another authority"]);
        write(&NodeName::new("press").unwrap(), &ours);
        assert_found(&examined(folder, secure, 0), &["is of \"press\""]);
    }
}
