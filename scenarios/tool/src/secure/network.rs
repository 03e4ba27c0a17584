//! Network of nodes and operators.

use coaxle_host::client::PAGE;
use coaxle_node::config::Wrong;
use coaxle_node::keys::NodeName;

use super::folder::AUTHORITY_FOLDER;
use super::hosts::Addresses;
use super::member::{Member, Operator};

/// The nodes and the operators of a network.
#[derive(Clone, Debug)]
pub struct SecureNetwork {
    pub(super) nodes: Vec<Member>,
    pub(super) operators: Vec<Operator>,
    pub(super) addresses: Addresses,
}

impl SecureNetwork {
    /// Puts a network together; `given` are addresses of nodes besides those of the configs.
    ///
    /// # Errors
    /// [`Wrong`]: the member that is missing or there twice.
    pub fn new(
        nodes: Vec<Member>,
        operators: Vec<Operator>,
        given: &[(NodeName, String)],
    ) -> Result<Self, Wrong> {
        let mut names: Vec<&NodeName> = nodes.iter().map(|node| &node.name).collect();
        names.extend(operators.iter().map(|operator| &operator.name));
        // Nodes and operators together: both names are those of certificates, and of folders.
        names.sort();
        if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            let received = format!("the name {:?} twice", pair[0].as_str());
            let expected = "one of its own for each node and operator";
            return Err(Wrong::value(received, expected));
        }
        if names.iter().any(|name| name.as_str() == AUTHORITY_FOLDER) {
            let received = format!("the name {AUTHORITY_FOLDER:?}");
            let expected = "another: the folder of that name is the authority's";
            return Err(Wrong::value(received, expected));
        }
        if operators
            .iter()
            .any(|operator| operator.name.as_str() == PAGE)
        {
            let received = format!("the name {PAGE:?}");
            let expected = "another: a node logs orders of its own page under that name";
            return Err(Wrong::of("operator", received, expected));
        }
        // Without the config of a followed node its addresses and rights are unknown.
        check_followed(&nodes)?;
        check_commanded(&nodes, &operators)?;
        // Last, as its errors name nodes that must be unique and complete.
        let addresses = Addresses::of(&nodes, given)?;
        Ok(Self {
            nodes,
            operators,
            addresses,
        })
    }

    /// Nodes of the network.
    #[must_use]
    pub fn nodes(&self) -> &[Member] {
        &self.nodes
    }

    /// Operators of the network.
    #[must_use]
    pub fn operators(&self) -> &[Operator] {
        &self.operators
    }

    /// Addresses of the nodes.
    #[must_use]
    pub const fn addresses(&self) -> &Addresses {
        &self.addresses
    }
}

fn check_followed(nodes: &[Member]) -> Result<(), Wrong> {
    for node in nodes {
        for followed in &node.wiring.subscriptions {
            if !nodes.iter().any(|other| other.name == followed.node) {
                let reason = format!(
                    "hears node {:?}, expected its config among those given",
                    followed.node.as_str()
                );
                return Err(Wrong::with_reason(
                    format!("node {:?}", node.name.as_str()),
                    reason,
                ));
            }
        }
    }
    Ok(())
}

fn check_commanded(nodes: &[Member], operators: &[Operator]) -> Result<(), Wrong> {
    let names: Vec<&str> = nodes.iter().map(|node| node.name.as_str()).collect();
    for operator in operators {
        for node in &operator.nodes {
            if !names.contains(&node.as_str()) {
                let field = format!("operator {:?}", operator.name.as_str());
                let received = format!("the node {:?}", node.as_str());
                let expected = format!("some of: {}", names.join(", "));
                return Err(Wrong::of(field, received, expected));
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::secure::samples::{LINE, SAW, member, operator};

    fn refusal(nodes: &[&str], operators: &[&str]) -> String {
        let nodes = nodes.iter().map(|text| member(text)).collect();
        let operators = operators.iter().map(|text| operator(text)).collect();
        SecureNetwork::new(nodes, operators, &[])
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn members_are_there_once_and_whole() {
        for (nodes, operators, expected) in [
            (&[LINE, LINE][..], &[][..], "\"line\" twice"),
            (&[LINE], &["line"], "\"line\" twice"),
            (&[LINE], &["authority"], "expected another"),
            (
                &[SAW],
                &[],
                "node \"saw\": hears node \"line\", expected its config",
            ),
            (
                &[LINE],
                &["anna=line,press"],
                "\"press\", expected some of: line",
            ),
        ] {
            let message = refusal(nodes, operators);
            assert!(message.contains(expected), "{message}");
        }
    }
}
