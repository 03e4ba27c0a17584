//! Every command with its options, as the command line spells them.

/// A command of the command line.
pub(super) struct Block {
    pub(super) name: &'static str,
    pub(super) about: &'static str,
    pub(super) options: Vec<Field>,
}

/// An option, and the field of the command that it sets.
#[derive(Clone, Copy)]
pub(super) struct Field {
    pub(super) name: &'static str,
    /// Path in the command, with dots.
    pub(super) path: &'static str,
    pub(super) help: &'static str,
    pub(super) required: bool,
}

/// A field that must be given.
pub(super) const fn must(name: &'static str, help: &'static str) -> Field {
    needed(name, name, help)
}

/// A field of a part of the command, or with another name there, which must be given.
const fn needed(name: &'static str, path: &'static str, help: &'static str) -> Field {
    Field {
        name,
        path,
        help,
        required: true,
    }
}

/// A field that may be given.
pub(super) const fn may(name: &'static str, help: &'static str) -> Field {
    inner(name, name, help)
}

/// A field of a part of the command, which may be given.
pub(super) const fn inner(name: &'static str, path: &'static str, help: &'static str) -> Field {
    Field {
        name,
        path,
        help,
        required: false,
    }
}

/// A command, with its options in groups.
pub(super) fn block(name: &'static str, about: &'static str, options: &[&[Field]]) -> Block {
    Block {
        name,
        about,
        options: options.concat(),
    }
}

pub(super) const TABLE: Field = must("table", "Id of the plate");
const REFERENCE: Field = may("reference", "Id of the plate it is exchanged for");
const JUMP: Field = may(
    "jump",
    "If the slave would jump: refuse, allow, or '{ \"ramp-in\": { \"master-length\": 10 } }'",
);
const VELOCITY: Field = may("velocity", "Highest speed on the way, u/s");

const PHASING_VELOCITY: Field = may("velocity", "Highest speed of the shift, master u/s");
const ADDED_VELOCITY: Field = may("velocity", "How much faster it may be, u/s");

const DYNAMICS: &[Field] = &[
    inner("acceleration", "dynamics.acceleration", "Highest, u/s²"),
    inner("deceleration", "dynamics.deceleration", "Highest, u/s²"),
    inner("jerk", "dynamics.jerk", "Highest, u/s³"),
];

const ACTIVATION: &[Field] = &[
    inner(
        "activation",
        "activation.mode",
        "When: instantaneous, at-master-cam-pos, at-master-axis-pos, next-cycle, …",
    ),
    inner(
        "activation-position",
        "activation.position",
        "Where the master is then",
    ),
];

const SCALING: &[Field] = &[
    inner(
        "master-scaling-mode",
        "scaling.master.mode",
        "user-defined, auto-offset or off",
    ),
    inner(
        "master-relative",
        "scaling.master.relative",
        "true: from where the master is",
    ),
    inner("master-offset", "scaling.master.offset", "Offset, u"),
    inner("master-scaling", "scaling.master.scaling", "Scaling"),
    inner(
        "slave-scaling-mode",
        "scaling.slave.mode",
        "user-defined, auto-offset or off",
    ),
    inner(
        "slave-relative",
        "scaling.slave.relative",
        "true: from where the slave is",
    ),
    inner("slave-offset", "scaling.slave.offset", "Offset, u"),
    inner("slave-scaling", "scaling.slave.scaling", "Scaling"),
];

const CAM_IN: &[Field] = &[
    may(
        "start-mode",
        "absolute, relative, master-absolute-slave-relative, master-relative-slave-absolute",
    ),
    may("master-offset", "Offset of the master, u"),
    may("slave-offset", "Offset of the slave, u"),
    may("master-scaling", "Scaling of the master"),
    may("slave-scaling", "Scaling of the slave"),
    may("master-scaling-mode", "user-defined, auto-offset or off"),
    may("slave-scaling-mode", "user-defined, auto-offset or off"),
];

