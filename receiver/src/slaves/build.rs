//! Slaves of a config: checked, and in an order in which masters come before their slaves.

use coaxle_axis::NcToPlcAxis;
use coaxle_cam::Tables;
use coaxle_clock::CycleTime;
use coaxle_gear::LinearGear;
use coaxle_node::frame::MAX_AXES;
use coaxle_slave::{CoupledStart, SlaveAxis};

use super::Slaves;
use super::plates::{plates, plates_of_steps};
use super::slave::{Slave, SlaveParts};
use super::tool::Tool;
use crate::config::{CoupleConfig, MasterRef, ReceiverConfig, SlaveConfig, WrongSlave};
use crate::drives::Drives;
use crate::program::Program;

impl Slaves {
    /// # Errors
    /// [`WrongSlave`] names the slave and the field.
    pub(crate) fn new(config: &ReceiverConfig, mut drives: Drives) -> Result<Self, WrongSlave> {
        let slaves = &config.slaves;
        if slaves.len() > MAX_AXES {
            return Err(WrongSlave {
                field: "slave".to_owned(),
                reason: format!(
                    "received {} slaves, expected at most {MAX_AXES}: their frame holds no more",
                    slaves.len()
                ),
            });
        }
        // Before masters are resolved, which names have to identify.
        check_names_and_ids(config)?;
        drives.check(config)?;
        let sources = (0..slaves.len())
            .map(|n| config.masters_of(n))
            .collect::<Result<Vec<_>, _>>()?;
        let order = in_order(slaves, &sources)?;
        let mut by_id: Vec<usize> = (0..slaves.len()).collect();
        by_id.sort_by_key(|n| config.slave_id(*n));
        let has_slaves = |n| (sources.iter()).any(|of| of.contains(&MasterRef::Slave(n)));
        let leads = (0..slaves.len()).map(has_slaves).collect();
        let mut plates = plates(config)?;
        let slaves = (sources.into_iter().enumerate())
            .map(|(n, sources)| slave(config, n, sources, &mut drives, &mut plates))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
            plates,
            leads,
            axes: vec![NcToPlcAxis::default(); slaves.len()].into(),
            slaves,
            order,
            by_id,
        })
    }
}

fn wrong(n: usize, field: &str, reason: impl ToString) -> WrongSlave {
    WrongSlave {
        field: format!("slave[{n}].{field}"),
        reason: reason.to_string(),
    }
}

fn check_names_and_ids(config: &ReceiverConfig) -> Result<(), WrongSlave> {
    for (n, slave) in config.slaves.iter().enumerate() {
        let name = slave.name.as_str();
        // A reference by node and id leads to the far axis, whatever else is called so.
        let is_far = config.far_axis_called(name).is_some();
        let is_virtual = config.virtual_axis_called(name).is_some();
        for (is_taken, what) in [(is_far, "far"), (is_virtual, "virtual")] {
            if is_taken {
                let reason = format!(
                    "received {name:?}, which is a {what} axis, expected a name of its own"
                );
                return Err(wrong(n, "name", reason));
            }
        }
        let before = &config.slaves[..n];
        if before.iter().any(|other| other.name == slave.name) {
            let reason = format!(
                "received {:?} twice, expected a name of its own",
                slave.name.as_str()
            );
            return Err(wrong(n, "name", reason));
        }
        let id = config.slave_id(n);
        if (0..n).any(|other| config.slave_id(other) == id) {
            let reason = format!("received {id} twice, expected an id of its own");
            return Err(wrong(n, "id", reason));
        }
    }
    Ok(())
}

/// Orders masters before their slaves.
fn in_order(slaves: &[SlaveConfig], sources: &[Vec<MasterRef>]) -> Result<Vec<usize>, WrongSlave> {
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

fn circle(slaves: &[SlaveConfig], sources: &[Vec<MasterRef>], order: &[usize]) -> WrongSlave {
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
    let reason = format!(
        "0x816f: received {master:?}, which follows {:?} in the end, or a circle of others; \
         expected a far or virtual axis at the root",
        slave.name.as_str()
    );
    wrong(n, &field, reason)
}

fn slave(
    config: &ReceiverConfig,
    n: usize,
    sources: Vec<MasterRef>,
    drives: &mut Drives,
    plates: &mut Tables,
) -> Result<Slave, WrongSlave> {
    let slave = &config.slaves[n];
    let gear = LinearGear::new(slave.gear.ratio, slave.gear.offset)
        .map_err(|error| wrong(n, "gear", error))?;
    if drives.has_real(slave) {
        check_real_drive(slave, n)?;
    }
    let id = config.slave_id(n);
    let limits = slave.limits();
    let cycle_time: CycleTime = config.cycle_time_us.0;
    let drive = drives
        .take(slave)
        .map_err(|error| wrong(n, "drive", error))?;
    let mut axis =
        SlaveAxis::new(&limits, drive, cycle_time).map_err(|error| wrong(n, "limits", error))?;
    axis.set_modulo(slave.modulo, config.modulo_of(sources[0]));
    axis.prepare_cams(id_of_master(config, sources[0]), id)
        .map_err(|error| wrong(n, "limits", error))?;
    let start = match slave.couple() {
        CoupleConfig::Off => None,
        CoupleConfig::Gear => Some(CoupledStart::Gear(gear)),
        CoupleConfig::Cam(cam_in) => {
            // Now, and not when the master comes, which may be hours later.
            (plates.plate(cam_in.table)).map_err(|error| wrong(n, "couple.cam.table", error))?;
            Some(CoupledStart::Cam(cam_in))
        }
    };
    check_steps(&axis, slave, n)?;
    check_cutting(slave, n)?;
    // After the plates of the config, since all of them share the room.
    let of_steps = plates_of_steps(plates, n, &slave.steps)?;
    let program = Program::new(&slave.steps, slave.marks.as_ref(), &of_steps)
        .map_err(|error| wrong(n, &error.field, &error.reason))?;
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
fn check_real_drive(slave: &SlaveConfig, n: usize) -> Result<(), WrongSlave> {
    if slave.limits.is_none() {
        let reason = "received none, expected some: only a simulated drive says what it can do";
        return Err(wrong(n, "limits", reason));
    }
    if slave.couple() != CoupleConfig::Off {
        let reason = "received a coupling from the start, expected \"off\": a drive that is not simulated is \
                      given power first, by a step of the program or by a command, and coupled then";
        return Err(wrong(n, "couple", reason));
    }
    Ok(())
}

/// Checks the steps: positions by modulo period require an axis that has one.
fn check_steps(axis: &SlaveAxis, slave: &SlaveConfig, n: usize) -> Result<(), WrongSlave> {
    for (k, step) in slave.steps.iter().enumerate() {
        let Some(command) = step.slave_command() else {
            continue;
        };
        axis.check_sync_positions(command)
            .map_err(|error| wrong(n, &format!("step[{k}].do"), error))?;
    }
    Ok(())
}

fn check_cutting(slave: &SlaveConfig, n: usize) -> Result<(), WrongSlave> {
    if let Some(marks) = &slave.marks {
        marks.check().map_err(|error| wrong(n, "marks", error))?;
    }
    slave
        .check_tool()
        .map_err(|(field, reason)| wrong(n, field, reason))
}
