//! `coaxle secure`: makes a secure network, and renews it.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::Context;
use clap::{Args, Subcommand};
use coaxle_host::network::transport::{host_and_port, is_local};
use coaxle_node::keys::NodeName;
use coaxle_os::exit::wrong_argument;
use coaxle_os::machine;
use coaxle_report::inspect;

use super::folder::{
    AUTHORITY_FOLDER, read_authority, read_revoked, timing_secret, write_authority, write_revoked,
    write_role, write_timing_keys,
};
use super::member::{Member, Operator};
use super::network::SecureNetwork;
use super::profile::profile;
use super::timing;
use coaxle_host::network::credentials::{Authority, REVOKED_FILE, RevocationList, Validity};

/// Commands of `coaxle secure`.
#[derive(Debug, Subcommand)]
pub enum SecureSubcommand {
    /// Make a new authority, and a folder with certificate, key and rights for each node and operator
    Init(SecureArgs),
    /// Write the folders again with the authority that is there: before certificates expire, for a new node or
    /// operator, or after a node follows another one
    Renew(RenewArgs),
}

/// A network, and the destination of its folders.
#[derive(Debug, Args)]
pub struct SecureArgs {
    /// The config files of all nodes: subscriptions and addresses. Rights are derived from them
    #[arg(required = true, value_name = "CONFIG")]
    configs: Vec<PathBuf>,
    /// Destination of the folders: `authority`, which stays there, and one to copy to each PC
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// An operator who may command nodes: a name, or a name and the nodes, as in anna=saw,press; may be given several times
    #[arg(long = "operator", value_name = "NAME[=NODES]", value_parser = Operator::from_str)]
    operators: Vec<Operator>,
    /// Address of a node if the configs do not have it: conveyor=192.168.1.10; may be given several times
    #[arg(long = "at", value_name = "NODE=HOST", value_parser = at)]
    addresses: Vec<(NodeName, String)>,
    /// Validity of the certificates, in days
    #[arg(long, value_name = "N", default_value_t = VALID_DAYS, value_parser = clap::value_parser!(u16).range(1..=3650))]
    valid_days: u16,
}

/// A network to renew, or some of its members.
#[derive(Debug, Args)]
pub struct RenewArgs {
    #[command(flatten)]
    network: SecureArgs,
    /// Write the folders of these nodes and operators only [default: of all]
    #[arg(long, value_delimiter = ',', value_name = "NAMES", value_parser = |name: &str| NodeName::new(name))]
    only: Vec<NodeName>,
    /// Revoke the certificates of these nodes and operators from before now: a stolen key, or a member that has left.
    /// Running nodes obey the list once it is in their folder
    #[arg(long, value_delimiter = ',', value_name = "NAMES", value_parser = |name: &str| NodeName::new(name))]
    revoke: Vec<NodeName>,
}

/// Validity of the certificates, if none is stated.
const VALID_DAYS: u16 = 365;
/// Validity of the authority. It outlives what it signs: all folders are to be copied again when it ends.
const AUTHORITY_DAYS: u16 = 20 * 365;

/// Writes the folders, and prints the steps that follow.
///
/// # Errors
/// A wrong config, members that make no network, folders that are there already or cannot be written.
pub fn print(command: &SecureSubcommand) -> anyhow::Result<bool> {
    let (args, authority, only, revoke) = match command {
        SecureSubcommand::Init(args) => (args, args.new_authority()?, &[][..], &[][..]),
        SecureSubcommand::Renew(RenewArgs {
            network,
            only,
            revoke,
        }) => (
            network,
            read_authority(&network.out)?,
            &only[..],
            &revoke[..],
        ),
    };
    let (network, revoked) = args.write(&authority, only, revoke)?;
    inspect::print(|out| {
        write_instructions(&args.out, &network, |name| is_meant(only, name), out)?;
        write_revocations(&revoked, revoke, out)?;
        Ok(true)
    })
}

/// Makes a new network of these configs in the folder `out`, with one operator and the addresses of the nodes.
///
/// # Errors
/// A wrong config, members that make no network, folders that are there already or cannot be written.
pub(crate) fn init(
    configs: Vec<PathBuf>,
    out: PathBuf,
    operator: Operator,
    addresses: Vec<(NodeName, String)>,
) -> anyhow::Result<()> {
    let args = SecureArgs {
        configs,
        out,
        operators: vec![operator],
        addresses,
        valid_days: VALID_DAYS,
    };
    let authority = args.new_authority()?;
    args.write(&authority, &[], &[]).map(drop)
}

