//! `coaxle/<node>/about`: what a node says of its axes, so that nobody has to repeat it.

use coaxle_axis::Modulo;
use coaxle_clock::{CycleTime, Span};
use coaxle_node::Channel;
use coaxle_node::circles::AxisAddress;
use coaxle_node::config::{PresentAfterRange, Unit};
use coaxle_node::keys::NodeName;
use coaxle_node::one_line;
use serde::{Deserialize, Serialize};

use crate::graph::far_of;
use crate::plant::{
    AxisOrigin, FarReference, LagRule, PlantAxis, PlantNode, PlantRole, RootMotion, Showing,
    StatedLimits,
};
use crate::way::WaySource;

/// Version of the format.
const VERSION: u32 = 1;
/// Longest description accepted, bytes: 4096 axes with 256 each.
const LONGEST: usize = 1 << 20;
/// Greatest number of axes accepted.
const MOST_AXES: usize = 4096;
/// Longest name of an axis, in characters, as in a config.
const LONGEST_NAME: usize = 64;

/// A node and its axes, as they travel.
#[derive(Serialize, Deserialize)]
struct AboutMessage {
    version: u32,
    node: NodeName,
    /// Run of the node, 16 hexadecimal digits, as in its status.
    epoch: String,
    role: PlantRole,
    cycle_time_us: f64,
    axes: Vec<AboutAxis>,
}

/// An axis, as it travels.
#[derive(Serialize, Deserialize)]
struct AboutAxis {
    name: String,
    kind: AboutKind,
    #[serde(default)]
    channel: Option<String>,
    #[serde(default)]
    id: Option<u32>,
    #[serde(default)]
    unit: Option<Unit>,
    #[serde(default)]
    modulo: Option<Modulo>,
    #[serde(default)]
    limits: Option<StatedLimits>,
    /// Time by which it is shown later; the shortest one, if its followers decide it.
    #[serde(default)]
    present_after_us: Option<f64>,
    /// The longest one, if its followers decide it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    present_after_at_most_us: Option<f64>,
    /// Names of its masters in its own node.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    masters: Vec<String>,
    /// Addresses that it follows on other nodes, the first choice first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    follows: Vec<String>,
}

/// Origin of an axis's motion, as it travels.
#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum AboutKind {
    Program,
    Encoder,
    Replay,
    Plc,
    Far,
    Slave,
    Output,
    /// A kind of a later version.
    #[serde(other)]
    Unknown,
}

/// A description that no node can mean.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InvalidAbout {
    /// The field.
    pub field: String,
    /// Value received.
    pub received: String,
    /// Values expected.
    pub expected: String,
}

impl std::fmt::Display for InvalidAbout {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            field,
            received,
            expected,
        } = self;
        write!(f, "{field}: received {received}, expected {expected}")
    }
}

impl InvalidAbout {
    fn new(field: impl Into<String>, received: impl ToString, expected: &str) -> Self {
        Self {
            field: field.into(),
            // From another node: of any length and content.
            received: one_line(&received.to_string()),
            expected: expected.to_owned(),
        }
    }
}

/// Writes the description of a run.
#[must_use]
pub fn about_to_json(node: &PlantNode, epoch: u64) -> String {
    let message = AboutMessage {
        version: VERSION,
        node: node.name.clone(),
        epoch: format!("{epoch:016x}"),
        role: node.role,
        cycle_time_us: node
            .cycle_time
            .map_or(0.0, |cycle| cycle.span().as_micros_f64()),
        axes: node.axes.iter().map(|axis| written(node, axis)).collect(),
    };
    // Texts and finite numbers always serialise.
    serde_json::to_string(&message).unwrap_or_default()
}

