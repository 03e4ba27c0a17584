//! The slave: geared to the master, published, and followed by others.

use std::slice::from_mut;

use crate::bench::{Far, MILLISECOND, Near, SECOND, VELOCITY, ripple, run, run_pair};
use coaxle_axis::{CoupleState, StateWord};
use coaxle_node::frame::{decode, sender_id};
use coaxle_node::keys::NodeName;
use coaxle_receiver::Health;

#[test]
fn the_slave_is_geared_to_the_corrected_master() {
    let mut far = Far::new(1000, 1000, 0, 1);
    let mut near = Near::new(
        1000,
        0,
        "slave = [{ gear = { ratio = -2.0, offset = 10.0 } }]",
    );
    run_pair(&mut far, &mut near, 3 * SECOND);
    let coupled = near
        .snapshots
        .iter()
        .filter_map(|s| Some((s.master?, s.slave()?)));
    let mut cycles = 0;
    for (master, slave) in coupled {
        let expected = -2.0 * master.corrected.position + 10.0;
        assert!((slave.position - expected).abs() <= 1e-9 * expected.abs());
        assert_eq!(slave.velocity, -2.0 * master.corrected.velocity);
        cycles += 1;
    }
    // 3 s at 1 kHz, less the cycles before the first message.
    assert!(cycles > 2_990);
    let drive = near.last().drive();
    assert!(
        (drive.velocity / (-2.0 * VELOCITY) - 1.0).abs() < 0.01,
        "{drive:?}"
    );
}

#[test]
fn a_slave_is_published_only_once_it_is_coupled() {
    let mut near = Near::new(1000, 0, "slave = [{ id = 4, gear.ratio = 0.5 }]");
    run(None, from_mut(&mut near), 100 * MILLISECOND);
    assert_eq!(near.slave_frame, None);
    let mut far = Far::new(1000, 1000, 100 * MILLISECOND, 1);
    run_pair(&mut far, &mut near, SECOND);

    let frame = near.slave_frame.as_ref().expect("a frame");
    let mut axes = Vec::new();
    let header = decode("coaxle/saw/slaves", frame, |axis| axes.push(*axis)).unwrap();
    assert_eq!(header.sender, sender_id(&NodeName::new("saw").unwrap()));
    assert_eq!((header.epoch, header.count), (77, near.last().cycle));
    assert_eq!(header.cycle_time.span().as_micros_f64(), 1000.0);
    let [axis] = axes[..] else {
        panic!("{} axes", axes.len());
    };
    let slave = near.last().slave().unwrap();
    assert_eq!(axis.axis_id, 4);
    assert_eq!(axis.couple_state, CoupleState::Slave);
    assert_eq!(
        (axis.set_position, axis.set_velocity),
        (slave.position, slave.velocity)
    );
    assert_eq!(axis.actual_position, near.last().drive().position);
    assert!(
        axis.state_word
            .contains(StateWord::OPERATIONAL | StateWord::POSITIVE_DIRECTION)
    );
}

#[test]
fn a_slave_can_be_followed_like_any_axis() {
    let slopes =
        "mode = 'sync'\nsync.time-sync = { slope1-numerator = 0.5, slope1-denominator = 0.5 }";
    let mut far = Far::new(1000, 1000, 0, 1);
    let saw = Near::new(
        1000,
        0,
        &format!("slave = [{{ id = 4, gear.ratio = 0.5 }}]\n{slopes}"),
    );
    let stamp = Near::chained(2000, -700, slopes);
    let mut chain = [saw, stamp];
    run(Some(&mut far), &mut chain, 14 * SECOND);
    let [saw, stamp] = &chain;
    assert_eq!(
        (saw.last().health, stamp.last().health),
        (Health::Ok, Health::Ok)
    );
    let master = stamp.last().master.unwrap();
    assert!(master.synced);
    assert_eq!(master.epoch, 77, "the saw's");
    // To a clock 700 ppm slow, an exact one runs that much fast.
    let drift = master.drift_ppm / 700.0;
    assert!((drift - 1.0).abs() < 0.01, "{drift}");
    // In cycles of the stamp's clock, which runs slow, half of the conveyor's velocity.
    let velocity = 0.5 * VELOCITY * 1.001 / (1.0 - 700e-6);
    let rippled = ripple(stamp.newest(1_000), 2e-3, velocity);
    assert!(rippled < 0.01, "{rippled}");
}

/// Published error code and couple state of the slave. Checks that the error bit goes with the code.
fn published(near: &Near) -> (u32, CoupleState) {
    let frame = near.slave_frame.as_ref().expect("a frame");
    let mut axes = Vec::new();
    decode("coaxle/saw/slaves", frame, |axis| axes.push(*axis)).expect("axes");
    let [axis] = axes[..] else {
        panic!("{} axes", axes.len());
    };
    let is_in_error = axis.state_word.contains(StateWord::ERROR);
    assert_eq!(is_in_error, axis.error_code != 0);
    (axis.error_code, axis.couple_state)
}

#[test]
fn a_slave_that_follows_shows_the_error_that_its_master_was_received_with() {
    let mut far = Far::new(1000, 0, 0, 1);
    let slave = "slave = [{ id = 4, gear.ratio = 0.5, limits = { velocity = 1000, acceleration = \
                 5000, jerk = 1e6, on-master-loss = 'follow' } }]";
    let mut near = Near::new(1000, 0, slave);
    near.tweak = Some(Box::new(|sent, sample| {
        if (SECOND..2 * SECOND).contains(&sent) {
            sample.error_code = 0x4655;
        }
    }));
    for (until, expected) in [(900, 0), (1_500, 0x4655), (2_500, 0)] {
        run_pair(&mut far, &mut near, until * MILLISECOND);
        assert_eq!(published(&near), (expected, CoupleState::Slave), "{until}");
        // Only shown: the slave itself has no error, and the receiver is well.
        assert_eq!(near.last().slaves[0].error, None);
    }
}

#[test]
fn a_slave_that_starts_with_a_master_in_error_shows_it_from_its_first_cycle() {
    let mut far = Far::new(1000, 0, 0, 1);
    let slave = "slave = [{ id = 4, gear.ratio = 0.5, limits = { velocity = 1000, acceleration = \
                 5000, jerk = 1e6, on-master-loss = 'follow' } }]";
    let mut near = Near::new(1000, 0, slave);
    near.tweak = Some(Box::new(|_, sample| sample.error_code = 0x4655));
    while near.slave_frame.is_none() {
        let next = near.next();
        assert!(next < SECOND, "no frame");
        run_pair(&mut far, &mut near, next + 1);
    }
    assert_eq!(published(&near), (0x4655, CoupleState::Slave));
}
