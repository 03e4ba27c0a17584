//! Which master each slave means: a far axis or another slave, by its name.

use super::{FarAxisConfig, FarConfig, ReceiverConfig};

/// A slave that no receiver can have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{field}: {reason}")]
pub struct WrongSlave {
    /// The slave and its field.
    pub field: String,
    /// What was received and what is expected, with the NC's code where there is one.
    pub reason: String,
}

/// The master of a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MasterRef {
    /// The far axis with this number, counted through all far nodes.
    Far(usize),
    /// The slave with this number.
    Slave(usize),
}

/// Names that are listed where one is not known.
const MOST_LISTED: usize = 24;

impl ReceiverConfig {
    /// All far axes with their nodes, in the order in which they are numbered.
    pub fn far_axes(&self) -> impl Iterator<Item = (usize, &FarConfig, &FarAxisConfig)> {
        let axes = |(n, far)| move |axis| (n, far, axis);
        (self.far.iter().enumerate()).flat_map(move |(n, far)| far.axes.iter().map(axes((n, far))))
    }

    /// The number of the first axis of a far node.
    #[must_use]
    pub fn first_axis_of(&self, far: usize) -> usize {
        self.far[..far].iter().map(|far| far.axes.count()).sum()
    }

    /// The names of all far axes.
    #[must_use]
    pub fn far_axis_names(&self) -> Vec<String> {
        let name = |(_, far, axis): (usize, &FarConfig, &FarAxisConfig)| far.axis_name(axis);
        self.far_axes().map(name).collect()
    }

    /// The master of the n-th slave.
    ///
    /// # Errors
    /// [`WrongSlave`] names the slave, and the masters that there are.
    pub fn master_of(&self, n: usize) -> Result<MasterRef, WrongSlave> {
        let master = self.slaves[n].master.as_str();
        let axes = self.far_axes().count();
        if master.is_empty() && axes == 1 {
            return Ok(MasterRef::Far(0));
        }
        let is_axis = |(_, far, axis): (usize, &FarConfig, &FarAxisConfig)| {
            axis.name
                .as_ref()
                .is_some_and(|name| name.as_str() == master)
                || far.full_name(axis.id) == master
        };
        if let Some(axis) = self.far_axes().position(is_axis) {
            return Ok(MasterRef::Far(axis));
        }
        let slave = self.slaves.iter().position(|s| s.name.as_str() == master);
        slave.map(MasterRef::Slave).ok_or_else(|| WrongSlave {
            field: format!("slave[{n}].master"),
            reason: format!("received {master:?}, expected one of: {}", self.masters(n)),
        })
    }

    /// The names of all that the n-th slave could follow.
    fn masters(&self, n: usize) -> String {
        let slaves = self.slaves.iter().enumerate();
        let others = slaves.filter(|(other, _)| *other != n);
        let mut names = self.far_axis_names();
        names.extend(others.map(|(_, slave)| slave.name.to_string()));
        let left_out = names.len().saturating_sub(MOST_LISTED);
        names.truncate(MOST_LISTED);
        let mut list = names.join(", ");
        if left_out > 0 {
            list += &format!(", and {left_out} more");
        }
        list
    }

    /// The far axis at the root of the n-th slave, if its masters are right.
    #[must_use]
    pub fn far_axis_of(&self, n: usize) -> Option<usize> {
        let mut slave = n;
        for _ in 0..=self.slaves.len() {
            match self.master_of(slave).ok()? {
                MasterRef::Far(axis) => return Some(axis),
                MasterRef::Slave(master) => slave = master,
            }
        }
        None
    }
}
