//! Every error code of TF5055 8.1.

use super::super::{Check, SyncMask, Violation};
use super::*;

/// A command that violates a check: master velocity, slave velocity, gear, and the distance of the slave
/// while the master runs at its velocity for one second.
struct Case {
    check: Check,
    mask: SyncMask,
    master: f64,
    slave: f64,
    gear: f64,
    distance: f64,
    limits: SyncLimits,
}

const fn case(check: Check, mask: SyncMask, speeds: (f64, f64), gear: f64, distance: f64) -> Case {
    Case {
        check,
        mask,
        master: speeds.0,
        slave: speeds.1,
        gear,
        distance,
        limits: SyncLimits {
            velocity: None,
            acceleration: None,
            deceleration: None,
            jerk: None,
            min_position: None,
            max_position: None,
            master_velocity: None,
        },
    }
}

fn limited(case: Case, limits: SyncLimits) -> Case {
    Case { limits, ..case }
}

fn cases() -> [Case; 26] {
    use Check as C;
    use SyncMask as M;
    let low = SyncLimits {
        min_position: Some(-1.0),
        ..SyncLimits::default()
    };
    let high = SyncLimits {
        max_position: Some(1.0),
        ..SyncLimits::default()
    };
    // Below the synchronous 100 u/s, and yet no refusal of the gear: that goes by the axis's own limit.
    let slow = SyncLimits {
        velocity: Some(99.0),
        ..SyncLimits::default()
    };
    // A change by 100 u/s within a second peaks at 1.5 times its mean of 100 u/s².
    let weak = dynamics(100.0, 1e6);
    // A quintic from rest over 60 u with 100 u/s at its end has 6·c3 = 1200 u/s³ at the start.
    let smooth = dynamics(1e5, 600.0);
    let forward = (100.0, 50.0);
    [
        case(C::MinPos, M::MIN_POS, (100.0, -100.0), 1.0, 50.0),
        case(C::MaxPos, M::MAX_POS, (100.0, 100.0), -1.0, -50.0),
        limited(
            case(
                C::OptionalMinPos,
                M::OPTIONAL_MIN_POS,
                (100.0, -100.0),
                1.0,
                50.0,
            ),
            low,
        ),
        limited(
            case(
                C::OptionalMaxPos,
                M::OPTIONAL_MAX_POS,
                (100.0, 100.0),
                -1.0,
                -50.0,
            ),
            high,
        ),
        case(
            C::UndershootPosBackward,
            M::UNDERSHOOT_POS,
            (100.0, -300.0),
            -1.0,
            -60.0,
        ),
        case(
            C::UndershootPosForward,
            M::UNDERSHOOT_POS,
            (100.0, -100.0),
            1.0,
            50.0,
        ),
        case(
            C::OvershootPosBackward,
            M::OVERSHOOT_POS,
            (100.0, 100.0),
            -1.0,
            -50.0,
        ),
        case(
            C::OvershootPosForward,
            M::OVERSHOOT_POS,
            (100.0, 300.0),
            1.0,
            60.0,
        ),
        limited(case(C::MaxVelo, M::MAX_VELO, forward, 1.0, 75.0), slow),
        limited(
            case(C::MinVelo, M::MAX_VELO, (100.0, -50.0), -1.0, -75.0),
            slow,
        ),
        case(
            C::OvershootVeloForwardFromBelow,
            M::OVERSHOOT_VELO,
            forward,
            1.0,
            120.0,
        ),
        case(
            C::OvershootVeloForwardFromAbove,
            M::OVERSHOOT_VELO,
            (100.0, 200.0),
            1.0,
            250.0,
        ),
        case(
            C::OvershootVeloBackwardFromBelow,
            M::OVERSHOOT_VELO,
            (-100.0, -200.0),
            1.0,
            -50.0,
        ),
        case(
            C::OvershootVeloBackwardFromAbove,
            M::OVERSHOOT_VELO,
            (-100.0, -50.0),
            1.0,
            -20.0,
        ),
        case(
            C::UndershootVeloForwardFromAbove,
            M::UNDERSHOOT_VELO,
            (100.0, 200.0),
            1.0,
            50.0,
        ),
        case(
            C::UndershootVeloForwardFromBelow,
            M::UNDERSHOOT_VELO,
            forward,
            1.0,
            20.0,
        ),
        case(
            C::UndershootVeloBackwardFromAbove,
            M::UNDERSHOOT_VELO,
            (-100.0, -50.0),
            1.0,
            -120.0,
        ),
        case(
            C::UndershootVeloBackwardFromBelow,
            M::UNDERSHOOT_VELO,
            (-100.0, -200.0),
            1.0,
            -250.0,
        ),
        case(
            C::OvershootVeloZeroForward,
            M::OVERSHOOT_VELO_ZERO,
            (100.0, -50.0),
            -1.0,
            -5.0,
        ),
        case(
            C::OvershootVeloZeroBackward,
            M::OVERSHOOT_VELO_ZERO,
            (-100.0, -50.0),
            1.0,
            -5.0,
        ),
        case(
            C::UndershootVeloZeroForward,
            M::UNDERSHOOT_VELO_ZERO,
            forward,
            1.0,
            5.0,
        ),
        case(
            C::UndershootVeloZeroBackward,
            M::UNDERSHOOT_VELO_ZERO,
            (-100.0, 50.0),
            -1.0,
            5.0,
        ),
        limited(case(C::MaxAcc, M::MAX_ACC, (100.0, 0.0), 1.0, 50.0), weak),
        limited(
            case(C::MaxDec, M::MAX_DEC, (100.0, 200.0), 1.0, 150.0),
            weak,
        ),
        // From rest, the jerk is by far the largest at the start.
        limited(
            case(C::MaxJerk, M::MAX_JERK, (100.0, 0.0), 1.0, 60.0),
            smooth,
        ),
        limited(
            case(C::MinJerk, M::MAX_JERK, (100.0, 0.0), -1.0, -60.0),
            smooth,
        ),
    ]
}

impl Case {
    fn refusal(&self, details: SyncMask) -> Violation {
        let mut start = moment((1_000.0, self.master), (0.0, self.slave));
        start.axis.min_position = Some(-1.0);
        start.axis.max_position = Some(1.0);
        // A second ahead of the master.
        let sync = (1_000.0 + self.master, self.distance);
        let mode = SyncMode::position_based(self.mask | details);
        let refusal = to_position(self.gear, sync, mode, self.limits)
            .plan(&start)
            .expect_err("violates its check");
        *refusal.violation().expect("a violation")
    }
}

#[test]
fn every_error_code_of_tf5055_8_1_is_produced() {
    let cases = cases();
    let tested: std::vec::Vec<_> = cases.iter().map(|case| case.check).collect();
    assert_eq!(tested, Check::ALL);
    for case in &cases {
        let violation = case.refusal(SyncMask::DETAILED_ERROR_CODES);
        assert_eq!(violation.check, case.check);
        assert_eq!(violation.code(), case.check.code());
        assert!(violation.excess() > 0.0);
        let ahead = (violation.master_position - 1_000.0) / case.master;
        assert!((0.0..=1.0).contains(&ahead), "{violation:?}");
        assert_eq!(case.refusal(SyncMask::empty()).code(), 0x42df);
    }
    let codes = cases.map(|case| case.check.code());
    assert!(codes.into_iter().eq(0x4372..=0x438b));
}
