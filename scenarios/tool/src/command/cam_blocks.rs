//! The orders about cam plates with their options, as the command line spells them.

use super::blocks::{Block, Field, TABLE, block, may, must};

/// Every cam order but `cam-table-select`, whose plate comes from a file.
pub(super) fn cam_blocks() -> Vec<Block> {
    vec![
        block("cam-table-delete", "Take a plate out", &[&[TABLE]]),
        block(
            "read-motion-function",
            "MC_ReadMotionFunction: points of a plate, as they are in force",
            &[&[
                TABLE,
                may("point", "The first of them; 1 by default"),
                may("number", "How many; all that follow by default"),
            ]],
        ),
        block(
            "read-motion-function-point",
            "MC_ReadMotionFunctionPoint: one point, as it is in force",
            &[&[TABLE, must("point", "Which one")]],
        ),
        block(
            "read-motion-function-values",
            "MC_ReadMotionFunctionValues: a plate as a table of values",
            &[&[
                TABLE,
                must("from", "Where the master is first"),
                must("to", "Where the master is last"),
                must("increment", "How far it is from row to row"),
                VALUES,
            ]],
        ),
        block(
            "read-cam-table-slave-dynamics",
            "MC_ReadCamTableSlaveDynamics: the slave where the master is",
            &[&[
                TABLE,
                must("master-position", "Where the master is on the plate"),
                MASTER_VELOCITY,
            ]],
        ),
        block(
            "read-cam-table-characteristics",
            "MC_ReadCamTableCharacteristics: what a plate demands of the slave",
            &[&[TABLE, MASTER_VELOCITY]],
        ),
        block(
            "read-cam-table-master-position",
            "MC_ReadCamTableMasterPosition: where the master is when the slave is somewhere",
            &[&[
                TABLE,
                must("slave-position", "Where the slave axis is"),
                may(
                    "master-start-position",
                    "Where the search begins, on the master axis",
                ),
                may("master-offset", "Offset of the master"),
                may("slave-offset", "Offset of the slave"),
                may("master-scaling", "Scaling of the master"),
                may("slave-scaling", "Scaling of the slave"),
                may("master-accuracy", "How near counts as on both sides"),
            ]],
        ),
        block(
            "cam-info",
            "MC_CamInfo, MC_CamInfo_V2: what the coupling is like",
            &[&[
                may("table", "Id of the plate, if there are several"),
                may("master-position", "Where the master axis is supposed to be"),
            ]],
        ),
    ]
}

const MASTER_VELOCITY: Field = may(
    "master-velocity",
    "Velocity of the master, in its units per second; 1 by default",
);

const VALUES: Field = may(
    "values",
    "'[\"position\", \"velocity\", \"acceleration\", \"jerk\"]', or the sum of 1, 2, 4 and 8; the position by default",
);
