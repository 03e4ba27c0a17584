//! Masters of each slave, resolved by name: far axes, virtual axes or other slaves.

use coaxle_axis::{Masters, Modulo};

use coaxle_node::config::{Unit, Wrong, did_you_mean};

use super::{FarAxisConfig, FarConfig, ReceiverConfig};

/// The master of a slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MasterRef {
    /// The far axis with this number, counted through all far nodes.
    Far(usize),
    /// The virtual axis with this number.
    Virtual(usize),
    /// The slave with this number.
    Slave(usize),
}

/// Greatest number of names listed for an unknown one.
const MOST_LISTED: usize = 24;

impl ReceiverConfig {
    /// The far axes with their nodes, in the order of their numbers.
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

    /// The first master of the n-th slave.
    ///
    /// # Errors
    /// [`Wrong`] names the slave, and the existing masters.
    pub fn master_of(&self, n: usize) -> Result<MasterRef, Wrong> {
        let master = self.slaves[n].master.as_str();
        // An empty name is a default only where there is no choice.
        if master.is_empty()
            && let Some(only) = self.only_axis()
        {
            return Ok(only);
        }
        self.master_called(master)
            .ok_or_else(|| self.no_master(n, "master", master))
    }

    /// The masters of the n-th slave, starting with the first.
    ///
    /// # Errors
    /// [`Wrong`] names the slave and the field.
    pub fn masters_of(&self, n: usize) -> Result<Vec<MasterRef>, Wrong> {
        let further = &self.slaves[n].further_masters;
        let most = Masters::MOST - 1;
        if further.len() > most {
            let field = format!("slave[{n}].further-masters");
            let expected = format!("at most {most}");
            return Err(Wrong::of(field, further.len(), expected));
        }
        let mut masters = vec![self.master_of(n)?];
        for (k, name) in further.iter().enumerate() {
            let field = format!("further-masters[{k}]");
            let master = self.master_called(name);
            let master = master.ok_or_else(|| self.no_master(n, &field, name))?;
            // By the axis and not by the name: a far axis has two names.
            if masters.contains(&master) {
                let wrong = Wrong::of(field, format_args!("{name:?} twice"), "each master once");
                return Err(wrong.within(format_args!("slave[{n}]")));
            }
            masters.push(master);
        }
        Ok(masters)
    }

    /// The number of the far axis of this name, its own or `node.id`.
    pub(crate) fn far_axis_called(&self, name: &str) -> Option<usize> {
        let is_it = |(_, far, axis): (usize, &FarConfig, &FarAxisConfig)| {
            axis.name.as_ref().is_some_and(|own| own.as_str() == name)
                || far.full_name(axis.id) == name
        };
        self.far_axes().position(is_it)
    }

    /// The only far axis; without any, the only virtual axis.
    fn only_axis(&self) -> Option<MasterRef> {
        match (self.far_axes().count(), self.virtual_axes.len()) {
            (1, _) => Some(MasterRef::Far(0)),
            (0, 1) => Some(MasterRef::Virtual(0)),
            _ => None,
        }
    }

    /// The far axis, the virtual axis or the slave of this name.
    fn master_called(&self, master: &str) -> Option<MasterRef> {
        // The order does not matter in a valid config, where names are unique among all kinds.
        if let Some(axis) = self.far_axis_called(master) {
            return Some(MasterRef::Far(axis));
        }
        if let Some(axis) = self.virtual_axis_called(master) {
            return Some(MasterRef::Virtual(axis));
        }
        let slave = self.slaves.iter().position(|s| s.name.as_str() == master);
        slave.map(MasterRef::Slave)
    }

    fn no_master(&self, n: usize, field: &str, received: &str) -> Wrong {
        let expected = format!("one of: {}", listed(received, self.masters(n)));
        let wrong = Wrong::of(field, format_args!("{received:?}"), expected);
        wrong.within(format_args!("slave[{n}]"))
    }

    /// Unit of a far axis, by its number among all far axes.
    #[must_use]
    pub fn far_axis_unit(&self, axis: usize) -> Unit {
        let unit = |(_, far, axis): (_, &FarConfig, &FarAxisConfig)| {
            let unit = axis.unit.as_ref().or(far.unit.as_ref());
            unit.cloned()
        };
        self.far_axes().nth(axis).and_then(unit).unwrap_or_default()
    }

    /// Modulo period of a master; none without one.
    #[must_use]
    pub fn modulo_of(&self, master: MasterRef) -> Option<Modulo> {
        match master {
            MasterRef::Far(axis) => {
                let (_, far, axis) = self.far_axes().nth(axis)?;
                axis.modulo.or(far.modulo)
            }
            MasterRef::Virtual(axis) => self.virtual_axes.get(axis)?.modulo,
            MasterRef::Slave(slave) => self.slaves.get(slave)?.modulo,
        }
    }

    /// Sets the unit of a far axis, unless the config does.
    pub fn far_axis_is_in(&mut self, axis: usize, unit: Unit) {
        let Some((far, _, _)) = self.far_axes().nth(axis) else {
            return;
        };
        let within = axis - self.first_axis_of(far);
        // A unit stated for the node holds for all of its axes.
        if self.far[far].unit.is_none() {
            self.far[far].axes.set_default_unit(within, unit);
        }
    }

    /// Unit of the n-th slave: its own, or that of its master.
    #[must_use]
    pub fn slave_unit(&self, n: usize) -> Unit {
        let mut slave = n;
        // At most as many steps as there are slaves, because they may follow each other in a circle.
        for _ in 0..self.slaves.len() {
            if let Some(unit) = &self.slaves[slave].unit {
                return unit.clone();
            }
            match self.master_of(slave) {
                Ok(MasterRef::Far(axis)) => return self.far_axis_unit(axis),
                Ok(MasterRef::Virtual(axis)) => return self.virtual_axis_unit(axis),
                Ok(MasterRef::Slave(master)) => slave = master,
                Err(_) => break,
            }
        }
        Unit::default()
    }

    /// The names of all possible masters of the n-th slave.
    fn masters(&self, n: usize) -> Vec<String> {
        let slaves = self.slaves.iter().enumerate();
        let others = slaves.filter(|(other, _)| *other != n);
        let mut names = self.far_axis_names();
        names.extend(self.virtual_axis_names());
        names.extend(others.map(|(_, slave)| slave.name.to_string()));
        names
    }

    /// The far or virtual axis at the root of the n-th slave, by first masters, if these are valid.
    #[must_use]
    pub fn root_of(&self, n: usize) -> Option<MasterRef> {
        let mut slave = n;
        // As many steps as slaves and one more: the last step reads the axis. A circle ends here as well.
        for _ in 0..=self.slaves.len() {
            match self.master_of(slave).ok()? {
                axis @ (MasterRef::Far(_) | MasterRef::Virtual(_)) => return Some(axis),
                MasterRef::Slave(master) => slave = master,
            }
        }
        None
    }
}

/// Lists names in one line, as far as they fit, with a suggestion.
pub(super) fn listed(received: &str, mut names: Vec<String>) -> String {
    // Before the list is cut, so that a name beyond it can still be suggested.
    let meant = did_you_mean(received, names.iter().map(String::as_str));
    let left_out = names.len().saturating_sub(MOST_LISTED);
    names.truncate(MOST_LISTED);
    let mut list = names.join(", ");
    if left_out > 0 {
        list += &format!(", and {left_out} more");
    }
    list + &meant
}
