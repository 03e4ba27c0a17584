//! Slaves as a config has them: checked, and in an order in which masters come before their slaves.

use std::path::Path;

use coaxle_clock::CycleTime;
use coaxle_motion::cam::coupling::Tables;
use coaxle_motion::drive::Drive;
use coaxle_motion::gear::LinearGear;
use coaxle_motion::slave::{CoupledStart, SlaveAxis};
use coaxle_node::cam_file::CamFile;

use super::Slaves;
use super::follower::Follower;
use super::slave::{Body, Slave, Source};
use super::tool::Tool;
use crate::config::{CamSource, CoupleConfig, MOST_SLAVES, ReceiverConfig, SlaveConfig};
use crate::program::Program;

/// A slave that no receiver can have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {reason}")]
pub struct WrongSlave {
    /// The slave and its field.
    pub field: String,
    /// What was received and what is expected, with the NC's code where there is one.
    pub reason: String,
}

impl Slaves {
    /// # Errors
    /// [`WrongSlave`] names the slave and the field.
    pub(crate) fn new(config: &ReceiverConfig) -> Result<Self, WrongSlave> {
        let slaves = &config.slaves;
        if !(1..=MOST_SLAVES).contains(&slaves.len()) {
            return Err(WrongSlave {
                field: "slave".to_owned(),
                reason: format!(
                    "received {} slaves, expected 1 to {MOST_SLAVES}",
                    slaves.len()
                ),
            });
        }
        check_names_and_ids(config)?;
        let sources = sources(slaves)?;
        let order = in_order(slaves, &sources)?;
        let mut by_id: Vec<usize> = (0..slaves.len()).collect();
        by_id.sort_by_key(|n| config.slave_id(*n));
        let slaves = (0..slaves.len())
            .map(|n| slave(config, n, sources[n]))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
            axes: Vec::with_capacity(slaves.len()),
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

fn sources(slaves: &[SlaveConfig]) -> Result<Vec<Source>, WrongSlave> {
    let source = |(n, slave): (usize, &SlaveConfig)| {
        if slave.master.is_empty() {
            return Ok(Source::Far);
        }
        let is_master = |other: &SlaveConfig| other.name.as_str() == slave.master;
        slaves
            .iter()
            .position(is_master)
            .map(Source::Slave)
            .ok_or_else(|| {
                let reason = format!(
                    "received {:?}, expected the name of a slave, or none for the far axis",
                    slave.master
                );
                wrong(n, "master", reason)
            })
    };
    slaves.iter().enumerate().map(source).collect()
}

/// Masters before their slaves.
fn in_order(slaves: &[SlaveConfig], sources: &[Source]) -> Result<Vec<usize>, WrongSlave> {
    let mut order: Vec<usize> = Vec::new();
    while order.len() < slaves.len() {
        let is_next = |n: &usize| {
            let has_master = match sources[*n] {
                Source::Far => true,
                Source::Slave(master) => order.contains(&master),
            };
            has_master && !order.contains(n)
        };
        match (0..slaves.len()).find(is_next) {
            Some(n) => order.push(n),
            None => return Err(circle(slaves, &order)),
        }
    }
    Ok(order)
}

fn circle(slaves: &[SlaveConfig], order: &[usize]) -> WrongSlave {
    let n = (0..slaves.len())
        .find(|n| !order.contains(n))
        .unwrap_or_default();
    let reason = format!(
        "0x816f: received {:?}, which follows {:?} in the end, or a circle of others; expected the \
         far axis at the root",
        slaves[n].master,
        slaves[n].name.as_str()
    );
    wrong(n, "master", reason)
}

fn slave(config: &ReceiverConfig, n: usize, source: Source) -> Result<Slave, WrongSlave> {
    let slave = &config.slaves[n];
    let gear = LinearGear::new(slave.gear.ratio, slave.gear.offset)
        .map_err(|error| wrong(n, "gear", error))?;
    let drive = Drive::new(slave.drive).map_err(|error| wrong(n, "drive", error))?;
    let id = config.slave_id(n);
    let body = match &slave.limits {
        None => {
            check_follower(slave, n)?;
            Body::Follower(Follower::new(gear, drive))
        }
        Some(limits) => {
            let cycle_time: CycleTime = config.cycle_time_us.0;
            let mut axis = SlaveAxis::new(limits, drive, cycle_time)
                .map_err(|error| wrong(n, "limits", error))?;
            let master_id = match source {
                Source::Far => config.master.axis,
                Source::Slave(master) => config.slave_id(master),
            };
            axis.select_cams(tables(slave, n)?, master_id, id);
            let start = match slave.couple() {
                CoupleConfig::Off => None,
                CoupleConfig::Gear => Some(CoupledStart::Gear(gear)),
                CoupleConfig::Cam(cam_in) => {
                    axis.cam_tables()
                        .plate(cam_in.table)
                        .map_err(|error| wrong(n, "couple.cam.table", error))?;
                    Some(CoupledStart::Cam(cam_in))
                }
            };
            Body::Axis {
                axis: Box::new(axis),
                start,
            }
        }
    };
    check_cutting(slave, n)?;
    let program = Program::new(&slave.steps, slave.marks.as_ref())
        .map_err(|error| wrong(n, &error.field, &error.reason))?;
    Ok(Slave::new(
        id,
        source,
        body,
        Tool::new(&slave.tool),
        program,
    ))
}

/// A slave without limits does nothing but follow its gear.
fn check_follower(slave: &SlaveConfig, n: usize) -> Result<(), WrongSlave> {
    let needs = if !slave.steps.is_empty() {
        "a program"
    } else if !slave.cams.is_empty() {
        "cams"
    } else if slave.couple() != CoupleConfig::Gear {
        "a coupling other than the gear"
    } else {
        return Ok(());
    };
    let reason = format!("received none, expected some: a slave with {needs} is watched");
    Err(wrong(n, "limits", reason))
}

fn check_cutting(slave: &SlaveConfig, n: usize) -> Result<(), WrongSlave> {
    if let Some(marks) = &slave.marks {
        marks.check().map_err(|error| wrong(n, "marks", error))?;
    }
    let tool = &slave.tool;
    if !tool.ratio.is_finite() || tool.ratio == 0.0 {
        let reason = format!("received {}, expected a number other than 0", tool.ratio);
        return Err(wrong(n, "tool.ratio", reason));
    }
    if tool.cuts_every.is_some() && slave.steps.iter().any(|step| step.cut) {
        let reason = "received one beside steps that cut, expected one or the other";
        return Err(wrong(n, "tool.cuts-every", reason));
    }
    Ok(())
}

fn tables(slave: &SlaveConfig, n: usize) -> Result<Tables, WrongSlave> {
    let mut tables = Tables::new(slave.cams.len());
    for (k, source) in slave.cams.iter().enumerate() {
        let field = format!("cams[{k}]");
        let cam = match source {
            CamSource::File(file) => CamFile::load(file),
            CamSource::Here(table) => CamFile::from_table("here", Path::new(""), table.clone()),
        };
        let cam = cam.map_err(|error| wrong(n, &field, error))?;
        let id = cam
            .table_id
            .ok_or_else(|| wrong(n, &field, "0x4b32: received no table-id, expected 1 to 255"))?;
        let plate = cam.plate().map_err(|error| wrong(n, &field, error))?;
        tables
            .insert(id.get().into(), plate)
            .map_err(|error| wrong(n, &field, error))?;
    }
    Ok(tables)
}
