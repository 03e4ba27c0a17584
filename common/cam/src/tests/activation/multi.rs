//! Modes by operation for superposed plates.

use super::*;

#[test]
fn switch_in_a_multi_cam() {
    for (mode, _, is, ..) in MANUAL {
        let mut rig = Rig::multi(BACK_AND_FORTH);
        rig.lead(100.0, 1.0);
        let started = rig.start(CamRequest::from(CamExchange {
            activation: activation(mode, position(mode)),
            table: SMALL,
            jump: JumpHandling::Allow,
            ..CamExchange::default()
        }));
        if let No(code) = is {
            assert_eq!(started.unwrap_err().code(), code, "{mode:?}");
            continue;
        }
        let old = |rig: &Rig, master| rig.raw(BACK_AND_FORTH, master);
        let new = |rig: &Rig, master| rig.raw(SMALL, master);
        follow(&mut rig, is, 180.0, &format!("{mode:?}"), old, new);
    }
}

#[test]
fn add_to_a_multi_cam() {
    for (mode, is, ..) in MANUAL {
        let mut rig = Rig::multi(BACK_AND_FORTH);
        rig.lead(100.0, 1.0);
        let started = rig.start(CamRequest::from(CamAdd {
            activation: activation(mode, position(mode)),
            table: SPARE,
            jump: JumpHandling::Allow,
            ..CamAdd::default()
        }));
        if let No(code) = is {
            assert_eq!(started.unwrap_err().code(), code, "{mode:?}");
            continue;
        }
        // The cycles of the added plate are 200 long, and so begin elsewhere.
        let is = match (mode, is) {
            (NextCycle, _) => At(200.0),
            // Its return falls into another place of this master's path, which `follow` does not describe.
            (NextCycleOnce, _) => continue,
            _ => is,
        };
        let old = |rig: &Rig, master| rig.raw(BACK_AND_FORTH, master);
        let base = match is {
            At(200.0) => 200.0,
            _ => 0.0,
        };
        let new = |rig: &Rig, master| {
            // Added at 200 it begins in its base cycle there, and so without the stroke before.
            let strokes = if base == 0.0 { 0.0 } else { 10.0 };
            rig.raw(BACK_AND_FORTH, master) + rig.raw(SPARE, master) - strokes
        };
        follow(&mut rig, is, 360.0, &format!("{mode:?}"), old, new);
    }
}

#[test]
fn remove_from_a_multi_cam() {
    for (mode, _, is, ..) in MANUAL {
        let mut rig = Rig::multi(BACK_AND_FORTH);
        rig.start(CamRequest::from(CamAdd {
            table: SMALL,
            ..CamAdd::default()
        }))
        .unwrap();
        rig.lead(100.0, 1.0);
        let started = rig.start(CamRequest::from(CamRemove {
            activation: activation(mode, position(mode)),
            table: BACK_AND_FORTH,
            jump: JumpHandling::Allow,
        }));
        if let No(code) = is {
            assert_eq!(started.unwrap_err().code(), code, "{mode:?}");
            continue;
        }
        let old = |rig: &Rig, master| rig.raw(BACK_AND_FORTH, master) + rig.raw(SMALL, master);
        let new = |rig: &Rig, master| rig.raw(SMALL, master);
        follow(&mut rig, is, 360.0, &format!("{mode:?}"), old, new);
        if is != Nothing {
            assert_eq!(rig.state(started.unwrap()), CommandState::Done, "{mode:?}");
        }
    }
}
