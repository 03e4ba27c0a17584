//! Plants of several nodes: routes, hold-backs, proposals and contradictions.

use coaxle_axis::Modulo;
use coaxle_clock::{CycleTime, Span};
use coaxle_node::Channel;
use coaxle_node::circles::AxisAddress;
use coaxle_node::config::{PresentAfterRange, Unit};
use coaxle_node::keys::NodeName;
use coaxle_topology::*;
use proptest::prelude::*;

fn node(name: &str, role: PlantRole, axes: Vec<PlantAxis>) -> PlantNode {
    PlantNode {
        file: format!("{name}.toml"),
        name: NodeName::new(name).expect("a name"),
        role,
        cycle_time: Some(CycleTime::new(Span::from_millis(1)).expect("a cycle time")),
        axes,
        is_complete: true,
        hold_back: None,
    }
}

fn axis(name: &str, published: Option<(Channel, u32)>, origin: AxisOrigin) -> PlantAxis {
    PlantAxis {
        name: name.to_owned(),
        field: format!("field-of-{name}"),
        published,
        unit: None,
        modulo: None,
        limits: None,
        origin,
    }
}

fn root(present_after_ms: i64) -> AxisOrigin {
    AxisOrigin::Root {
        motion: RootMotion::Program,
        present_after: (present_after_ms > 0)
            .then(|| PresentAfterRange::only(Span::from_millis(present_after_ms))),
        followers: Vec::new(),
    }
}

/// A sender with the axis 1.
fn line(present_after_ms: i64) -> PlantNode {
    let axes = vec![axis(
        "conveyor",
        Some((Channel::Axes, 1)),
        root(present_after_ms),
    )];
    node("line", PlantRole::Sender, axes)
}

fn far(source: &str, delay_ms: Option<i64>, showing: Showing) -> FarReference {
    FarReference {
        field: "far[0]".to_owned(),
        sources: vec![AxisAddress::read(source).expect("an address")],
        way: match delay_ms {
            None => WaySource::Unknown,
            Some(delay) => WaySource::Constant {
                delay: Span::from_millis(delay),
                origin: WayOrigin::Configured,
            },
        },
        showing,
        measured: None,
    }
}

/// A receiver with a far axis and a slave of it.
fn follower(name: &str, source: &str, delay_ms: Option<i64>, lag: LagRule) -> PlantNode {
    let far = far(source, delay_ms, Showing::Later(lag));
    let axes = vec![
        axis("far", None, AxisOrigin::Far(far)),
        axis(
            "roll",
            Some((Channel::Slaves, 1)),
            AxisOrigin::Slave { masters: vec![0] },
        ),
    ];
    node(name, PlantRole::Receiver, axes)
}

fn fixed(ms: i64) -> LagRule {
    LagRule::Fixed(Span::from_millis(ms))
}

fn texts(plant: &PlantAnalysis) -> Vec<String> {
    plant.findings.iter().map(ToString::to_string).collect()
}

#[test]
fn a_chain_adds_up_to_the_delay_of_its_root() {
    let lags = |plant: &PlantAnalysis| -> Vec<_> {
        let last = plant.routes.last().unwrap();
        let stages = last.stages.iter();
        stages
            .map(|stage| (stage.present_after_ms, stage.lag_ms, stage.shown))
            .collect()
    };
    let plant = PlantAnalysis::of(&[
        line(200),
        follower("first", "line/axes/1", Some(20), fixed(60)),
        follower("second", "first/slaves/1", Some(20), fixed(60)),
        follower("third", "second/slaves/1", Some(20), LagRule::Full),
    ]);
    assert_eq!(plant.findings, []);
    assert_eq!(plant.notes, []);
    let good = ShownAs::Interpolated;
    let expected = [
        (Some(200.0), Some(60.0), good),
        (Some(140.0), Some(60.0), good),
        (Some(80.0), Some(80.0), good),
    ];
    assert_eq!(lags(&plant), expected);
    let route = plant.routes.last().unwrap();
    assert_eq!(
        route.way,
        [
            "line/conveyor",
            "first/far",
            "first/roll",
            "second/far",
            "second/roll",
            "third/far",
            "third/roll"
        ]
    );
    assert_eq!((route.delay_ms, route.lag_ms), (Some(60.0), Some(200.0)));
    // Each drive shows the instant of the root 200 ms ago: lags and hold-back.
    for route in &plant.routes {
        let all = route.lag_ms.unwrap() + route.hold_back_ms.unwrap();
        assert_eq!(all, 200.0, "{}", route.end);
    }
    // 60 and 60 are stated; the last way needs 23 ms, a quarter and a cycle: 29.75.
    assert_eq!(plant.proposals[0].present_after_ms, Some(150.0));
}

