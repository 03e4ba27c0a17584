//! Answers to the questions: by options, at a terminal, or as usual.

use std::io::BufRead;
use std::net::IpAddr;

use clap::ValueEnum;
use coaxle_host::network::transport::is_local;
use coaxle_node::keys::NodeName;
use coaxle_report::inspect;

use super::FollowerTask;

/// A node, and the address of its PC.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct PlacedNode {
    pub(super) name: NodeName,
    pub(super) host: String,
}

/// Address of a PC that only its own nodes reach.
const HERE: &str = "127.0.0.1";

impl PlacedNode {
    /// Reads `NAME` or `NAME@HOST`.
    ///
    /// # Errors
    /// Words for the mistake, and for what is expected.
    pub(super) fn read(text: &str) -> Result<Self, String> {
        let (name, host) = text.split_once('@').unwrap_or((text, HERE));
        Ok(Self {
            name: name_of(name)?,
            host: host_of(host)?,
        })
    }

    /// True if it is on this PC alone.
    pub(super) fn is_local(&self) -> bool {
        is_local(&self.endpoint("tcp", 0))
    }

    /// Endpoint at which others reach it.
    pub(super) fn endpoint(&self, protocol: &str, port: u16) -> String {
        match self.host.parse() {
            Ok(IpAddr::V6(address)) => format!("{protocol}/[{address}]:{port}"),
            _ => format!("{protocol}/{}:{port}", self.host),
        }
    }
}

fn name_of(text: &str) -> Result<NodeName, String> {
    NodeName::new(text).map_err(|error| error.to_string())
}

fn host_of(text: &str) -> Result<String, String> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || ".-_:".contains(c);
    let is_host = !text.is_empty() && text.chars().all(is_part);
    let is_host = is_host && (!text.contains(':') || text.parse::<IpAddr>().is_ok());
    match is_host {
        true => Ok(text.to_owned()),
        false => Err(format!(
            "received the address {text:?}, expected that of a PC, such as 192.168.1.10 or saw.local, without a port"
        )),
    }
}

/// Reads yes or no.
///
/// # Errors
/// Words for what is expected.
pub(super) fn yes_or_no(text: &str) -> Result<bool, String> {
    match text {
        "yes" | "y" => Ok(true),
        "no" | "n" => Ok(false),
        _ => Err("expected yes or no".to_owned()),
    }
}

/// Asks for what no option says.
#[derive(Debug)]
pub(super) struct Interview {
    /// True at a terminal: nobody else answers.
    asks: bool,
}

impl Interview {
    pub(super) const fn new(asks: bool) -> Self {
        Self { asks }
    }

    pub(super) fn node(
        &self,
        given: Option<&PlacedNode>,
        does: &str,
        usual: &str,
    ) -> anyhow::Result<PlacedNode> {
        if let Some(given) = given {
            return Ok(given.clone());
        }
        let name = self.ask(&format!("Name of the node that {does}"), usual, name_of)?;
        let question = format!("Address of its PC ({HERE}: this one alone)");
        let host = self.ask(&question, HERE, host_of)?;
        Ok(PlacedNode { name, host })
    }

    pub(super) fn task(&self, given: Option<FollowerTask>) -> anyhow::Result<FollowerTask> {
        let read = |text: &str| FollowerTask::from_str(text, true);
        match given {
            Some(task) => Ok(task),
            None => self.ask("What follows: gear, saw or watch", "gear", read),
        }
    }

    pub(super) fn secure(&self, given: Option<bool>, usual: bool) -> anyhow::Result<bool> {
        let question = "Certificates for both, and nobody else is let in: yes or no";
        match given {
            Some(secure) => Ok(secure),
            None => self.ask(question, if usual { "yes" } else { "no" }, yes_or_no),
        }
    }

    /// Asks until an answer can be read; an empty one is the usual.
    fn ask<T>(
        &self,
        question: &str,
        usual: &str,
        read: impl Fn(&str) -> Result<T, String>,
    ) -> anyhow::Result<T> {
        let usual_of = || read(usual).map_err(anyhow::Error::msg);
        if !self.asks {
            return usual_of();
        }
        loop {
            inspect::print(|out| {
                write!(out, "{question} [{usual}]: ")?;
                out.flush()?;
                Ok(true)
            })?;
            let mut line = String::new();
            std::io::stdin().lock().read_line(&mut line)?;
            match line.trim() {
                // At its end, the input answers no more questions.
                "" => return usual_of(),
                answer => match read(answer) {
                    Ok(value) => return Ok(value),
                    Err(why) => inspect::print_text(&why)?,
                },
            }
        }
    }
}