fn written(node: &PlantNode, axis: &PlantAxis) -> AboutAxis {
    let (kind, present_after) = match &axis.origin {
        AxisOrigin::Root {
            motion,
            present_after,
            ..
        } => {
            let kind = match motion {
                RootMotion::Program => AboutKind::Program,
                RootMotion::Encoder => AboutKind::Encoder,
                RootMotion::Replay => AboutKind::Replay,
                RootMotion::Plc => AboutKind::Plc,
                RootMotion::Unknown => AboutKind::Unknown,
            };
            (kind, *present_after)
        }
        AxisOrigin::Far(_) => (AboutKind::Far, None),
        AxisOrigin::Slave { .. } => (AboutKind::Slave, None),
        AxisOrigin::Output(_) => (AboutKind::Output, None),
    };
    let masters = match &axis.origin {
        AxisOrigin::Slave { masters } => masters.as_slice(),
        _ => &[],
    };
    let masters = masters.iter().filter_map(|place| node.axes.get(*place));
    let sources = far_of(axis).map_or(&[][..], |far| &far.sources);
    AboutAxis {
        name: axis.name.clone(),
        kind,
        channel: axis.published.map(|(channel, _)| channel.name().to_owned()),
        id: axis.published.map(|(_, id)| id),
        unit: axis.unit.clone(),
        modulo: axis.modulo,
        limits: axis.limits,
        present_after_us: present_after.map(|range| range.least.as_micros_f64()),
        present_after_at_most_us: present_after
            .filter(PresentAfterRange::is_led)
            .map(|range| range.most.as_micros_f64()),
        masters: masters.map(|master| master.name.clone()).collect(),
        follows: sources.iter().map(ToString::to_string).collect(),
    }
}

/// Reads the description of a run, and its epoch.
///
/// # Errors
/// [`InvalidAbout`] names the field.
pub fn about_from_json(bytes: &[u8]) -> Result<(PlantNode, u64), InvalidAbout> {
    // Before parsing: JSON of any length would be built up in memory.
    if bytes.len() > LONGEST {
        let expected = format!("at most {LONGEST}");
        return Err(InvalidAbout::new("bytes", bytes.len(), &expected));
    }
    let message: AboutMessage = serde_json::from_slice(bytes)
        .map_err(|error| InvalidAbout::new("about", error, "a description of axes in JSON"))?;
    if message.version != VERSION {
        let expected = VERSION.to_string();
        return Err(InvalidAbout::new("version", message.version, &expected));
    }
    let epoch = u64::from_str_radix(&message.epoch, 16)
        .map_err(|_| InvalidAbout::new("epoch", &message.epoch, "16 hexadecimal digits"))?;
    if message.axes.len() > MOST_AXES {
        let expected = format!("at most {MOST_AXES}");
        return Err(InvalidAbout::new("axes", message.axes.len(), &expected));
    }
    let cycle = CycleTime::new(Span::from_micros_f64(message.cycle_time_us))
        .map_err(|_| InvalidAbout::new("cycle_time_us", message.cycle_time_us, "100 to 100000"))?;
    let names: Vec<String> = message.axes.iter().map(|axis| axis.name.clone()).collect();
    let axes: Result<_, _> = (message.axes.into_iter().enumerate())
        .map(|(n, axis)| read(n, axis, &names))
        .collect();
    let axes: Vec<PlantAxis> = axes?;
    // Followers compare by channel and id: two descriptions of one axis would leave open which one counts.
    let mut published: Vec<_> = (axes.iter().filter_map(|axis| axis.published))
        .map(|(channel, id)| (channel.name(), id))
        .collect();
    published.sort_unstable();
    if let Some(pair) = published.windows(2).find(|pair| pair[0] == pair[1]) {
        let received = format!("{}/{} twice", pair[0].0, pair[0].1);
        return Err(InvalidAbout::new("axes", received, "each axis once"));
    }
    let node = PlantNode {
        file: format!("about of {}", message.node),
        name: message.node,
        role: message.role,
        cycle_time: Some(cycle),
        axes,
        is_complete: true,
        hold_back: None,
    };
    Ok((node, epoch))
}

