//! The `coaxle` tool's command line.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Context;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use clap_complete::Shell;
use coaxle_host::cli::{LogArgs, NodeArgs, exit_code};
use coaxle_lab::catalog;
use coaxle_lab::sweep::{self, Setup};
use coaxle_opcua::host::OpcuaArgs;
use coaxle_os::exit::{EXIT_CODES, Exit, lines_of};
use coaxle_report::inspect;
use coaxle_trials::Bar;
use coaxle_trials::bench::{self, BenchArgs, PeerArgs};
use coaxle_trials::conform::{self, ConformArgs};
use coaxle_trials::recording;
use coaxle_trials::scale::{self, ScaleArgs};

use crate::audit::{self, AuditArgs};
use crate::cam::{self, CamSubcommand};
use crate::command::{self, CommandArgs};
use crate::doctor::{self, DoctorArgs};
use crate::examples;
use crate::fmu::{self, FmuSubcommand};
use crate::gear::{self, GearSubcommand};
use crate::init::{self, InitArgs};
use crate::overview;
use crate::recorded::{self, ExportArgs, InfoArgs, RecordArgs, RecoverArgs, ReplayArgs};
use crate::ros2::{self, Ros2Args};
use crate::run::{self, RunArgs};
use crate::saw::{self, SawSubcommand};
use crate::schema::{self, SchemaArgs};
use crate::scope::{self, OwnPageArgs, ScopeArgs};
use crate::secure::cli::SecureSubcommand;
use crate::soak::SoakArgs;
use crate::status::{self, GetArgs, NodesArgs, StatusArgs, WaitArgs};
use crate::sweep::SweepArgs;
use crate::topology::{self, TopologyArgs};
use crate::when::{self, WhenArgs};
use crate::why::{self, WhyArgs};

/// Distributed axes: motion axes on different PCs that move as one, although every PC has its own
/// clock.
///
/// Without a command it shows its commands. In a checkout, `cargo run --release` runs `coaxle demo`.
#[derive(Debug, Parser)]
#[command(name = "coaxle", version, after_help = EXIT_CODES)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<CoaxleCommand>,
    #[command(flatten)]
    log: LogArgs,
}

