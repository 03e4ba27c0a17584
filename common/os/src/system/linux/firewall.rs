//! Firewall rules of Linux, as listed by `nft` and `iptables`. Those of ufw and firewalld are among them.

use std::io;
use std::ops::RangeInclusive;
use std::process::{Command, Stdio};

use crate::{AdmittedPorts, Firewall};

/// A program that lists rules, its arguments, and the parser of its output.
type List = (&'static str, &'static [&'static str], fn(&str) -> Firewall);

const LISTS: [List; 2] = [
    ("nft", &["list", "ruleset"], of_nft),
    ("iptables", &["-S"], of_iptables),
];
/// Folders of these programs; without rights they are not on the path.
const FOLDERS: [&str; 3] = ["", "/usr/sbin/", "/sbin/"];

/// Reads the rules in force.
pub(super) fn read() -> Result<Firewall, String> {
    let (mut known, mut reasons) = (None::<Firewall>, Vec::new());
    for (program, arguments, parse) in LISTS {
        match listed(program, arguments) {
            Ok(text) => {
                let mut found = parse(&text);
                found.sources.push(program.to_owned());
                known = Some(match known {
                    Some(known) => known.and(found),
                    None => found,
                });
            }
            Err(reason) => reasons.push(format!("{program}: {reason}")),
        }
    }
    // Both lists may be in use; either suffices, and reasons count only if none can be read.
    known.ok_or_else(|| reasons.join("; "))
}

fn listed(program: &str, arguments: &[&str]) -> Result<String, String> {
    let run = |folder: &&str| {
        let mut command = Command::new(format!("{folder}{program}"));
        command.args(arguments).stdin(Stdio::null()).output()
    };
    // Not found goes on to the next folder; any other failure is that of the program itself.
    let is_there =
        |ran: &io::Result<_>| !matches!(ran, Err(error) if error.kind() == io::ErrorKind::NotFound);
    let ran = FOLDERS.iter().map(run).find(is_there);
    match ran {
        None => Err("is not there".to_owned()),
        Some(Err(error)) => Err(error.to_string()),
        Some(Ok(output)) if output.status.success() => {
            Ok(String::from_utf8_lossy(&output.stdout).into_owned())
        }
        Some(Ok(output)) => {
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            let line = said.lines().find(|line| !line.trim().is_empty());
            Err(line.unwrap_or("it fails").trim().to_owned())
        }
    }
}

/// Parses tables of chains. `type filter hook input priority 0; policy drop;` is the head of a chain for
/// incoming packets; other chains are jumped to from there.
fn of_nft(text: &str) -> Firewall {
    let mut firewall = Firewall::default();
    let (mut sees_input, mut is_base) = (false, false);
    for line in text.lines().map(str::trim) {
        if line.starts_with("chain ") {
            // The head of a chain follows its name; without one it is a chain that is jumped to.
            (sees_input, is_base) = (false, false);
        } else if line.starts_with("type ") {
            is_base = true;
            sees_input = line.contains("hook input");
            firewall.drops |= sees_input && line.contains("policy drop");
        }
        let words: Vec<_> = line.split_whitespace().collect();
        let says = |word: &str| words.contains(&word);
        // A chain that is jumped to may belong to outgoing packets: then it drops nothing of ours.
        if sees_input && is_base && (says("drop") || says("reject")) && !line.starts_with("type ") {
            firewall.drops = true;
        }
        if says("accept")
            && let Some(at) = words.iter().position(|word| *word == "dport")
        {
            // `tcp dport 7447`: the word before says the protocol. At the start of a line there is none.
            let protocols = protocols(words.get(at.wrapping_sub(1)).copied());
            let ports = ports_of(&words[at + 1..]);
            firewall.admitted.extend(admitted(protocols, &ports));
        }
    }
    firewall
}

/// Parses `-P INPUT DROP`, `-A ufw-user-input -p tcp -m tcp --dport 7447 -j ACCEPT`.
fn of_iptables(text: &str) -> Firewall {
    let mut firewall = Firewall::default();
    for line in text.lines() {
        let words: Vec<_> = line.split_whitespace().collect();
        let behind = |flag: &str| {
            let at = words.iter().position(|word| *word == flag)?;
            words.get(at + 1).copied()
        };
        let target = behind("-j").unwrap_or_default();
        // Policy of the chain, or any rule in it that drops.
        firewall.drops |= words.starts_with(&["-P", "INPUT", "DROP"]);
        firewall.drops |=
            words.starts_with(&["-A", "INPUT"]) && matches!(target, "DROP" | "REJECT");
        let ports = behind("--dport").or_else(|| behind("--dports"));
        // From any chain: those of ufw are jumped to from INPUT.
        if let ("ACCEPT", Some(ports)) = (target, ports) {
            let ports = ports_of(&[ports]);
            firewall
                .admitted
                .extend(admitted(protocols(behind("-p")), &ports));
        }
    }
    firewall
}

/// Protocols of a rule: datagrams (true), streams (false), or both.
fn protocols(name: Option<&str>) -> &'static [bool] {
    match name {
        Some("tcp") => &[false],
        Some("udp") => &[true],
        _ => &[false, true],
    }
}

fn admitted(protocols: &[bool], ports: &[RangeInclusive<u16>]) -> Vec<AdmittedPorts> {
    let both = protocols
        .iter()
        .flat_map(|is_udp| ports.iter().map(|ports| (*is_udp, ports.clone())));
    both.map(|(is_udp, ports)| AdmittedPorts { is_udp, ports })
        .collect()
}

/// Parses `7447`, `{ 22, 7000-8000 }`, `22,7000:8000`; names of services are none of our ports.
fn ports_of(words: &[&str]) -> Vec<RangeInclusive<u16>> {
    let set = match words {
        ["{", rest @ ..] => {
            let end = rest.iter().position(|word| *word == "}");
            rest[..end.unwrap_or(rest.len())].join("")
        }
        [one, ..] => (*one).to_owned(),
        [] => String::new(),
    };
    let range = |text: &str| {
        let (first, last) = text.split_once(['-', ':']).unwrap_or((text, text));
        Some(first.parse().ok()?..=last.parse().ok()?)
    };
    set.split(',').filter_map(range).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_keeps_out_nothing() {
        for empty in [of_nft(""), of_iptables("-P INPUT ACCEPT\n-P OUTPUT ACCEPT")] {
            assert!(empty.admits(7447, false), "{empty:?}");
        }
    }

    #[test]
    fn what_nft_lists_keeps_out_what_no_rule_names() {
        let listed = of_nft(
            "table inet filter {\n\
             \tchain input {\n\
             \t\ttype filter hook input priority filter; policy drop;\n\
             \t\tct state established,related accept\n\
             \t\ttcp dport { 22, 7400-7449 } accept\n\
             \t\tudp dport 7460 counter packets 0 bytes 0 accept\n\
             \t}\n\
             }",
        );
        for (port, is_udp, admitted) in [
            (22, false, true),
            (7447, false, true),
            (7447, true, false),
            (7460, true, true),
            (7450, false, false),
        ] {
            assert_eq!(listed.admits(port, is_udp), admitted, "{port}");
        }
        let outgoing =
            of_nft("chain output {\ntype filter hook output priority 0; policy drop;\n}");
        assert!(outgoing.admits(7447, false));
    }

    #[test]
    fn what_iptables_lists_keeps_out_what_no_rule_names() {
        let listed = of_iptables(
            "-P INPUT DROP\n-P FORWARD DROP\n\
             -A ufw-user-input -p tcp -m tcp --dport 7447 -j ACCEPT\n\
             -A ufw-user-input -p tcp -m multiport --dports 80,7500:7510 -j ACCEPT\n\
             -A ufw-user-input -p udp -m udp --dport 7448 -j DROP",
        );
        for (port, is_udp, admitted) in [
            (7447, false, true),
            (7447, true, false),
            (7505, false, true),
            (7448, true, false),
        ] {
            assert_eq!(listed.admits(port, is_udp), admitted, "{port}");
        }
        let rejecting = of_iptables("-P INPUT ACCEPT\n-A INPUT -j REJECT --reject-with icmp-port");
        assert!(!rejecting.admits(7447, false));
    }

    #[test]
    fn it_is_read_or_it_is_said_why_not() {
        match read() {
            Ok(found) => assert!(!found.sources.is_empty()),
            Err(reason) => assert!(reason.contains("nft: "), "{reason}"),
        }
    }
}
