//! Slaves as followers of far axes: their number, their state, and what they can do.

use coaxle_curve::profile::Limits;

use super::slave::Slave;
use super::{Master, Slaves};
use crate::config::MasterRef;

/// Slaves of a far axis, directly or behind other slaves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SlavesOfAxis {
    pub(crate) slaves: u16,
    pub(crate) in_sync: u16,
    pub(crate) in_error: u16,
    /// Greatest distance of a slave in sync from the position of its coupling, u.
    pub(crate) distance: f64,
}

impl Slaves {
    /// Counts the slaves of each far axis. A slave is in sync if the axis, and all between them, are known and well.
    pub(crate) fn count_followers(&self, far: &[Option<Master>], counts: &mut [SlavesOfAxis]) {
        counts.fill(SlavesOfAxis::default());
        for (slave, roots) in self.slaves.iter().zip(&self.roots) {
            let knows = |root: &usize| far[*root].is_some_and(|master| master.is_ready);
            let is_led = roots.iter().all(knows);
            for root in roots {
                counts[*root].add(slave, is_led);
            }
        }
    }

    /// Computes the limits within which each far axis leads its slaves within theirs. `own` is a place for each slave.
    pub(crate) fn limits_of_far_axes(&self, own: &mut [Limits], far: &mut [Limits]) {
        far.fill(Limits::NONE);
        for (own, slave) in own.iter_mut().zip(&self.slaves) {
            *own = *slave.axis.limits();
        }
        // Slaves before their masters, whose own limits are those of all behind them, too.
        for &n in self.order.iter().rev() {
            let slave = &self.slaves[n];
            // It stops by itself, whatever its master does.
            if slave.error().is_some() {
                continue;
            }
            for (number, source) in slave.sources().iter().enumerate() {
                let limits = slave.axis.limits_of_master(&self.plates, number, &own[n]);
                let of_master = match *source {
                    MasterRef::Far(axis) => &mut far[axis],
                    MasterRef::Slave(master) => &mut own[master],
                    MasterRef::Virtual(_) => continue,
                };
                *of_master = of_master.at_most(&limits);
            }
        }
    }
}

impl SlavesOfAxis {
    /// True if the numbers are the same.
    pub(crate) fn is_alike(&self, other: &Self) -> bool {
        (self.slaves, self.in_sync, self.in_error) == (other.slaves, other.in_sync, other.in_error)
    }

    fn add(&mut self, slave: &Slave, is_led: bool) {
        self.slaves += 1;
        if slave.error().is_some() {
            self.in_error += 1;
        } else if is_led && slave.is_in_sync() {
            self.in_sync += 1;
            self.distance = self.distance.max(slave.axis.distance().abs());
        }
    }
}

/// Returns the far axes at the roots of each slave; `order` has masters before their slaves.
pub(super) fn roots(order: &[usize], sources: &[Vec<MasterRef>]) -> Box<[Box<[usize]>]> {
    let mut roots = vec![Vec::new(); sources.len()];
    for &n in order {
        let mut own: Vec<usize> = Vec::new();
        for source in &sources[n] {
            match *source {
                MasterRef::Far(axis) => own.push(axis),
                MasterRef::Slave(master) => own.extend(&roots[master]),
                MasterRef::Virtual(_) => {}
            }
        }
        own.sort_unstable();
        own.dedup();
        roots[n] = own;
    }
    roots.into_iter().map(Vec::into_boxed_slice).collect()
}