fn is_meant(only: &[NodeName], name: &NodeName) -> bool {
    only.is_empty() || only.contains(name)
}

/// The list of revoked certificates that the authority keeps, with these members added.
fn revoked(
    args: &SecureArgs,
    revoke: &[NodeName],
    validity: Validity,
) -> anyhow::Result<RevocationList> {
    let mut list = read_revoked(&args.out)?;
    if !revoke.is_empty() {
        list.number += 1;
        // The certificates that are issued with the list begin then, and all earlier ones before.
        let before = validity.from_s();
        list.before
            .extend(revoke.iter().map(|name| (name.to_string(), before)));
    }
    Ok(list)
}

/// Writes the list into the folders of the authority and of all members, also beside `--only`: each node has to know
/// whom it must refuse.
fn distribute(
    list: &RevocationList,
    args: &SecureArgs,
    network: &SecureNetwork,
    authority: &Authority,
) -> anyhow::Result<()> {
    if list.number == 0 {
        return Ok(());
    }
    let signed = authority.sign(list)?;
    let names = members(network).map(NodeName::as_str);
    let folders = names
        .chain([AUTHORITY_FOLDER])
        .map(|name| args.out.join(name));
    for folder in folders.filter(|folder| folder.exists()) {
        write_revoked(&folder, &signed)?;
    }
    Ok(())
}

fn write_revocations(
    list: &RevocationList,
    revoke: &[NodeName],
    out: &mut dyn Write,
) -> anyhow::Result<()> {
    if list.number == 0 {
        return Ok(());
    }
    let names: Vec<_> = list.before.keys().map(String::as_str).collect();
    writeln!(
        out,
        "{REVOKED_FILE}, number {}, in each folder: earlier certificates of {} are revoked",
        list.number,
        names.join(", ")
    )?;
    if !revoke.is_empty() {
        writeln!(
            out,
            "    Copy it to each PC now: running nodes obey it within two seconds, without a restart."
        )?;
    }
    Ok(())
}

impl SecureArgs {
    /// Makes a new authority, and writes it.
    fn new_authority(&self) -> anyhow::Result<Authority> {
        let network = self.network()?;
        // Before the authority is written: members of two authorities refuse each other.
        refuse_to_overwrite(&self.out, &network)?;
        let authority = Authority::new(Validity::days(machine::wall_clock(), AUTHORITY_DAYS))?;
        write_authority(&self.out, &authority)?;
        Ok(authority)
    }

    /// Writes the folders of all members, or of `only` some, and the certificates that are revoked.
    fn write(
        &self,
        authority: &Authority,
        only: &[NodeName],
        revoke: &[NodeName],
    ) -> anyhow::Result<(SecureNetwork, RevocationList)> {
        let network = self.network()?;
        check_known(&network, only)?;
        // The same instant for all, so that no member expires before the others by seconds.
        let validity = Validity::days(machine::wall_clock(), self.valid_days);
        // Read before anything is written: a damaged list stops all of it.
        let revoked = revoked(self, revoke, validity)?;
        for name in members(&network).filter(|name| is_meant(only, name)) {
            // For operators as well, who have no address but their own PC.
            let hosts = network.addresses().in_certificate(name);
            let issued = authority.issue(name, &hosts, validity)?;
            let profile = profile(&network, name).context("a member has rights")?;
            write_role(&self.out.join(name.as_str()), authority, &issued, &profile)?;
        }
        distribute(&revoked, self, &network, authority)?;
        let secret = timing_secret(&self.out)?;
        let nodes = network.nodes().iter();
        for node in nodes.filter(|node| is_meant(only, &node.name)) {
            let keys = timing::keys_of(&network, node, &secret, &revoked);
            write_timing_keys(&self.out.join(node.name.as_str()), &keys)?;
        }
        Ok((network, revoked))
    }

