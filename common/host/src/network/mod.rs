//! The network to other nodes: how bytes travel, and the credentials that a secure network requires.

pub mod credentials;
pub mod transport;
