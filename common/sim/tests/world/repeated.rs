//! Same seed, same run.

use coaxle_node::Channel;
use coaxle_sim::World;

use crate::toy::{BELT, Memory, SAW, link, run, seeded};

/// Messages received by the saw, as text.
fn received(belt_seed: u64, link_seed: u64) -> String {
    let clock = "random-walk-ppm = 5\njitter = { normal-us = 10 }";
    let mut world = World::new();
    world
        .add_node(seeded("belt", belt_seed, clock, &[Channel::Axes]))
        .expect("no files");
    world
        .add_node(seeded("saw", 2, clock, &[]))
        .expect("no files");
    let mut link = link(
        BELT,
        SAW,
        &["jitter = { exponential-us = 50 }\nloss = 0.1\nduplication = 0.1"],
    );
    link.behaviour[0].1 = link_seed;
    world.add_link(link).expect("no files");
    run(&mut world, 300_000, &mut Memory::default());
    format!("{:?}", world.node(SAW).expect("it lives").received)
}

#[test]
fn the_same_seeds_give_the_same_run_and_each_other_seed_another() {
    assert_eq!(received(1, 3), received(1, 3));
    // Seeds of the node and of the link, each by itself.
    assert_ne!(received(1, 3), received(4, 3));
    assert_ne!(received(1, 3), received(1, 4));
}