    fn network(&self) -> anyhow::Result<SecureNetwork> {
        let nodes = self.configs.iter().map(|file| Member::load(file));
        let nodes = nodes.collect::<anyhow::Result<Vec<_>>>()?;
        SecureNetwork::new(nodes, self.operators.clone(), &self.addresses)
            .or_else(|wrong| wrong_argument(wrong.to_string()))
    }
}

fn members(network: &SecureNetwork) -> impl Iterator<Item = &NodeName> {
    let nodes = network.nodes().iter().map(|node| &node.name);
    nodes.chain(network.operators().iter().map(|operator| &operator.name))
}

fn refuse_to_overwrite(out: &Path, network: &SecureNetwork) -> anyhow::Result<()> {
    let names = members(network).map(NodeName::as_str);
    for name in names.chain([AUTHORITY_FOLDER]) {
        let folder = out.join(name);
        if folder.exists() {
            return wrong_argument(format!(
                "{} is there already, expected none: `coaxle secure renew` writes folders anew",
                folder.display()
            ));
        }
    }
    Ok(())
}

fn check_known(network: &SecureNetwork, only: &[NodeName]) -> anyhow::Result<()> {
    for name in only {
        if !members(network).any(|known| known == name) {
            let known: Vec<_> = members(network).map(NodeName::as_str).collect();
            return wrong_argument(format!(
                "--only: received {:?}, expected some of: {}",
                name.as_str(),
                known.join(", ")
            ));
        }
    }
    Ok(())
}

fn write_instructions(
    folder: &Path,
    network: &SecureNetwork,
    is_meant: impl Fn(&NodeName) -> bool,
    out: &mut dyn Write,
) -> anyhow::Result<()> {
    let of = |name: &str| folder.join(name).display().to_string();
    writeln!(
        out,
        "{}: keep it away from the nodes; `coaxle secure renew` needs it",
        of(AUTHORITY_FOLDER)
    )?;
    for node in network.nodes().iter().filter(|node| is_meant(&node.name)) {
        let name = node.name.as_str();
        writeln!(out, "{}: for the PC of {name}; in its config", of(name))?;
        writeln!(
            out,
            "    [transport]\n    secure = {name:?}   # the folder, seen from the config"
        )?;
        // A node with an address of its own is reached from other PCs.
        let is_elsewhere = !network.addresses().beyond_its_pc(&node.name).is_empty();
        let listen: Vec<_> = node
            .listen
            .iter()
            .map(|at| listening(at, is_elsewhere))
            .collect();
        let connect: Vec<_> = node.connect.iter().map(|at| with_tls(at)).collect();
        for (field, endpoints) in [("listen", &listen), ("connect", &connect)] {
            if !endpoints.is_empty() {
                writeln!(out, "    {field} = {endpoints:?}")?;
            }
        }
        if !is_elsewhere && !node.listen.is_empty() {
            writeln!(
                out,
                "    # Nobody says where other PCs reach it: --at {name}=ADDRESS, if any shall."
            )?;
        }
    }
    for operator in network
        .operators()
        .iter()
        .filter(|known| is_meant(&known.name))
    {
        let name = operator.name.as_str();
        writeln!(
            out,
            "{}: for {name}; coaxle command --secure {name} NODE SLAVE COMMAND",
            of(name)
        )?;
    }
    Ok(())
}

/// A node that others reach from their PCs cannot listen on its own alone.
fn listening(endpoint: &str, is_elsewhere: bool) -> String {
    match host_and_port(endpoint) {
        // The port stays: others have it in their `connect`.
        Some((_, port)) if is_elsewhere && is_local(endpoint) => format!("tls/0.0.0.0:{port}"),
        _ => with_tls(endpoint),
    }
}

fn with_tls(endpoint: &str) -> String {
    let address = endpoint
        .split_once('/')
        .map_or(endpoint, |(_, address)| address);
    format!("tls/{address}")
}

fn at(text: &str) -> Result<(NodeName, String), String> {
    let expected = || format!("received {text:?}, expected NODE=HOST, as in conveyor=192.168.1.10");
    let (node, host) = text.split_once('=').ok_or_else(expected)?;
    let node = NodeName::new(node).map_err(|error| error.to_string())?;
    // A port or a protocol is a misunderstanding: certificates name hosts alone.
    if host.is_empty() || host.contains(['/', ':']) {
        return Err(expected());
    }
    Ok((node, host.to_owned()))
}