#[test]
fn a_delay_that_is_too_short_is_a_note_and_extrapolated() {
    let plant = PlantAnalysis::of(&[
        line(20),
        follower("first", "line/axes/1", Some(20), LagRule::Auto),
    ]);
    assert_eq!(plant.routes[0].shown, ShownAs::Extrapolated);
    let notes: Vec<_> = plant.notes.iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "line.toml: field-of-conveyor.present-after-ms: received 20, expected at least 30, for the longest chain of followers"
        ]
    );
    let now = PlantAnalysis::of(&[
        line(0),
        follower("first", "line/axes/1", Some(20), LagRule::Auto),
    ]);
    assert_eq!(now.routes[0].shown, ShownAs::Now);
    assert_eq!(now.proposals[0].present_after_ms, Some(30.0));
    assert_eq!(now.notes, []);
}

#[test]
fn a_node_that_waits_for_all_of_it_leaves_nothing_to_its_followers() {
    let plant = PlantAnalysis::of(&[
        line(200),
        follower("first", "line/axes/1", Some(20), LagRule::Full),
        follower("second", "first/slaves/1", Some(20), LagRule::Full),
    ]);
    assert_eq!(plant.routes[0].shown, ShownAs::Interpolated);
    assert_eq!(plant.routes[1].shown, ShownAs::Now);
    let note = plant.notes[0].to_string();
    assert!(
        note.starts_with("first.toml: far[0].lag-ms: received \"full\", expected \"auto\""),
        "{note}"
    );
    // 29.75 ms for each, of the first in whole cycles.
    assert_eq!(plant.proposals[0].present_after_ms, Some(60.0));
}

#[test]
fn an_unknown_way_makes_the_sum_unknown_and_no_proposal() {
    let plant = PlantAnalysis::of(&[
        line(50),
        follower("first", "line/axes/1", Some(5), fixed(20)),
        follower("second", "first/slaves/1", None, LagRule::Full),
    ]);
    let route = plant.routes.last().unwrap();
    assert_eq!((route.delay_ms, route.needed_ms), (None, None));
    assert_eq!(route.lag_ms, Some(50.0));
    assert_eq!(route.shown, ShownAs::Unknown);
    assert_eq!(plant.proposals[0].present_after_ms, None);
    assert_eq!(plant.proposals[0].reason, Some("a way has no known delay"));
}

#[test]
fn one_master_that_is_shown_now_leaves_nothing() {
    // The node has one hold-back: an encoder beside the conveyor is shown now, so nothing is held back.
    let mut first = follower("first", "line/axes/1", Some(5), LagRule::Auto);
    let now = far("wheel/axes/1", Some(5), Showing::Now);
    first.axes.push(axis("wheel", None, AxisOrigin::Far(now)));
    first.axes.push(axis(
        "knife",
        Some((Channel::Slaves, 2)),
        AxisOrigin::Slave { masters: vec![2] },
    ));
    let mut wheel = line(0);
    wheel.name = NodeName::new("wheel").unwrap();
    wheel.axes[0].origin = AxisOrigin::Root {
        motion: RootMotion::Encoder,
        present_after: None,
        followers: Vec::new(),
    };
    let plant = PlantAnalysis::of(&[
        line(100),
        wheel,
        first,
        follower("second", "first/slaves/1", Some(5), LagRule::Full),
    ]);
    assert_eq!(plant.nodes[2].hold_back_ms, Some(0.0));
    let proposal = &plant.proposals[0];
    assert_eq!(
        (proposal.node.as_str(), proposal.present_after_ms),
        ("line", None)
    );
    assert!(
        proposal.reason.unwrap().contains("shown at once"),
        "{proposal:?}"
    );
    assert_eq!(plant.proposals.len(), 1);
}