const FLYING_GEAR: &[Field] = &[
    must("ratio", "Slave units per master unit"),
    must(
        "master-sync-position",
        "Where the master is when engaged, master u; or ahead=500, or in-turn=90",
    ),
    must(
        "slave-sync-position",
        "Where the slave is then, u; or ahead=500, or in-turn=90",
    ),
    must(
        "slave-desync-position",
        "Where the release begins, u; or ahead=500, or in-turn=90",
    ),
    must(
        "slave-stop-position",
        "Where the slave is released, u; or ahead=500, or in-turn=90",
    ),
    may(
        "default-slave-negative",
        "true: works towards smaller positions",
    ),
];

const RATIO: &[Field] = &[
    needed(
        "ratio",
        "ratio.numerator",
        "Slave units per master unit; with a denominator, the numerator of that",
    ),
    inner("ratio-denominator", "ratio.denominator", "1 to 65535"),
];

const SYNC_POSITIONS: &[Field] = &[
    needed(
        "master-sync",
        "master-sync-position",
        "Where the master is when they are synchronous, master u; or ahead=500, or in-turn=90",
    ),
    needed(
        "slave-sync",
        "slave-sync-position",
        "Where the slave is then, u; or ahead=500, or in-turn=90",
    ),
    inner(
        "master-start-distance",
        "master-start-distance",
        "How far before that the synchronisation begins, master u",
    ),
    inner(
        "strategy",
        "strategy",
        "late, slow or early, instead of the profiles of TS5055",
    ),
];

const SYNC_MODE: &[Field] = &[
    inner("base", "sync-mode.base", "position-based or time-based"),
    inner(
        "mask",
        "sync-mode.mask",
        "Checks and operations, as JSON: '[\"max-velo\", \"rollback-lock\"]'",
    ),
];

const SYNC_LIMITS: &[Field] = &[
    inner("velocity", "limits.velocity", "Highest speed, u/s"),
    inner("acceleration", "limits.acceleration", "Highest, u/s²"),
    inner("deceleration", "limits.deceleration", "Highest, u/s²"),
    inner("jerk", "limits.jerk", "Highest, u/s³"),
    inner("min-position", "limits.min-position", "Lowest, u"),
    inner("max-position", "limits.max-position", "Highest, u"),
];

