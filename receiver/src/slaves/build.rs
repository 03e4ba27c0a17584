//! Slaves of a config: checked, and in an order in which masters come before their slaves.

use coaxle_axis::NcToPlcAxis;
use coaxle_cam::Tables;
use coaxle_clock::CycleTime;
use coaxle_gear::LinearGear;
use coaxle_node::config::Wrong;
use coaxle_node::frame::MAX_AXES;
use coaxle_slave::{CIRCLE_CODE, CoupledStart, SlaveAxis};

use super::Slaves;
use super::followers::roots;
use super::plates::{plates, plates_of_steps};
use super::slave::{Slave, SlaveParts};
use super::tool::Tool;
use crate::config::{CoupleConfig, MasterRef, ReceiverConfig, SlaveConfig};
use crate::drives::Drives;
use crate::program::{Program, StepConfig};

impl Slaves {
    /// # Errors
    /// [`Wrong`] names the slave and the field.
    pub(crate) fn new(config: &ReceiverConfig, mut drives: Drives) -> Result<Self, Wrong> {
        let slaves = &config.slaves;
        if slaves.len() > MAX_AXES {
            let received = format!("{} slaves", slaves.len());
            let expected = format!("at most {MAX_AXES}: their frame holds no more");
            return Err(Wrong::of("slave", received, expected));
        }
        // Before masters are resolved, which names have to identify.
        for n in 0..slaves.len() {
            check_name_and_id(config, n).map_err(within(n))?;
        }
        drives.check(config)?;
        let sources = (0..slaves.len())
            .map(|n| config.masters_of(n))
            .collect::<Result<Vec<_>, _>>()?;
        let order = in_order(slaves, &sources)?;
        let mut by_id: Vec<usize> = (0..slaves.len()).collect();
        by_id.sort_by_key(|n| config.slave_id(*n));
        let has_slaves = |n| (sources.iter()).any(|of| of.contains(&MasterRef::Slave(n)));
        let leads = (0..slaves.len()).map(has_slaves).collect();
        let roots = roots(&order, &sources);
        let mut plates = plates(config)?;
        let slaves = (sources.into_iter().enumerate())
            .map(|(n, sources)| {
                slave(config, n, sources, &mut drives, &mut plates).map_err(within(n))
            })
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
            plates,
            leads,
            roots,
            axes: vec![NcToPlcAxis::default(); slaves.len()].into(),
            slaves,
            order,
            by_id,
        })
    }
}

/// Adds the place of the n-th slave to an error.
fn within(n: usize) -> impl Fn(Wrong) -> Wrong {
    move |wrong| wrong.within(format_args!("slave[{n}]"))
}

fn check_name_and_id(config: &ReceiverConfig, n: usize) -> Result<(), Wrong> {
    let slave = &config.slaves[n];
    let name = slave.name.as_str();
    // A reference by node and id leads to the far axis, whatever else is called so.
    let is_far = config.far_axis_called(name).is_some();
    let is_virtual = config.virtual_axis_called(name).is_some();
    for (is_taken, what) in [(is_far, "far"), (is_virtual, "virtual")] {
        if is_taken {
            let received = format!("{name:?}, which is a {what} axis");
            return Err(Wrong::of("name", received, "a name of its own"));
        }
    }
    let before = &config.slaves[..n];
    if before.iter().any(|other| other.name == slave.name) {
        let received = format!("{name:?} twice");
        return Err(Wrong::of("name", received, "a name of its own"));
    }
    let id = config.slave_id(n);
    if (0..n).any(|other| config.slave_id(other) == id) {
        let received = format!("{id} twice");
        return Err(Wrong::of("id", received, "an id of its own"));
    }
    Ok(())
}

/// Orders masters before their slaves.
fn in_order(slaves: &[SlaveConfig], sources: &[Vec<MasterRef>]) -> Result<Vec<usize>, Wrong> {
    // Quadratic in at most 128 slaves, and at the start only.
    let mut order: Vec<usize> = Vec::new();
    while order.len() < slaves.len() {
        let is_next = |n: &usize| {
            let has_masters = !sources[*n].iter().any(|master| comes_later(master, &order));
            has_masters && !order.contains(n)
        };
        match (0..slaves.len()).find(is_next) {
            // Always the first that can be next: independent slaves keep the order of the config.
            Some(n) => order.push(n),
            None => return Err(circle(slaves, sources, &order)),
        }
    }
    Ok(order)
}

fn comes_later(master: &MasterRef, order: &[usize]) -> bool {
    match master {
        MasterRef::Far(_) | MasterRef::Virtual(_) => false,
        MasterRef::Slave(master) => !order.contains(master),
    }
}

fn circle(slaves: &[SlaveConfig], sources: &[Vec<MasterRef>], order: &[usize]) -> Wrong {
    let n = (0..slaves.len())
        .find(|n| !order.contains(n))
        .unwrap_or_default();
    let slave = &slaves[n];
    let place = (sources[n].iter()).position(|master| comes_later(master, order));
    let (field, master) = match place {
        None | Some(0) => ("master".to_owned(), &slave.master),
        Some(k) => (
            format!("further-masters[{}]", k - 1),
            &slave.further_masters[k - 1],
        ),
    };
    let received = format!(
        "{master:?}, which follows {:?} in the end or a circle of others",
        slave.name.as_str()
    );
    let wrong = Wrong::of(field, received, "a far or virtual axis at the root");
    within(n)(wrong.with_code(CIRCLE_CODE))
}

