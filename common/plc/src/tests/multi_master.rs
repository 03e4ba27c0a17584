//! Several masters, with ratios that the program changes in every scan.

use coaxle_axis::{AxisStatus, Masters};
use coaxle_gear::{GearInMultiMaster, MultiMasterSync, Ratios};

use super::*;
use crate::EnableMultiMasterGear;

fn gear(ratio: f64) -> GearInMultiMaster {
    GearInMultiMaster {
        ratios: Ratios::new(&[ratio, 1.0]).expect("ratios"),
        dynamics: OWN,
        sync_mode: MultiMasterSync::default(),
    }
}

#[test]
fn ratios_are_read_in_every_scan_and_the_falling_edge_uncouples() {
    let mut axis = powered(&PARAMETERS);
    let masters = |scan: u32| {
        let at = |velocity: f64| Master::at(velocity * CYCLE.0 * f64::from(scan), velocity);
        Masters::of([100.0, 50.0].map(|velocity| Some(at(velocity).0)))
    };
    axis.update(&mut Tables::new(0), masters(0), CYCLE);
    let mut block = EnableMultiMasterGear::default();
    let outputs = block.scan(true, &gear(1.0), &mut axis, &mut Tables::new(0));
    assert!(outputs.busy && !outputs.in_sync);
    for scan in 0..600 {
        let ratio = if scan < 300 { 1.0 } else { 2.0 };
        axis.update(&mut Tables::new(0), masters(scan + 1), CYCLE);
        block.scan(true, &gear(ratio), &mut axis, &mut Tables::new(0));
    }
    let outputs = block.scan(true, &gear(2.0), &mut axis, &mut Tables::new(0));
    assert!(outputs.in_sync && outputs.busy);
    // 2·100 + 1·50.
    assert_eq!(axis.set().velocity, 250.0);
    // Too fast: the previous ratios stay in force.
    // 20·100 + 50 = 2050, above the limit of 1000.
    let outputs = block.scan(true, &gear(20.0), &mut axis, &mut Tables::new(0));
    assert_eq!((outputs.error, outputs.error_id), (true, 0x42dd));
    assert!(
        block
            .scan(true, &gear(2.0), &mut axis, &mut Tables::new(0))
            .in_sync
    );
    let outputs = block.scan(false, &gear(2.0), &mut axis, &mut Tables::new(0));
    assert!(!outputs.busy && !outputs.error);
    assert_eq!(axis.status(), AxisStatus::ContinuousMotion);
}
