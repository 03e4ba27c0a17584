//! A network that loses packets: another network namespace, joined to this one by a cable that drops some.

use std::io::ErrorKind;
use std::net::Ipv4Addr;
use std::process::{Command, Stdio};

use anyhow::{Context, bail};

/// Addresses of the cable's ends, set aside for measurements (RFC 2544).
pub(super) const HERE: Ipv4Addr = Ipv4Addr::new(198, 18, 0, 1);
pub(super) const THERE: Ipv4Addr = Ipv4Addr::new(198, 18, 0, 2);
// Four addresses: the two ends, the network and its broadcast.
const PREFIX: u8 = 30;

/// Chains of the far end, for incoming and outgoing packets.
// Both at the far end, so that this machine's own rules stay as they are.
const CHAINS: [&str; 2] = ["INPUT", "OUTPUT"];

/// The namespace, until it is dropped.
pub(super) struct NetworkNamespace {
    name: String,
}

impl NetworkNamespace {
    /// Creates a namespace, with a cable that loses nothing.
    ///
    /// # Errors
    /// The missing tool, permission or kernel feature.
    pub(super) fn new() -> anyhow::Result<Self> {
        // Measurements at the same time must not share a namespace.
        let number = std::process::id();
        let name = format!("coaxle-bench-{number}");
        // A name of a device has at most 15 letters.
        let (near, far) = (format!("cb{number}a"), format!("cb{number}b"));
        run("ip", &["netns", "add", &name])?;
        // From here on a failure drops the value, which deletes the namespace.
        let namespace = Self { name: name.clone() };
        let cable = ["link", "add", &near, "type", "veth", "peer", "name", &far];
        run("ip", &[&cable[..], &["netns", &name]].concat())?;
        let address = |address| format!("{address}/{PREFIX}");
        run("ip", &["address", "add", &address(HERE), "dev", &near])?;
        run("ip", &["link", "set", &near, "up"])?;
        namespace.within(&["ip", "address", "add", &address(THERE), "dev", &far])?;
        namespace.within(&["ip", "link", "set", &far, "up"])?;
        // A new namespace has its loopback switched off.
        namespace.within(&["ip", "link", "set", "lo", "up"])?;
        // A trial: a kernel without the statistic match is found now, and not after the first rounds.
        namespace.lose(0.5)?;
        namespace.lose(0.0)?;
        Ok(namespace)
    }

    /// Loses this share of all packets in each direction from now on.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(super) fn lose(&self, share: f64) -> anyhow::Result<()> {
        let share_text = format!("{share:.6}");
        for chain in CHAINS {
            // First all old rules go: two rules of one chain would both drop packets.
            self.within(&["iptables", "--flush", chain])?;
            if share > 0.0 {
                let drop = ["iptables", "--append", chain, "--match", "statistic"];
                let how = [
                    "--mode",
                    "random",
                    "--probability",
                    &share_text,
                    "--jump",
                    "DROP",
                ];
                self.within(&[&drop[..], &how].concat())?;
            }
        }
        Ok(())
    }

    /// Command line prefix that runs a program there.
    pub(super) fn prefix(&self) -> Vec<String> {
        ["ip", "netns", "exec", &self.name]
            .map(str::to_owned)
            .into()
    }

    fn within(&self, words: &[&str]) -> anyhow::Result<()> {
        let prefix = ["netns", "exec", &self.name];
        run("ip", &[&prefix[..], words].concat())
    }
}

impl Drop for NetworkNamespace {
    /// The cable is deleted with the namespace.
    fn drop(&mut self) {
        let _ = run("ip", &["netns", "delete", &self.name]);
    }
}

fn run(program: &str, words: &[&str]) -> anyhow::Result<()> {
    let mut command = Command::new(program);
    command.args(words).stdin(Stdio::null());
    let output = match command.output() {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            bail!("{program} is not installed")
        }
        output => output.with_context(|| format!("cannot start {program}"))?,
    };
    if output.status.success() {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let line = said.lines().find(|line| !line.trim().is_empty());
    let line = line.unwrap_or("it did not say why");
    bail!("{program} {}: {line}", words.join(" "))
}
