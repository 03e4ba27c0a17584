//! Synchronisation positions relative to now, which are converted once into positions of the axes.

use coaxle_axis::{Awaits, Modulo, NotPlanned, PlanInputs, Planned, TravelDirection};
use coaxle_cam::{Activation, ActivationMode, Tables};
use coaxle_curve::profile::Kinematics;
use coaxle_gear::FlyingGearParameters;
use coaxle_saw::{GearInPos, SawCommand};

use super::SlaveAxis;
use super::plan::coupled;
use crate::change::Effect;
use crate::command::Command;
use crate::couplings::{CouplingRefusal, Engagement, Kind};
use crate::refusal::Refusal;
use crate::sync_position::{MASTER_TURNS, SLAVE_TURNS, SyncPosition, Travel, WrongSyncPosition};

/// The modulo periods of the axes that synchronise.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SyncPeriods {
    /// Period of the first master.
    master: Option<Modulo>,
    /// Period of the axis.
    own: Option<Modulo>,
}

/// Positions of master and slave, and the forward direction of each.
struct Travels {
    master: Travel,
    slave: Travel,
}

impl SlaveAxis {
    /// Sets the modulo period of the axis and of its first master; none for an axis without one.
    /// Positions count continuously across periods: this is for positions commanded and shown
    /// within a period.
    pub const fn set_modulo(&mut self, own: Option<Modulo>, master: Option<Modulo>) {
        self.turns = SyncPeriods { master, own };
    }

    /// Modulo period of the axis.
    #[must_use]
    pub const fn modulo(&self) -> Option<Modulo> {
        self.turns.own
    }

    /// Checks the positions within a modulo period in a command.
    ///
    /// # Errors
    /// [`WrongSyncPosition`] names the field.
    pub fn check_sync_positions(&self, command: &Command) -> Result<(), WrongSyncPosition> {
        let SyncPeriods { master, own } = self.turns;
        match command {
            Command::GearInPos(saw) => {
                saw.master_sync_position
                    .check("master-sync-position", master)?;
                saw.slave_sync_position.check("slave-sync-position", own)
            }
            Command::FlyingGear(gear) => {
                gear.master_sync_position
                    .check("master-sync-position", master)?;
                gear.slave_sync_position.check("slave-sync-position", own)?;
                gear.slave_desync_position
                    .check("slave-desync-position", own)?;
                gear.slave_stop_position.check("slave-stop-position", own)
            }
            _ => {
                // A copy: one accessor serves for reading and for changing.
                match activation_of(&mut { *command }).and_then(|activation| in_turn(activation)) {
                    Some((position, _)) => position.check("activation.in-turn", master),
                    None => Ok(()),
                }
            }
        }
    }

    /// The command with a position of its master that counts from now: for an activation, the next
    /// passage of the master at a position within its modulo period.
    pub(super) fn placed_now(&self, command: &Command) -> Result<Command, Refusal> {
        let mut command = *command;
        if let Some(activation) = activation_of(&mut command)
            && let Some((position, way)) = in_turn(activation)
        {
            let masters = self.seen_masters();
            let master = masters.first().ok_or(Refusal::NoMaster)?;
            let travel = Travel {
                position: master.position,
                ahead: way.unwrap_or_else(|| ahead_of(master, masters.travel(0))),
                modulo: self.turns.master,
            };
            // Resolved once: a position that moved along with the master would never be reached.
            *activation = Activation::at(activation.mode, position.of(&travel, 0));
        }
        Ok(command)
    }

    /// The current command to a flying saw that results from a command, the first one tried: for a
    /// refused command, the one that its refusal refers to. None for other commands, or without a
    /// master.
    #[must_use]
    pub fn saw_command(&self, command: &Command) -> Option<SawCommand> {
        match command {
            Command::GearInPos(saw) => {
                let inputs = self.plan_inputs(Kind::Saw);
                let travels = self.travels(&inputs, saw.ratio.value())?;
                Some(SawCommand::GearInPos(saw.at(
                    saw.master_sync_position.of(&travels.master, 0),
                    saw.slave_sync_position.of(&travels.slave, 0),
                )))
            }
            Command::GearInVelo(saw) => Some(SawCommand::GearInVelo(*saw)),
            _ => None,
        }
    }

    pub(super) fn plan_gear_in_pos(
        &self,
        plates: &Tables,
        saw: &GearInPos<SyncPosition>,
    ) -> Result<(Effect, Awaits), Refusal> {
        let inputs = self.plan_inputs(Kind::Saw);
        let plan = |saw| self.plan_saw(plates, &SawCommand::GearInPos(saw), &inputs);
        // Two absolute positions have a single plan, and its refusal is the answer.
        if let (SyncPosition::At(master), SyncPosition::At(slave)) = saw.positions() {
            return coupled(plan(saw.at(master, slave)));
        }
        let travels = self.travels(&inputs, saw.ratio.value());
        let travels = travels.ok_or(Refusal::NoMaster)?;
        first_that_passes(saw.positions(), |on_master, on_slave| {
            plan(saw.at(
                saw.master_sync_position.of(&travels.master, on_master),
                saw.slave_sync_position.of(&travels.slave, on_slave),
            ))
        })
    }