/// Every command but `power`, which has a state instead of options.
pub(super) fn blocks() -> Vec<Block> {
    let position = |help| must("position", help);
    vec![
        block("reset", "MC_Reset: acknowledge an error", &[]),
        block(
            "home",
            "MC_Home: declare where the axis stands",
            &[&[position("Where it stands, u")]],
        ),
        block(
            "move-absolute",
            "MC_MoveAbsolute: go to a position",
            &[&[position("Where to, u"), VELOCITY], DYNAMICS],
        ),
        block(
            "move-relative",
            "MC_MoveRelative: go a distance",
            &[&[must("distance", "How far, u"), VELOCITY], DYNAMICS],
        ),
        block(
            "move-velocity",
            "MC_MoveVelocity: move at a velocity",
            &[&[must("velocity", "u/s, with its sign")], DYNAMICS],
        ),
        block("halt", "MC_Halt: come to rest", &[DYNAMICS]),
        block(
            "stop",
            "MC_Stop: come to rest, whatever else is commanded",
            &[DYNAMICS],
        ),
        block(
            "gear-in",
            "MC_GearIn: couple by a constant ratio",
            &[&[must("ratio", "Slave units per master unit")], DYNAMICS],
        ),
        block(
            "gear-in-multi-master",
            "MC_GearInMultiMaster: couple to the sum of several masters, or change the ratios",
            &[
                &[
                    must("ratios", "Of each master, as JSON: '[1, -0.5]'"),
                    may(
                        "sync-mode",
                        "pos-sync2: the way that changes of the ratios leave behind is caught up",
                    ),
                ],
                DYNAMICS,
            ],
        ),
        block(
            "phasing-absolute",
            "MC_PhasingAbsolute: shift the master as the slave sees it",
            &[
                &[must("shift", "How far, master u"), PHASING_VELOCITY],
                DYNAMICS,
            ],
        ),
        block(
            "phasing-relative",
            "MC_PhasingRelative: shift the master by so much more",
            &[
                &[must("shift", "How far, master u"), PHASING_VELOCITY],
                DYNAMICS,
            ],
        ),
        block(
            "move-superimposed",
            "MC_MoveSuperImposed: add a distance to what moves the axis",
            &[&[must("distance", "How far, u"), ADDED_VELOCITY], DYNAMICS],
        ),
        block("gear-out", "MC_GearOut: uncouple, keep the velocity", &[]),
        block(
            "flying-gear",
            "MC_FlyingGear: couple and release on the fly",
            &[FLYING_GEAR],
        ),
        block(
            "gear-in-pos",
            "MC_GearInPos: flying saw to a pair of positions",
            &[RATIO, SYNC_POSITIONS, SYNC_MODE, SYNC_LIMITS],
        ),
        block(
            "gear-in-velo",
            "MC_GearInVelo: flying saw to the gear's velocity",
            &[RATIO, SYNC_MODE, SYNC_LIMITS],
        ),
        block(
            "read-flying-saw-characteristics",
            "MC_ReadFlyingSawCharacteristics: what the flying saw demands",
            &[],
        ),
        block(
            "cam-in",
            "MC_CamIn: couple by a plate, or switch to it",
            &[&[TABLE], CAM_IN, ACTIVATION, &[JUMP]],
        ),
        block("cam-out", "MC_CamOut: uncouple, keep the velocity", &[]),
        block(
            "cam-scaling",
            "MC_CamScaling: scale the plate",
            &[SCALING, ACTIVATION, &[JUMP]],
        ),
        block(
            "cam-in-v2",
            "MC_CamIn_V2: couple by one of several plates, or change them",
            &[&[TABLE, OPERATION, REFERENCE], SCALING, ACTIVATION, &[JUMP]],
        ),
        block(
            "cam-add",
            "MC_CamAdd: superpose one more plate",
            &[&[TABLE], SCALING, ACTIVATION, &[JUMP]],
        ),
        block(
            "cam-exchange",
            "MC_CamExchange: put a plate in the place of another",
            &[&[TABLE, REFERENCE], SCALING, ACTIVATION, &[JUMP]],
        ),
        block(
            "cam-remove",
            "MC_CamRemove: take a plate out",
            &[&[TABLE], ACTIVATION, &[JUMP]],
        ),
        block(
            "cam-scaling-v2",
            "MC_CamScaling_V2: scale one of the plates",
            &[
                &[may("table", "Id of the plate")],
                SCALING,
                ACTIVATION,
                &[JUMP],
            ],
        ),
        block(
            "set-cam-online-change-mode",
            "MC_SetCamOnlineChangeMode: when written points take effect",
            &[&[TABLE], ONLINE_CHANGE],
        ),
        block(
            "write-motion-function",
            "MC_WriteMotionFunction: change 1 to 4 points of a plate",
            &[&[TABLE, must("points", "The points, as JSON")]],
        ),
    ]
}

const OPERATION: Field = may("operation", "default, additive, exchange or remove");

const ONLINE_CHANGE: &[Field] = &[
    inner(
        "activation",
        "mode.activation.mode",
        "When: instantaneous, next-cycle, as-soon-as-possible, delete-queued-data, …",
    ),
    inner(
        "activation-position",
        "mode.activation.position",
        "Where the master is then",
    ),
    inner(
        "master-scaling-mode",
        "mode.master-scaling-mode",
        "user-defined, auto-offset or off",
    ),
    inner(
        "slave-scaling-mode",
        "mode.slave-scaling-mode",
        "user-defined, auto-offset or off",
    ),
    inner("jump", "mode.jump", JUMP.help),
];
