//! Commands to a far node: the inputs of `FB_AxisSync` while the node runs. Plan, then apply.
//!
//! After a command the set values continue from their current state: all changes are blended over
//! `blending-time-s`, and a delay is slewed.

use coaxle_clock::far_clock::DelaySource;
use coaxle_node::command::{
    CommandOutcome, FarCommand, FarOrder, FarRefusal, FarView, ParameterPart,
};
use coaxle_remote::{AxisSyncChanges, AxisSyncParameters, CheckedParameters, FilterMode};

use super::FarNode;
use super::axis::Axis;
use super::clock::Clock;
use crate::signals::FarNodeSignals;

/// A change of a far node. Applying it cannot fail.
#[derive(Clone, Copy, Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "it never leaves the cycle's stack, and boxing it would allocate there"
)]
pub(super) enum FarChange {
    /// The state is the commanded one already.
    Nothing,
    Disable,
    /// Enables if necessary, and restarts.
    Start,
    Mode(FilterMode),
    Parameters {
        parameters: AxisSyncParameters,
        checked: CheckedParameters,
    },
    Delay(DelaySource),
}

/// Effects of the commands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OrderCounters {
    re_initialisations: u32,
    parameter_changes: u32,
}

impl OrderCounters {
    pub(super) const fn show(&self, signals: &mut FarNodeSignals) {
        signals.re_initialisations = self.re_initialisations;
        signals.parameter_changes = self.parameter_changes;
    }
}

impl FarNode {
    /// Executes a command from the network. A dry run is a plan that is not applied.
    pub(crate) fn execute(&mut self, order: &FarOrder) -> CommandOutcome {
        match self.plan(&order.command) {
            Err(refusal) => CommandOutcome::FarRefused {
                refusal,
                far: self.view(),
            },
            Ok(change) => {
                if !order.dry_run {
                    self.apply(&change);
                }
                CommandOutcome::FarAccepted { far: self.view() }
            }
        }
    }

    /// Plans the effect of a command.
    pub(super) fn plan(&self, command: &FarCommand) -> Result<FarChange, FarRefusal> {
        let enabled = self.followed().clock.is_enabled();
        match command {
            FarCommand::Enable {} if enabled => Ok(FarChange::Nothing),
            FarCommand::Disable {} if !enabled => Ok(FarChange::Nothing),
            FarCommand::ReInitialise {} if !enabled => Err(FarRefusal::Disabled),
            FarCommand::Enable {} | FarCommand::ReInitialise {} => Ok(FarChange::Start),
            FarCommand::Disable {} => Ok(FarChange::Disable),
            FarCommand::FilterMode(mode) => match *mode {
                same if same == self.followed().clock.mode() => Ok(FarChange::Nothing),
                other => Ok(FarChange::Mode(other)),
            },
            FarCommand::SetParameters(changes) => self.plan_parameters(changes),
            FarCommand::SetDelay(delay) => plan_delay(*delay),
        }
    }

    /// Applies a plan to the clocks of all nodes that it may be read from.
    pub(super) fn apply(&mut self, change: &FarChange) {
        let clocks = self.candidates.iter_mut().map(|node| &mut node.clock);
        match change {
            FarChange::Nothing => {}
            FarChange::Disable => {
                clocks.for_each(Clock::disable);
                self.axes.iter_mut().for_each(Axis::re_initialise);
            }
            FarChange::Start => {
                clocks.for_each(Clock::re_initialise);
                self.axes.iter_mut().for_each(Axis::re_initialise);
                self.orders.re_initialisations += 1;
            }
            FarChange::Mode(mode) => {
                clocks.for_each(|clock| clock.set_mode(*mode));
                self.axes.iter_mut().for_each(Axis::carry_on);
                self.drop_old_messages();
            }
            FarChange::Parameters {
                parameters,
                checked,
            } => {
                clocks.for_each(|clock| clock.set_parameters(parameters, checked));
                for axis in &mut self.axes {
                    axis.set_parameters(checked);
                }
                self.drop_old_messages();
                self.orders.parameter_changes += 1;
            }
            FarChange::Delay(delay) => {
                clocks.for_each(|clock| clock.set_delay(*delay));
                self.orders.parameter_changes += 1;
            }
        }
    }

    /// Has the inboxes drop messages that are too old by the parameters and the mode in force.
    fn drop_old_messages(&mut self) {
        for node in &mut self.candidates {
            let limit = node.age_limit();
            node.inbox.set_age_limit(limit);
        }
    }

    fn plan_parameters(&self, changes: &AxisSyncChanges) -> Result<FarChange, FarRefusal> {
        if changes.is_empty() {
            return Err(FarRefusal::NothingToChange);
        }
        let parameters = changes.over(*self.followed().clock.parameters());
        let refused = |part| move |wrong| FarRefusal::Parameter { part, wrong };
        let extrapolate = parameters.extrapolate.check();
        extrapolate.map_err(refused(ParameterPart::Extrapolate))?;
        let checked = self.followed().clock.check(&parameters);
        Ok(FarChange::Parameters {
            parameters,
            checked: checked.map_err(refused(ParameterPart::TimeSync))?,
        })
    }

    /// The state for the response to a command.
    fn view(&self) -> FarView {
        FarView {
            enabled: self.followed().clock.is_enabled(),
            mode: self.followed().clock.mode(),
            synced: self.followed().synced,
            delay: self.followed().clock.delay(),
        }
    }
}

fn plan_delay(delay: DelaySource) -> Result<FarChange, FarRefusal> {
    match delay {
        DelaySource::Fixed(span) if !delay.is_in_range() => Err(FarRefusal::Delay {
            received: span.as_micros_f64(),
        }),
        in_range => Ok(FarChange::Delay(in_range)),
    }
}