#[derive(Debug, Subcommand)]
enum CoaxleCommand {
    /// Cut pieces to length with real processes on this machine, in about a minute: a flying saw whose conveyor is on
    /// another PC with another clock, without correction and with it
    Demo,
    /// List the scenarios that come with the tool
    List,
    /// Run a scenario and write summary.json, trace.mcap and report.html
    Run(RunArgs),
    /// Run a scenario over a grid of values, in virtual time, and write tables, a plot and a report: docs/SWEEPS.md
    Sweep(SweepArgs),
    /// Run random schedules of faults and commands, and check every cycle of them
    Soak(SoakArgs),
    /// Measure the cost of more receivers, senders, axes and slaves: processor time and memory; docs/SCALE.md
    Scale(ScaleArgs),
    /// Check scenario files without running them; all built-in ones if none is named
    Check {
        /// Names of built-in scenarios, or paths
        scenarios: Vec<String>,
    },
    /// Print a built-in scenario, to start a new one from
    Show {
        /// Name of a built-in scenario
        scenario: String,
    },
    /// Write the configs of two nodes to start with, and their certificates, from six answers or options
    Init(InitArgs),
    /// Print a config of a node to start from; without a name, list those that there are
    Example {
        /// Name of the config
        name: Option<String>,
    },
    /// List the signals of a node: the columns of its trace, with unit and meaning
    Signals {
        /// The receiver's config file
        config: std::path::PathBuf,
    },
    /// Look into a cam file, judge it, make one of a point table: docs/CAMS.md
    #[command(subcommand)]
    Cam(CamSubcommand),
    /// Plan, draw and move the synchronisation of a flying saw: docs/SAWS.md
    #[command(subcommand)]
    Saw(SawSubcommand),
    /// Plan and draw a flying gear: docs/GEARS.md
    #[command(subcommand)]
    Gear(GearSubcommand),
    /// Write a link or a slave as a unit for co-simulation by FMI 3.0: docs/FMI.md
    #[command(subcommand)]
    Fmu(FmuSubcommand),
    /// Send a command to a slave of a running node
    #[command(name = "command")]
    Order(Box<CommandArgs>),
    /// List the nodes of a network
    Nodes(NodesArgs),
    /// Show the status of running nodes: clocks, messages, axes, slaves
    Status(StatusArgs),
    /// Print single values of a running node, for scripts
    Get(GetArgs),
    /// Say what limits the accuracy of a running receiver now, by how much, and what to change first
    Why(WhyArgs),
    /// Print the time until an axis comes to a position, as its sender has promised; docs/PRESENTATION.md
    When(WhenArgs),
    /// Show who was refused what by a node, and who did what there: of a recording, or of a running node; docs/SECURE.md
    Audit(AuditArgs),
    /// Wait until a receiver knows the clocks that it follows
    WaitSync(WaitArgs),
    /// Check which rules of docs/WIRE.md a node keeps, in any implementation: docs/CONFORM.md
    Conform(ConformArgs),
    /// Make a network secure: certificates, and the rights of each node; docs/SECURE.md
    #[command(subcommand)]
    Secure(SecureSubcommand),
    /// Examine this PC's fitness for cycles; or what the configs of nodes leave open to others, and how to close it
    Doctor(DoctorArgs),
    /// Show who follows whom over all nodes, from their configs or while they run: routes with their delays, circles, contradictions, a proposal
    /// for present-after-ms; docs/TOPOLOGY.md
    Topology(TopologyArgs),
    /// Measure the real path on this machine: lateness of cycles, travel time of samples between two nodes, and their
    /// cost, beside the machine without coaxle: docs/SPEED.md
    Bench(BenchArgs),
    /// Write the formats of files as JSON Schema, for editors: docs/REFERENCE.md
    Schema(SchemaArgs),
    /// Record how messages between real nodes arrive, to judge estimators of a far clock by
    RecordArrivals(recording::RecordArrivalsArgs),
    /// Serve a page with the plots, clocks and slaves of running nodes; docs/SCOPE.md
    Scope(ScopeArgs),
    /// Run a ROS 2 node that publishes the axes of running nodes as joint states, and takes trajectories; over Zenoh, as
    /// rmw_zenoh: docs/ROS2.md
    Ros2(Ros2Args),
    /// Run a server of OPC UA that shows running nodes as objects, and takes commands as methods: docs/OPCUA.md
    Opcua(OpcuaArgs),
    /// Record every cycle of running nodes, from outside: docs/RECORDING.md
    Record(RecordArgs),
    /// Replay the recording of a receiver in virtual time, with its config or another one, and compare: docs/RECORDING.md
    Replay(ReplayArgs),
    /// Repair a recording that was not ended, or is damaged: docs/RECORDING.md
    Recover(RecoverArgs),
    /// Write the rows of a recording as tables for other programs
    Export(ExportArgs),
    /// Show the content of a recording
    Info(InfoArgs),
    /// Print completions for a shell: coaxle completions bash > /etc/bash_completion.d/coaxle
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Write the man pages, one for each command
    Man {
        /// The folder that they go to
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
    /// Keep one processor busy until standard input ends
    #[command(name = recording::KEEP_BUSY, hide = true)]
    KeepBusy,
    /// Be one process of a measurement
    #[command(name = bench::PEER, hide = true)]
    BenchPeer(PeerArgs),
    /// Run a sender node
    Sender {
        #[command(flatten)]
        node: coaxle_sender::run::Args,
        #[command(flatten)]
        page: OwnPageArgs,
    },
    /// Run a receiver node
    Receiver {
        #[command(flatten)]
        node: coaxle_receiver::run::Args,
        #[command(flatten)]
        page: OwnPageArgs,
    },
    /// Run a gateway node: the axes of a PLC as a sender's, and those of a receiver into a PLC; by ADS, UDP, or
    /// standard input and output: docs/PLC.md
    Gateway {
        #[command(flatten)]
        node: NodeArgs,
        #[command(flatten)]
        page: OwnPageArgs,
    },
}

/// Runs the tool.
#[must_use]
pub fn main() -> ExitCode {
    // Not `Cli::parse`: the help in groups is a template of the command, which the derive does not know.
    let matches = overview::in_groups(Cli::command()).get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    // Before any command, so that none of its lines is lost.
    let logging = cli.log.init();
    exit_code(carry_out(cli.command), logging)
}

fn carry_out(command: Option<CoaxleCommand>) -> anyhow::Result<Exit> {
    // Commands that answer a question give false; their exit code for it is beside them.
    let (good, otherwise) = match command {
        // Cargo names itself to the programs that it runs.
        None if std::env::var_os("CARGO").is_none() => (show_help()?, Exit::Failed),
        None | Some(CoaxleCommand::Demo) => return run::run(&run::demonstration()),
        Some(CoaxleCommand::Run(args)) => return run::run(&args),
        Some(CoaxleCommand::Sweep(args)) => return crate::sweep::run(&args),
        Some(CoaxleCommand::Soak(args)) => return crate::soak::run(&args),
        Some(CoaxleCommand::Scale(args)) => return scale::scale(&args),
        Some(CoaxleCommand::List) => (list()?, Exit::Failed),
        Some(CoaxleCommand::Check { scenarios }) => (check(&scenarios)?, Exit::Failed),
        Some(CoaxleCommand::Show { scenario }) => (show(&scenario)?, Exit::Failed),
        Some(CoaxleCommand::Init(args)) => return init::init(&args),
        Some(CoaxleCommand::Example { name }) => (examples::print(name.as_deref())?, Exit::Failed),
        Some(CoaxleCommand::Signals { config }) => {
            (crate::signals::signals(&config)?, Exit::Failed)
        }
        Some(CoaxleCommand::Cam(command)) => (cam::print(&command)?, Exit::Failed),
        // Refused, not failed: the plan was made, and its answer is no.
        Some(CoaxleCommand::Saw(command)) => (saw::print(&command)?, Exit::Refused),
        Some(CoaxleCommand::Gear(command)) => (gear::print(&command)?, Exit::Refused),
        Some(CoaxleCommand::Fmu(command)) => (fmu::write(&command).map(|()| true)?, Exit::Failed),
        Some(CoaxleCommand::Order(args)) => (command::print(&args)?, Exit::Refused),
        Some(CoaxleCommand::Nodes(args)) => return status::nodes(&args),
        Some(CoaxleCommand::Status(args)) => return status::status(&args),
        Some(CoaxleCommand::Get(args)) => return status::get(&args),
        Some(CoaxleCommand::Why(args)) => return why::why(&args),
        Some(CoaxleCommand::When(args)) => return when::when(&args),
        Some(CoaxleCommand::Audit(args)) => return audit::audit(&args),
        Some(CoaxleCommand::WaitSync(args)) => return status::wait(&args),
        Some(CoaxleCommand::Conform(args)) => return conform::conform(&args),
        Some(CoaxleCommand::Secure(command)) => {
            (crate::secure::cli::print(&command)?, Exit::Failed)
        }
        Some(CoaxleCommand::Doctor(args)) => (doctor::print(&args)?, Exit::Failed),
        Some(CoaxleCommand::Topology(args)) => return topology::topology(&args),
        Some(CoaxleCommand::Bench(args)) => return bench::bench(&args),
        Some(CoaxleCommand::BenchPeer(args)) => return bench::run_peer(&args),
        Some(CoaxleCommand::Schema(args)) => (schema::print(&args).map(|()| true)?, Exit::Failed),
        Some(CoaxleCommand::RecordArrivals(args)) => (record_arrivals(&args)?, Exit::Failed),
        Some(CoaxleCommand::Scope(args)) => return scope::scope(&args),
        Some(CoaxleCommand::Ros2(args)) => return ros2::ros2(&args),
        Some(CoaxleCommand::Opcua(args)) => return coaxle_opcua::host::run(&args),
        Some(CoaxleCommand::Record(args)) => return recorded::record(&args),
        Some(CoaxleCommand::Replay(args)) => return recorded::replay(&args),
        Some(CoaxleCommand::Recover(args)) => (
            print_text(&recorded::recover(&args)?).map(|()| true)?,
            Exit::Failed,
        ),
        Some(CoaxleCommand::Export(args)) => (
            print_text(&recorded::export(&args)?).map(|()| true)?,
            Exit::Failed,
        ),
        Some(CoaxleCommand::Info(args)) => (
            print_text(&recorded::info(&args)?).map(|()| true)?,
            Exit::Failed,
        ),
        Some(CoaxleCommand::Completions { shell }) => (completions(shell)?, Exit::Failed),
        Some(CoaxleCommand::Man { out }) => (man(&out)?, Exit::Failed),
        Some(CoaxleCommand::KeepBusy) => (recording::keep_busy().map(|()| true)?, Exit::Failed),
        Some(CoaxleCommand::Sender { node, page }) => {
            return coaxle_sender::run::run_with_service(&node, page.transport_service());
        }
        Some(CoaxleCommand::Receiver { node, page }) => {
            return coaxle_receiver::run::run_with_service(&node, page.transport_service());
        }
        Some(CoaxleCommand::Gateway { node, page }) => {
            return coaxle_gateway::host::run(&node, page.transport_service());
        }
    };
    Ok(otherwise.done_if(good))
}

fn show_help() -> anyhow::Result<bool> {
    let help = overview::in_groups(Cli::command()).render_help();
    print_text(&help.to_string()).map(|()| true)
}

fn print_text(text: &str) -> anyhow::Result<()> {
    inspect::print_text(text)
}

fn list() -> anyhow::Result<bool> {
    for (name, _) in catalog::all() {
        // Titles are in the files, which a list of its own could contradict.
        let scenario = catalog::find(name)?.read(&[])?;
        print_text(&format!("{name:28} {}", scenario.title))?;
    }
    print_text("\nRun one with: coaxle run <name>")?;
    Ok(true)
}

fn show(name: &str) -> anyhow::Result<bool> {
    print_text(catalog::find(name)?.text.trim_end())?;
    Ok(true)
}

fn check(names: &[String]) -> anyhow::Result<bool> {
    let all: Vec<String> = match names {
        [] => catalog::all().map(|(name, _)| name.to_owned()).collect(),
        names => names.to_vec(),
    };
    let mut good = true;
    for name in all {
        let prepared =
            // As a sweep, because a scenario may have a grid, and each of its points is checked.
            catalog::find(&name).and_then(|source| sweep::prepare(&source, &Setup::default()));
        match prepared {
            Ok(prepared) => {
                print_text(&format!("{name}: ok"))?;
                for note in prepared.notes() {
                    print_text(&format!("{name}: note: {note}"))?;
                }
            }
            Err(error) => {
                good = false;
                lines_of(&error)
                    .iter()
                    .try_for_each(|line| print_text(line))?;
            }
        }
    }
    Ok(good)
}

fn record_arrivals(args: &recording::RecordArrivalsArgs) -> anyhow::Result<bool> {
    let said = match args.seconds() {
        Some(seconds) => {
            let mut bar = Bar::new(format!("of {seconds} s"))?;
            let said = recording::run(args, &mut bar);
            // Before the error is returned: it would stand behind half a bar.
            bar.clear();
            said?
        }
        // A conversion takes no time worth a bar.
        None => recording::run(args, &mut ())?,
    };
    print_text(&said)?;
    Ok(true)
}

fn completions(shell: Shell) -> anyhow::Result<bool> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "coaxle", &mut text);
    print_text(String::from_utf8_lossy(&text).trim_end())?;
    Ok(true)
}

fn man(out: &Path) -> anyhow::Result<bool> {
    let cannot = || format!("cannot write the man pages to {}", out.display());
    std::fs::create_dir_all(out).with_context(cannot)?;
    // The plain command: man pages have sections of their own instead of groups.
    clap_mangen::generate_to(Cli::command(), out).with_context(cannot)?;
    print_text(&format!("man pages: {}", out.display()))?;
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
