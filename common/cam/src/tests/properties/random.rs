//! Random commands, sensible or not.

use super::*;

#[derive(Clone, Copy, Debug)]
pub(super) enum Action {
    Command(CamRequest),
    Other(CamRequest),
    Mode(TableId, OnlineChangeMode),
    Write(TableId, MotionPoint),
    Go(f64),
    Error,
}

pub(super) fn any_action() -> impl Strategy<Value = Action> {
    prop_oneof![
        6 => any_command().prop_map(Action::Command),
        3 => any_command().prop_map(Action::Other),
        2 => (any_table(), any_activation(), any_mode(), any_mode(), any_jump()).prop_map(
            |(table, activation, master_scaling_mode, slave_scaling_mode, jump)| Action::Mode(
                table,
                OnlineChangeMode { activation, master_scaling_mode, slave_scaling_mode, jump },
            )
        ),
        3 => (any_table(), 1..=3u32, -400.0..400.0f64, -60.0..60.0f64)
            .prop_map(|(table, index, master, slave)| {
                Action::Write(table, rest(index, master, slave))
            }),
        8 => (-900.0..900.0f64).prop_map(Action::Go),
        1 => Just(Action::Error),
    ]
}

fn any_table() -> impl Strategy<Value = TableId> {
    // Five exist. 0 names the only plate, 6 none.
    0..=6u32
}

fn any_activation() -> impl Strategy<Value = Activation> {
    (
        prop::sample::select(&ActivationMode::ALL[..]),
        -400.0..400.0f64,
    )
        .prop_map(|(mode, position)| Activation::at(mode, position))
}

fn any_mode() -> impl Strategy<Value = ScalingMode> {
    prop::sample::select(
        &[
            ScalingMode::UserDefined,
            ScalingMode::AutoOffset,
            ScalingMode::Off,
        ][..],
    )
}

fn any_jump() -> impl Strategy<Value = JumpHandling> {
    prop_oneof![
        1 => Just(JumpHandling::Refuse),
        // More often, since refused changes leave nothing to break.
        3 => Just(JumpHandling::Allow),
        // A few lengths of 0 or less, which must be refused.
        1 => (-1.0..300.0f64).prop_map(|master_length| JumpHandling::RampIn { master_length }),
    ]
}

fn any_axis() -> impl Strategy<Value = AxisScaling> {
    (any_mode(), any::<bool>(), -50.0..50.0f64, -3.0..3.0f64).prop_map(
        |(mode, relative, offset, scaling)| AxisScaling {
            mode,
            relative,
            offset,
            scaling,
        },
    )
}

fn any_command() -> impl Strategy<Value = CamRequest> {
    let inputs = (
        (any_table(), any_table()),
        any_activation(),
        (any_axis(), any_axis()).prop_map(|(master, slave)| ScalingData { master, slave }),
        any_jump(),
    );
    let operation = prop::sample::select(
        &[
            OperationMode::Additive,
            OperationMode::Exchange,
            OperationMode::Remove,
        ][..],
    );
    let start_mode = prop::sample::select(
        &[
            StartMode::Absolute,
            StartMode::Relative,
            StartMode::MasterAbsoluteSlaveRelative,
            StartMode::MasterRelativeSlaveAbsolute,
        ][..],
    );
    (inputs, operation, start_mode, 0..12u8).prop_map(
        |(((table, reference), activation, scaling, jump), operation, start_mode, which)| {
            match which {
                0 | 1 => CamRequest::from(CamIn {
                    table,
                    start_mode,
                    master_offset: scaling.master.offset,
                    slave_offset: scaling.slave.offset,
                    master_scaling: scaling.master.scaling,
                    slave_scaling: scaling.slave.scaling,
                    activation,
                    master_scaling_mode: scaling.master.mode,
                    slave_scaling_mode: scaling.slave.mode,
                    jump,
                }),
                2 => CamOut {}.into(),
                3 => CamRequest::from(CamScaling {
                    activation,
                    scaling,
                    jump,
                }),
                4 | 5 => CamRequest::from(CamInV2 {
                    activation,
                    table,
                    scaling,
                    operation,
                    reference,
                    jump,
                }),
                6 | 7 => CamRequest::from(CamAdd {
                    activation,
                    table,
                    scaling,
                    jump,
                }),
                8 => CamRequest::from(CamExchange {
                    activation,
                    table,
                    reference,
                    scaling,
                    jump,
                }),
                9 | 10 => CamRequest::from(CamRemove {
                    activation,
                    table,
                    jump,
                }),
                _ => CamRequest::from(CamScalingV2 {
                    activation,
                    table,
                    scaling,
                    jump,
                }),
            }
        },
    )
}