#[test]
fn nodes_that_follow_each_other_s_slaves_have_no_delay() {
    // No circle of axes: the slave 2 of each follows the slave 1 of the other, which follows the line.
    let both = |name: &str, other: &str| {
        let mut node = follower(name, "line/axes/1", Some(5), LagRule::Auto);
        let across = far(
            &format!("{other}/slaves/1"),
            Some(5),
            Showing::Later(LagRule::Auto),
        );
        node.axes
            .push(axis("across", None, AxisOrigin::Far(across)));
        node.axes.push(axis(
            "second",
            Some((Channel::Slaves, 2)),
            AxisOrigin::Slave { masters: vec![2] },
        ));
        node
    };
    let plant = PlantAnalysis::of(&[line(100), both("a", "b"), both("b", "a")]);
    assert_eq!(plant.findings, []);
    let reason = plant.proposals[0].reason.unwrap();
    assert!(reason.contains("each other"), "{reason}");
}

#[test]
fn circles_are_named_with_the_field_that_closes_them() {
    let plant = PlantAnalysis::of(&[
        follower("a", "b/slaves/1", None, LagRule::Full),
        follower("b", "a/slaves/1", None, LagRule::Full),
        follower("behind", "a/slaves/1", None, LagRule::Full),
    ]);
    assert_eq!(
        texts(&plant),
        [
            "a.toml: far[0].node: received a circle (0x816f): a/slaves/1 follows b/slaves/1 follows a/slaves/1, \
          expected a sender's axis or a virtual axis at the root"
        ]
    );
    assert_eq!(plant.routes, []);
}

#[test]
fn axes_that_nobody_publishes_are_named() {
    let plant = PlantAnalysis::of(&[
        line(0),
        follower("a", "lin/axes/1", None, LagRule::Full),
        follower("b", "line/axes/7", None, LagRule::Full),
        follower("c", "line/slaves/1", None, LagRule::Full),
        follower("d", "b/far-axes/1", None, LagRule::Full),
    ]);
    assert_eq!(
        texts(&plant),
        [
            "a.toml: far[0].node: received \"lin\", expected a node of these configs; did you mean \"line\"?",
            "b.toml: far[0].axes: received the id 7, expected one of line/axes in line.toml: 1",
            "c.toml: far[0].channel: received \"slaves\" of line, which publishes nothing there, expected one of: \"axes\"",
            "d.toml: far[0].channel: received \"far-axes\" of b, which publishes nothing there, expected \
             publish-far-axes in b.toml, or one of: \"slaves\"",
        ]
    );
}

#[test]
fn followers_that_do_not_follow_are_named() {
    let mut line = line(0);
    let named = ["a", "b", "bee", "line"].map(|name| NodeName::new(name).expect("a name"));
    if let AxisOrigin::Root { followers, .. } = &mut line.axes[0].origin {
        followers.extend(named);
    }
    let mut without = follower("b", "line/axes/1", None, LagRule::Full);
    without
        .axes
        .retain(|axis| !matches!(axis.origin, AxisOrigin::Slave { .. }));
    let plant = PlantAnalysis::of(&[
        line,
        follower("a", "line/axes/1", None, LagRule::Full),
        without,
    ]);
    let nobody = |k, received| {
        format!(
            "line.toml: field-of-conveyor.followers.nodes[{k}]: received {received}, which has no slave of conveyor, \
             expected a receiver with a slave of the axis"
        )
    };
    assert_eq!(
        texts(&plant),
        [
            nobody(1, "\"b\""),
            "line.toml: field-of-conveyor.followers.nodes[2]: received \"bee\", expected a node of these configs"
                .to_owned(),
            nobody(3, "\"line\""),
        ]
    );
}