fn read(n: usize, axis: AboutAxis, names: &[String]) -> Result<PlantAxis, InvalidAbout> {
    let field = format!("axes[{n}]");
    let within = |name: &str| format!("{field}.{name}");
    let is_plain = axis.name.chars().all(|c| !c.is_control());
    if !(1..=LONGEST_NAME).contains(&axis.name.chars().count()) || !is_plain {
        let received = format!("{:?}", axis.name);
        let expected = "1 to 64 characters";
        return Err(InvalidAbout::new(within("name"), received, expected));
    }
    let published = match (&axis.channel, axis.id) {
        (Some(name), Some(id)) => {
            let mut channels = Channel::ALL.into_iter();
            let channel = channels.find(|channel| channel.carries_axes() && channel.name() == name);
            let expected = "axes, slaves or far-axes";
            Some((
                channel.ok_or_else(|| InvalidAbout::new(within("channel"), name, expected))?,
                id,
            ))
        }
        _ => None,
    };
    check_limits(axis.limits).map_err(|(name, received)| {
        InvalidAbout::new(
            within(&format!("limits.{name}")),
            received,
            "a number above 0",
        )
    })?;
    Ok(PlantAxis {
        origin: origin(&axis, names, &field)?,
        name: axis.name,
        field,
        published,
        unit: axis.unit,
        modulo: axis.modulo,
        limits: axis.limits,
    })
}

fn check_limits(limits: Option<StatedLimits>) -> Result<(), (&'static str, f64)> {
    let Some(limits) = limits else {
        return Ok(());
    };
    for (name, limit) in [
        ("velocity", limits.velocity),
        ("acceleration", limits.acceleration),
        ("deceleration", limits.deceleration),
        ("jerk", limits.jerk.unwrap_or(1.0)),
    ] {
        if !(limit > 0.0 && limit.is_finite()) {
            return Err((name, limit));
        }
    }
    Ok(())
}

fn origin(axis: &AboutAxis, names: &[String], field: &str) -> Result<AxisOrigin, InvalidAbout> {
    let motion = match axis.kind {
        AboutKind::Program => RootMotion::Program,
        AboutKind::Encoder => RootMotion::Encoder,
        AboutKind::Replay => RootMotion::Replay,
        AboutKind::Plc => RootMotion::Plc,
        AboutKind::Unknown => RootMotion::Unknown,
        AboutKind::Far => {
            return Ok(AxisOrigin::Far(far(
                axis,
                field,
                Showing::Later(LagRule::Full),
            )?));
        }
        AboutKind::Output => return Ok(AxisOrigin::Output(far(axis, field, Showing::AsReceived)?)),
        AboutKind::Slave => {
            let place = |master: &String| names.iter().position(|name| name == master);
            let masters = axis.masters.iter().filter_map(place).collect();
            return Ok(AxisOrigin::Slave { masters });
        }
    };
    Ok(AxisOrigin::Root {
        motion,
        present_after: present_after(axis, field)?,
        // A node does not say whom it waits for.
        followers: Vec::new(),
    })
}

fn present_after(axis: &AboutAxis, field: &str) -> Result<Option<PresentAfterRange>, InvalidAbout> {
    let Some(least) = axis.present_after_us else {
        return Ok(None);
    };
    let most = axis.present_after_at_most_us.unwrap_or(least);
    for (value, name) in [
        (least, "present_after_us"),
        (most, "present_after_at_most_us"),
    ] {
        if !(Span::ZERO..=PresentAfterRange::LONGEST).contains(&Span::from_micros_f64(value)) {
            return Err(InvalidAbout::new(
                format!("{field}.{name}"),
                value,
                "0 to 4000000",
            ));
        }
    }
    let [least, most] = [least, most].map(Span::from_micros_f64);
    Ok(Some(PresentAfterRange {
        least,
        most: most.max(least),
    }))
}

fn far(axis: &AboutAxis, field: &str, showing: Showing) -> Result<FarReference, InvalidAbout> {
    let read = |text: &String| {
        let expected = "an address such as line/axes/1";
        AxisAddress::read(text)
            .ok_or_else(|| InvalidAbout::new(format!("{field}.follows"), text, expected))
    };
    let sources: Result<Vec<_>, _> = axis.follows.iter().map(read).collect();
    Ok(FarReference {
        field: field.to_owned(),
        sources: sources?,
        way: WaySource::Unknown,
        showing,
        measured: None,
    })
}

#[cfg(test)]
mod tests;
