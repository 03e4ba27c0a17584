//! `coaxle ros2`: a node of ROS 2 over Zenoh, compatible with rmw_zenoh. It publishes the axes of Coaxle's nodes as joint
//! states, and takes trajectories for the slaves of receivers.
//!
//! Conversion of messages is in [`coaxle_ros`]; here are the two networks, and the timing.

mod followed;
mod nodes;
mod orders;
mod topics;

use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use coaxle_clock::{Instant, Span};
use coaxle_host::cli::NetworkArgs;
use coaxle_host::client::Commander;
use coaxle_host::network::transport::{OverZenoh, Transport, endpoint};
use coaxle_node::config::TransportConfig;
use coaxle_node::keys::NodeName;
use coaxle_os::exit::{Exit, wrong_argument};
use coaxle_os::machine::local;
use coaxle_os::{Interrupt, Machine, machine};
use coaxle_ros::entity::{RosDomain, RosName, RosNamespace, RosNode};
use coaxle_ros::message::JointTrajectory;
use coaxle_ros::source::PublishedValues;
use coaxle_ros::trajectory::plan;
use coaxle_ros::trajectory_queue::TrajectoryQueue;

use nodes::BridgedNodes;
use orders::OrderThread;
use topics::Topics;

/// The nodes, and their representation in ROS.
#[derive(Debug, Args)]
pub(crate) struct Ros2Args {
    /// The nodes [default: all that are there]
    #[arg(value_name = "NODE", value_parser = |name: &str| NodeName::new(name))]
    nodes: Vec<NodeName>,
    /// The ROS domain, 0 to 232
    #[arg(long, value_name = "NUMBER", default_value = "0", value_parser = RosDomain::new)]
    domain: RosDomain,
    /// The namespace of node and topics
    #[arg(long, value_name = "NAMESPACE", default_value = "/", value_parser = RosNamespace::new)]
    namespace: RosNamespace,
    /// Name of the ROS node
    #[arg(long, value_name = "NAME", default_value = "coaxle", value_parser = RosName::new)]
    node_name: RosName,
    /// Publish the axes at most at this rate, in Hz, 0.1 to 1000
    #[arg(long, value_name = "HZ", default_value = "100", value_parser = period)]
    rate: Span,
    /// Publish actual positions and velocities instead of set ones
    #[arg(long)]
    actual: bool,
    /// Take trajectories for slaves. Who reaches the topic commands them
    #[arg(long)]
    commands: bool,
    /// Look for ROS here, its router or a node, such as tcp/127.0.0.1:7447; may be given several times [default: ROS is
    /// in the same network as the nodes]
    #[arg(long, value_name = "ENDPOINT", value_parser = endpoint)]
    ros_connect: Vec<String>,
    /// Let ROS connect to this one here; may be given several times
    #[arg(long, value_name = "ENDPOINT", value_parser = endpoint)]
    ros_listen: Vec<String>,
    #[command(flatten)]
    network: NetworkArgs,
}

/// Parses a rate of publication in Hz into its period.
fn period(text: &str) -> Result<Span, String> {
    let rate = text.parse().ok().filter(|hz| (0.1..=1000.0).contains(hz));
    // At least 0.1 Hz, so the division is safe.
    rate.map(|hz: f64| Span::from_secs_f64(1.0 / hz))
        .ok_or_else(|| "expected a number from 0.1 to 1000".to_owned())
}

/// Interval of looking for nodes and reading their statuses.
// Nodes publish their statuses at this interval.
const REFRESH_PERIOD: Span = Span::from_millis(250);
/// Time after which missing nodes are logged.
// Sessions dial again every second at the latest (`connect/retry`), so a node that runs has been found by then.
const ABSENCE_TIMEOUT: Span = Span::from_secs(5);
/// Longest wait between checks for the end and for trajectories.
// A trajectory waits at most this long before it is read, and a wake-up 100 times a second costs next to nothing.
const LONGEST_WAIT: Span = Span::from_millis(10);

/// Runs a ROS node until Ctrl-C.
///
/// # Errors
/// A wrong network section, or a network that cannot be joined.
pub(crate) fn ros2(args: &Ros2Args) -> anyhow::Result<Exit> {
    let interrupt = Interrupt::listen()?;
    let own_network = args.own_network()?;
    let watcher = args.network.watch(&args.nodes)?;
    let transport = Arc::clone(watcher.transport());
    let ros: Arc<dyn Transport> = match own_network {
        Some(network) => Arc::new(OverZenoh::open_and_wait(&network)?),
        // A single session serves both: ROS is in the same network then.
        None => Arc::clone(&transport),
    };
    let commander = Commander::over(Arc::clone(&transport), args.network.secure.as_deref())?;
    let mut bridge = Bridge {
        nodes: BridgedNodes::new(watcher),
        topics: Topics::open(&*ros, &args.ros_node(&*ros), args.commands)?,
        orders: OrderThread::start(commander)?,
        moves: TrajectoryQueue::default(),
        values: match args.actual {
            true => PublishedValues::Actual,
            false => PublishedValues::Set,
        },
    };
    tracing::info!("{}; ROS {}", bridge.topics.described(), ros.whereabouts());
    bridge.run(args.rate, &interrupt);
    // First the tokens go, then the sessions.
    drop(bridge);
    ros.close();
    transport.close();
    Ok(Exit::Done)
}