fn slave(
    config: &ReceiverConfig,
    n: usize,
    sources: Vec<MasterRef>,
    drives: &mut Drives,
    plates: &mut Tables,
) -> Result<Slave, Wrong> {
    let slave = &config.slaves[n];
    let gear = LinearGear::new(slave.gear.ratio, slave.gear.offset)
        .map_err(|error| Wrong::with_reason("gear", error))?;
    if drives.has_real(slave) {
        check_real_drive(slave)?;
    }
    let id = config.slave_id(n);
    let limits = slave.limits();
    let cycle_time: CycleTime = config.cycle_time_us.0;
    let drive = drives.take(slave)?;
    let mut axis = SlaveAxis::new(&limits, drive, cycle_time)
        .map_err(|error| Wrong::with_reason("limits", error))?;
    axis.set_dead_time(slave.dead_time_us.span());
    if config.may_hold_back() {
        axis.prepare_hold_back();
    }
    axis.set_modulo(slave.modulo, config.modulo_of(sources[0]));
    axis.prepare_cams(id_of_master(config, sources[0]), id)
        .map_err(|error| Wrong::with_reason("limits", error))?;
    let start = match slave.couple() {
        CoupleConfig::Off => None,
        CoupleConfig::Gear => Some(CoupledStart::Gear(gear)),
        CoupleConfig::Cam(cam_in) => {
            // Now, and not when the master comes, which may be hours later.
            (plates.plate(cam_in.table))
                .map_err(|error| Wrong::with_reason("couple.cam.table", error))?;
            Some(CoupledStart::Cam(cam_in))
        }
    };
    check_steps(&axis, slave)?;
    check_awaited(config, sources[0], slave)?;
    check_cutting(slave)?;
    // After the plates of the config, since all of them share the room.
    let of_steps = plates_of_steps(plates, &slave.steps)?;
    let program = Program::new(&slave.steps, slave.marks.as_ref(), &of_steps)?;
    Ok(Slave::new(SlaveParts {
        id,
        master_modulo: config.modulo_of(sources[0]),
        sources: sources.into(),
        axis: Box::new(axis),
        start,
        on_master_loss: limits.on_master_loss,
        tool: Tool::new(&slave.tool),
        program,
    }))
}

fn id_of_master(config: &ReceiverConfig, master: MasterRef) -> u32 {
    match master {
        MasterRef::Far(axis) => config
            .far_axes()
            .nth(axis)
            .map_or(0, |(_, _, axis)| axis.id),
        MasterRef::Virtual(axis) => config.virtual_axes[axis].id.get(),
        MasterRef::Slave(master) => config.slave_id(master),
    }
}

/// Checks a drive that is not simulated: it needs monitoring, and no coupling can place it anywhere
/// at once.
fn check_real_drive(slave: &SlaveConfig) -> Result<(), Wrong> {
    if slave.limits.is_none() {
        let expected = "some: only a simulated drive says what it can do";
        return Err(Wrong::of("limits", "none", expected));
    }
    if slave.couple() != CoupleConfig::Off {
        let expected = "\"off\": a drive that is not simulated is given power first, by a step of the program or by a \
                        command, and coupled then";
        return Err(Wrong::of("couple", "a coupling from the start", expected));
    }
    Ok(())
}

/// Checks the steps: positions by modulo period require an axis that has one.
fn check_steps(axis: &SlaveAxis, slave: &SlaveConfig) -> Result<(), Wrong> {
    for (k, step) in slave.steps.iter().enumerate() {
        let Some(command) = step.slave_command() else {
            continue;
        };
        axis.check_sync_positions(command)
            .map_err(|error| Wrong::with_reason(format!("step[{k}].do"), error))?;
    }
    Ok(())
}

/// Checks the steps that wait for a position of the master: only a far axis can be promised.
fn check_awaited(
    config: &ReceiverConfig,
    master: MasterRef,
    slave: &SlaveConfig,
) -> Result<(), Wrong> {
    let waits =
        |(k, step): (usize, &StepConfig)| step.when.master_reaches.map(|awaited| (k, awaited));
    for (k, awaited) in slave.steps.iter().enumerate().filter_map(waits) {
        let within = |wrong: Wrong| wrong.within(format_args!("step[{k}]"));
        let received = match master {
            MasterRef::Virtual(_) => Some("a virtual axis as master"),
            MasterRef::Slave(_) => Some("another slave as master"),
            MasterRef::Far(axis) => {
                let far = config.far_axes().nth(axis);
                let uses_plans =
                    far.is_some_and(|(_, far, axis)| far.uses_plans() && axis.uses_plans());
                (!uses_plans).then_some("a master that uses no plans")
            }
        };
        if let Some(received) = received {
            let expected = "an axis of a sender, whose program is promised: not smoothed here, nor within its turn";
            return Err(within(Wrong::of("when.master-reaches", received, expected)));
        }
        awaited.check(config.modulo_of(master)).map_err(within)?;
    }
    Ok(())
}

fn check_cutting(slave: &SlaveConfig) -> Result<(), Wrong> {
    if let Some(marks) = &slave.marks {
        marks.check().map_err(|wrong| wrong.within("marks"))?;
    }
    slave.check_tool()
}
