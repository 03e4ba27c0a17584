//! A secure network: an authority, certificates and rights.
//!
//! [`SecureNetwork`] knows from the nodes' own configs which node follows which; [`SecureNetwork::rights`] derives from that the
//! rights of each at each, and [`profile()`] writes them as a Zenoh config. [`Authority`] signs a certificate for every node
//! and every operator. `docs/SECURE.md` describes the protection and its limits.

pub mod cli;
mod folder;
mod hosts;
mod member;
mod network;
mod profile;
mod rights;
#[cfg(test)]
mod samples;
mod timing;

pub use coaxle_host::network::credentials::{Authority, Issued, Validity};
pub use folder::{AUTHORITY_FOLDER, AUTHORITY_KEY_FILE, write_authority, write_role};
pub use hosts::Addresses;
pub use member::{Member, Operator};
pub use network::SecureNetwork;
pub use profile::{MAX_FRAME_BYTES, MAX_MESSAGE_BYTES, profile};
pub use rights::{MessageDirection, Right};