#[test]
fn a_running_node_that_shows_some_of_its_axes_may_have_others() {
    let mut partly = line(0);
    partly.is_complete = false;
    let plant = PlantAnalysis::of(&[partly, follower("b", "line/axes/7", None, LagRule::Full)]);
    assert_eq!(plant.findings, []);
}

#[test]
fn names_units_turns_and_cycle_times_that_contradict_are_named() {
    let mut publisher = line(0);
    publisher.axes[0].unit = Some(Unit::new("mm").unwrap());
    publisher.axes[0].modulo = Some(Modulo::new(600.0).unwrap());
    let mut other = follower("a", "line/axes/1", None, LagRule::Full);
    other.axes[0].unit = Some(Unit::new("inch").unwrap());
    other.axes[0].modulo = Some(Modulo::new(360.0).unwrap());
    other.cycle_time = Some(CycleTime::new(Span::from_micros(1_500)).unwrap());
    let twice = follower("line", "line/axes/1", None, LagRule::Full);
    assert_eq!(
        texts(&PlantAnalysis::of(&[publisher.clone(), other, twice])),
        [
            "line.toml: name: received \"line\", which is the name in line.toml too, expected a name of its own: \
             both publish under the same keys",
            "a.toml: field-of-far.unit: received \"inch\" for far, expected \"mm\", as line.toml: field-of-conveyor (conveyor)",
            "a.toml: field-of-far.modulo: received 360 for far, expected 600, as line.toml: field-of-conveyor (conveyor)",
            "a.toml: cycle-time-us: received 1500, expected a whole multiple or a whole part (up to 1000) of 1000, \
             the cycle time in line.toml, which far[0] follows",
        ]
    );
    // A unit passes through followers that state none, and a period does not pass through a gear.
    let mut last = follower("last", "a/slaves/1", None, LagRule::Full);
    last.axes[0].unit = Some(Unit::new("inch").unwrap());
    last.axes[0].modulo = Some(Modulo::new(1.0).unwrap());
    let silent = follower("a", "line/axes/1", None, LagRule::Full);
    assert_eq!(
        texts(&PlantAnalysis::of(&[publisher, silent, last])),
        [
            "last.toml: field-of-far.unit: received \"inch\" for far, expected \"mm\", as a.toml: field-of-roll (roll)"
        ]
    );
}

#[test]
fn standbys_are_checked_and_the_first_choice_is_the_route() {
    let mut saw = follower("saw", "line/axes/1", Some(1), LagRule::Full);
    let AxisOrigin::Far(far) = &mut saw.axes[0].origin else {
        unreachable!("the first axis is far");
    };
    far.sources.push(AxisAddress::read("spare/axes/1").unwrap());
    let alone = PlantAnalysis::of(&[line(0), saw.clone()]);
    assert_eq!(
        texts(&alone),
        ["saw.toml: far[0].standby: received \"spare\", expected a node of these configs"]
    );
    let mut spare = line(0);
    spare.name = NodeName::new("spare").unwrap();
    let both = PlantAnalysis::of(&[line(0), spare, saw]);
    assert_eq!(both.findings, []);
    assert_eq!(both.routes.len(), 1);
    assert_eq!(
        both.nodes[2].axes[0].follows,
        ["line/axes/1", "spare/axes/1"]
    );
}

#[test]
fn a_graph_of_thousands_of_axes_is_a_matter_of_moments() {
    // A chain of 128 nodes, and 128 slaves of the last.
    let mut nodes = vec![line(0)];
    let mut source = "line/axes/1".to_owned();
    for n in 0..127 {
        let name = format!("n{n}");
        nodes.push(follower(&name, &source, Some(1), LagRule::Auto));
        source = format!("{name}/slaves/1");
    }
    let last = nodes.last_mut().unwrap();
    for k in 2..=128 {
        let origin = AxisOrigin::Slave { masters: vec![0] };
        last.axes
            .push(axis(&format!("s{k}"), Some((Channel::Slaves, k)), origin));
    }
    let plant = PlantAnalysis::of(&nodes);
    assert_eq!(plant.routes.len(), 127 + 127);
    // 1 ms, two cycles of the node before and one of its own, a quarter and a cycle.
    assert_eq!(plant.proposals[0].present_after_ms, Some(127.0 * 6.0));
}

