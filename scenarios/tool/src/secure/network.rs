//! Network of nodes and operators.

use coaxle_host::client::PAGE;
use coaxle_node::keys::NodeName;

use super::folder::AUTHORITY_FOLDER;
use super::hosts::{Addresses, WrongNodeAddress};
use super::member::{Member, Operator};

/// The nodes and the operators of a network.
#[derive(Clone, Debug)]
pub struct SecureNetwork {
    pub(super) nodes: Vec<Member>,
    pub(super) operators: Vec<Operator>,
    pub(super) addresses: Addresses,
}

/// Members that make no network.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WrongNetwork {
    /// Two members share a name.
    #[error("received the name {0:?} twice, expected one of its own for each node and operator")]
    Duplicate(String),
    /// A reserved name.
    #[error(
        "received the name {AUTHORITY_FOLDER:?}, expected another: the folder of that name is the authority's"
    )]
    Reserved,
    /// An operator with the name of nodes' own pages.
    #[error(
        "operator: received the name {PAGE:?}, expected another: a node logs orders of its own page under that name"
    )]
    NameOfPages,
    /// A node follows one whose config is missing.
    #[error("node {follower:?} hears node {followed:?}, expected its config among those given")]
    Missing {
        /// The follower.
        follower: String,
        /// The followed node.
        followed: String,
    },
    /// An operator of a node that is not there.
    #[error("operator {operator:?}: received the node {node:?}, expected some of: {known}")]
    UnknownNode {
        /// The operator.
        operator: String,
        /// Name of that node.
        node: String,
        /// Known nodes.
        known: String,
    },
    /// An address cannot be determined.
    #[error(transparent)]
    Address(#[from] WrongNodeAddress),
}

impl SecureNetwork {
    /// Puts a network together; `given` are addresses of nodes besides those of the configs.
    ///
    /// # Errors
    /// [`WrongNetwork`]: the member that is missing or there twice.
    pub fn new(
        nodes: Vec<Member>,
        operators: Vec<Operator>,
        given: &[(NodeName, String)],
    ) -> Result<Self, WrongNetwork> {
        let mut names: Vec<&NodeName> = nodes.iter().map(|node| &node.name).collect();
        names.extend(operators.iter().map(|operator| &operator.name));
        // Nodes and operators together: both names are those of certificates, and of folders.
        names.sort();
        if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(WrongNetwork::Duplicate(pair[0].to_string()));
        }
        if names.iter().any(|name| name.as_str() == AUTHORITY_FOLDER) {
            return Err(WrongNetwork::Reserved);
        }
        if operators
            .iter()
            .any(|operator| operator.name.as_str() == PAGE)
        {
            return Err(WrongNetwork::NameOfPages);
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

fn check_followed(nodes: &[Member]) -> Result<(), WrongNetwork> {
    for node in nodes {
        for followed in &node.wiring.subscriptions {
            if !nodes.iter().any(|other| other.name == followed.node) {
                return Err(WrongNetwork::Missing {
                    follower: node.name.to_string(),
                    followed: followed.node.to_string(),
                });
            }
        }
    }
    Ok(())
}

fn check_commanded(nodes: &[Member], operators: &[Operator]) -> Result<(), WrongNetwork> {
    let names: Vec<&str> = nodes.iter().map(|node| node.name.as_str()).collect();
    for operator in operators {
        for node in &operator.nodes {
            if !names.contains(&node.as_str()) {
                return Err(WrongNetwork::UnknownNode {
                    operator: operator.name.to_string(),
                    node: node.to_string(),
                    known: names.join(", "),
                });
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
                "\"saw\" hears node \"line\", expected its config",
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