    pub(super) fn plan_flying_gear(
        &self,
        plates: &Tables,
        gear: &FlyingGearParameters<SyncPosition>,
    ) -> Result<(Effect, Awaits), Refusal> {
        let inputs = self.plan_inputs(Kind::FlyingGear);
        let travels = self.travels(&inputs, gear.ratio).ok_or(Refusal::NoMaster)?;
        let pair = (gear.master_sync_position, gear.slave_sync_position);
        first_that_passes(pair, |on_master, on_slave| {
            let gear = placed(gear, &travels, on_master, on_slave);
            self.couplings.flying_gear(plates, &gear, &inputs)
        })
    }

    /// Positions and directions as the coupling sees them; none without a master.
    fn travels(&self, inputs: &PlanInputs, ratio: f64) -> Option<Travels> {
        let master = inputs.masters.first()?;
        let ahead = ahead_of(master, inputs.masters.travel(0));
        Some(Travels {
            master: Travel {
                position: master.position,
                ahead,
                modulo: self.turns.master,
            },
            slave: Travel {
                position: inputs.slave.position,
                // A negative ratio moves the slave against its master.
                ahead: if ratio < 0.0 { ahead.opposite() } else { ahead },
                modulo: self.turns.own,
            },
        })
    }
}

/// Activation of a cam command's change.
const fn activation_of(command: &mut Command) -> Option<&mut Activation> {
    match command {
        Command::CamIn(command) => Some(&mut command.activation),
        Command::CamScaling(command) => Some(&mut command.activation),
        Command::CamInV2(command) => Some(&mut command.activation),
        Command::CamAdd(command) => Some(&mut command.activation),
        Command::CamExchange(command) => Some(&mut command.activation),
        Command::CamRemove(command) => Some(&mut command.activation),
        Command::CamScalingV2(command) => Some(&mut command.activation),
        _ => None,
    }
}

/// The activation position within the modulo period of the master axis, and the required direction
/// of the master, if the mode has one; none for an activation without. Invalid combinations are
/// refused by the plates.
fn in_turn(activation: &Activation) -> Option<(SyncPosition, Option<TravelDirection>)> {
    let way = match activation.mode {
        ActivationMode::AtMasterAxisPos => None,
        ActivationMode::AtMasterAxisPosPositiveDirection => Some(TravelDirection::Forward),
        ActivationMode::AtMasterAxisPosNegativeDirection => Some(TravelDirection::Backward),
        _ => return None,
    };
    // A position beside it is a contradiction, which the plates refuse.
    let within = activation.in_turn.filter(|_| activation.position == 0.0)?;
    Some((SyncPosition::InTurn(within), way))
}

/// Direction of travel of a master. For a measured one its increments decide; a master at rest
/// counts as moving to larger positions.
fn ahead_of(master: &Kinematics, measured: Option<TravelDirection>) -> TravelDirection {
    // The velocity of a measured master ripples around 0 at rest. Its increments have a direction.
    measured.unwrap_or(if master.velocity < 0.0 {
        TravelDirection::Backward
    } else {
        TravelDirection::Forward
    })
}

/// Positions of a flying gear: the slave is released at the next passage after it is synchronous,
/// and stands at the next passage after that.
fn placed(
    gear: &FlyingGearParameters<SyncPosition>,
    travels: &Travels,
    on_master: i32,
    on_slave: i32,
) -> FlyingGearParameters {
    let slave = &travels.slave;
    // From the position before, and not from the axis: otherwise the release could lie before the synchronous
    // position.
    let beyond = |position: SyncPosition, from: f64| match position {
        SyncPosition::InTurn(_) => position.of(
            &Travel {
                position: from,
                ..*slave
            },
            0,
        ),
        _ => position.of(slave, 0),
    };
    let sync = gear.slave_sync_position.of(slave, on_slave);
    let desync = beyond(gear.slave_desync_position, sync);
    FlyingGearParameters {
        ratio: gear.ratio,
        master_sync_position: gear.master_sync_position.of(&travels.master, on_master),
        slave_sync_position: sync,
        slave_desync_position: desync,
        slave_stop_position: beyond(gear.slave_stop_position, desync),
        default_slave_negative: gear.default_slave_negative,
    }
}

/// The first periods of master and slave whose plan is accepted: the nearest one ahead of the slave
/// with any period of the master, then others. If none passes, the very first refusal is returned.
fn first_that_passes(
    (master, slave): (SyncPosition, SyncPosition),
    plan: impl Fn(i32, i32) -> Result<Planned<Engagement>, NotPlanned<CouplingRefusal>>,
) -> Result<(Effect, Awaits), Refusal> {
    // Kept, because the refusal of the nearest pair tells more than that of the last one tried.
    let first = plan(0, 0);
    let mut pairs = (slave.turns(&SLAVE_TURNS).iter())
        .flat_map(|on_slave| {
            master
                .turns(&MASTER_TURNS)
                .iter()
                .map(move |n| (*n, *on_slave))
        })
        // The first pair has been planned already.
        .skip(1);
    let passed = match first {
        Ok(_) => None,
        Err(_) => pairs.find_map(|(on_master, on_slave)| plan(on_master, on_slave).ok()),
    };
    coupled(passed.map_or(first, Ok))
}