/// A plant as a tree of receivers: each follows the line or a receiver before it.
fn trees() -> impl Strategy<Value = Vec<(usize, i64, i64, bool)>> {
    let receiver = (0_usize..100, 0_i64..40_000, 1_i64..8, any::<bool>());
    proptest::collection::vec(receiver, 1..12)
}

proptest! {
    /// With the proposed delay, and `auto` where others follow, every axis of every route is interpolated.
    #[test]
    fn the_proposal_does(tree in trees(), cycle in 1_i64..5) {
        let build = |present_after: i64| {
            let cycle_of = |millis| Some(CycleTime::new(Span::from_millis(millis)).unwrap());
            let mut nodes = vec![line(present_after)];
            nodes[0].cycle_time = cycle_of(cycle);
            for (n, (source, delay_us, factor, _)) in tree.iter().enumerate() {
                let source = match source % (n + 1) {
                    0 => "line/axes/1".to_owned(),
                    before => format!("n{}/slaves/1", before - 1),
                };
                let mut node = follower(&format!("n{n}"), &source, None, LagRule::Auto);
                let AxisOrigin::Far(far) = &mut node.axes[0].origin else { unreachable!() };
                far.way = WaySource::Constant {
                    delay: Span::from_micros(*delay_us),
                    origin: WayOrigin::Configured,
                };
                node.cycle_time = cycle_of(cycle * factor);
                nodes.push(node);
            }
            PlantAnalysis::of(&nodes)
        };
        let proposal = build(0).proposals[0].clone();
        let delay = proposal.present_after_ms.expect("known delays");
        // Written in whole milliseconds here: the next one up.
        let with = build(delay.ceil() as i64);
        for route in &with.routes {
            prop_assert_eq!(route.shown, ShownAs::Interpolated, "{:?}", route);
            let all = route.lag_ms.unwrap() + route.hold_back_ms.unwrap();
            prop_assert!((all - delay.ceil()).abs() < 1e-6, "{:?}", route);
        }
        prop_assert_eq!(with.notes.len(), 0);
        // And two thirds of it do not: the margins are a quarter and a few cycles.
        if delay > 100.0 {
            let short = build((delay * 0.6) as i64);
            prop_assert!(short.routes.iter().any(|route| route.shown != ShownAs::Interpolated));
        }
    }
}

/// Time asked for by a way of 20 ms: two cycles of the sender and one of the receiver, a quarter and a cycle.
const ASKED: f64 = 29.75;

#[test]
fn a_delay_that_followers_decide_is_what_those_who_report_ask_for() {
    let led = |least, most, nodes: &[&str]| {
        let mut line = line(0);
        line.axes[0].origin = AxisOrigin::Root {
            motion: RootMotion::Program,
            present_after: Some(PresentAfterRange {
                least: Span::from_millis(least),
                most: Span::from_millis(most),
            }),
            followers: nodes
                .iter()
                .map(|it| NodeName::new(*it).expect("a name"))
                .collect(),
        };
        let near = follower("near", "line/axes/1", Some(5), LagRule::Full);
        let far = follower("far", "line/axes/1", Some(20), LagRule::Full);
        let plant = PlantAnalysis::of(&[line, near, far]);
        assert_eq!(plant.findings, []);
        let shown: Vec<_> = plant.routes.iter().map(|route| route.shown).collect();
        (plant.routes[0].present_after_ms, shown, plant.notes.len())
    };
    let good = ShownAs::Interpolated;
    let all = ["near", "far"];
    assert_eq!(led(1, 200, &all), (ASKED, vec![good; 2], 0));
    assert_eq!(led(40, 200, &all), (40.0, vec![good; 2], 0));
    // Too little for the second: by the limit, and as nobody asks it. Each is noted.
    let too_late = vec![good, ShownAs::Extrapolated];
    assert_eq!(led(1, 12, &all), (12.0, too_late.clone(), 1));
    assert_eq!(led(1, 200, &["near"]), (11.0, too_late, 1));
}