impl Ros2Args {
    /// The network of ROS, where it has one of its own.
    fn own_network(&self) -> anyhow::Result<Option<TransportConfig>> {
        if self.ros_connect.is_empty() && self.ros_listen.is_empty() {
            if self.network.secure.is_some() {
                return wrong_argument(
                    "--secure: received no --ros-connect, expected that or --ros-listen besides: in a secure network nobody has \
                     the right to topics of ROS",
                );
            }
            return Ok(None);
        }
        Ok(Some(TransportConfig {
            connect: self.ros_connect.clone(),
            listen: self.ros_listen.clone(),
            ..TransportConfig::default()
        }))
    }

    fn ros_node(&self, ros: &dyn Transport) -> RosNode {
        RosNode {
            domain: self.domain,
            // rmw_zenoh has the session in every token; a transport without sessions has none.
            session: ros.session_id().unwrap_or_else(|| "0".to_owned()),
            namespace: self.namespace.clone(),
            name: self.node_name.clone(),
        }
    }
}

/// Bridge between the two networks.
struct Bridge {
    nodes: BridgedNodes,
    topics: Topics,
    orders: OrderThread,
    moves: TrajectoryQueue,
    values: PublishedValues,
}

impl Bridge {
    fn run(&mut self, period: Span, interrupt: &Interrupt) {
        let began = machine::now();
        let (mut next_tick, mut next_refresh) = (began, began);
        let mut is_absence_logged = false;
        while !interrupt.is_received() {
            let now = machine::now();
            if now >= next_refresh {
                next_refresh = now + REFRESH_PERIOD;
                self.nodes.refresh();
                if !is_absence_logged && now - began > ABSENCE_TIMEOUT {
                    is_absence_logged = true;
                    self.nodes.log_absence(ABSENCE_TIMEOUT);
                }
            }
            if now >= next_tick {
                // On a grid, but after a stall the missed ticks are not made up for.
                next_tick = (next_tick + period).max(now);
                self.publish_joint_states(now);
            }
            self.take_trajectories(now);
            self.enqueue_orders(now);
            self.nodes
                .receive(self.wait(now, next_tick.min(next_refresh)));
        }
    }

    /// Time until something is due.
    fn wait(&self, now: Instant<Machine>, next: Instant<Machine>) -> Duration {
        let due = self
            .moves
            .next_at()
            .map_or(LONGEST_WAIT, |at| at - local(now));
        let wait = (next - now).min(due).min(LONGEST_WAIT);
        // Negative for anything that is overdue.
        Duration::from_nanos(wait.max(Span::ZERO).as_nanos().unsigned_abs())
    }

    /// Publishes the joint states received since the last call.
    fn publish_joint_states(&mut self, now: Instant<Machine>) {
        let unix = unix_offset();
        for state in self.nodes.joint_states(local(now), self.values, unix) {
            self.topics.publish(&state, unix_now(unix));
        }
    }

    fn take_trajectories(&mut self, now: Instant<Machine>) {
        for bytes in self.topics.trajectories() {
            let unix = unix_offset();
            let known = self.nodes.addresses(local(now));
            let read = JointTrajectory::from_bytes(&bytes).map_err(|error| error.to_string());
            let planned = read.and_then(|trajectory| {
                plan(&trajectory, unix_now(unix), &known).map_err(|refusal| refusal.to_string())
            });
            match planned {
                Ok(plan) => {
                    let points = plan.segments.len();
                    let joints: Vec<_> = plan.joints.iter().map(|at| at.joint.as_str()).collect();
                    let joints = joints.join(", ");
                    let number = self.moves.begin(plan, local(now));
                    tracing::info!("trajectory {number}: {points} points for {joints}");
                }
                Err(why) => tracing::warn!("a trajectory is refused: {why}"),
            }
        }
    }

    fn enqueue_orders(&mut self, now: Instant<Machine>) {
        // Before further orders are queued: those of a refused trajectory must not follow.
        for trajectory in self.orders.refused() {
            self.moves.drop_rest(trajectory);
        }
        let nodes = &self.nodes;
        let motion = |address: &_| nodes.motion(address, local(now));
        let (due, lost) = self.moves.due(local(now), motion);
        for lost in lost {
            tracing::warn!("{lost}");
        }
        for due in due {
            let trajectory = due.trajectory;
            if !self.orders.enqueue(due) {
                tracing::warn!(
                    "trajectory {trajectory}: too many orders wait, so the rest is dropped"
                );
                self.moves.drop_rest(trajectory);
            }
        }
    }
}

/// Reading of CLOCK_REALTIME when this machine's clock shows 0. An interruption between the two readings makes it too
/// small, so the largest of several counts.
fn unix_offset() -> Span {
    // Three: that an interruption hits each of them is unlikely.
    let readings = [(); 3].map(|()| machine::wall_clock_offset_ns());
    Span::from_nanos(readings.into_iter().max().unwrap_or_default())
}

fn unix_now(offset: Span) -> i64 {
    (machine::now().since_epoch() + offset).as_nanos()
}
