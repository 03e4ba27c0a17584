use super::*;
use crate::network::transport::{InProcess, Urgency};
use coaxle_node::Intake;
use coaxle_node::config::{LinkConfig, parse};

fn name(name: &str) -> NodeName {
    NodeName::new(name).unwrap()
}

fn following(node: &str, channel: Channel) -> Subscription {
    let node = name(node);
    Subscription {
        reader: Intake::new(&node.channel_key(channel), &node, &[1]).into(),
        node,
        channel,
        far: 0,
        faults: parse::<LinkConfig>("test", "").unwrap(),
    }
}

struct Bench {
    network: InProcess,
    search: CircleSearch,
    changes: Consumer<CircleChange>,
    names: CircleNames,
}

fn bench(channel: Channel) -> Bench {
    let network = InProcess::dated_by(|| Instant::EPOCH);
    let names = CircleNames::default();
    let heard = [following("b", channel)];
    let opened = CircleSearch::open(&name("a"), &heard, names.clone(), &network);
    let (search, changes) = opened.unwrap();
    Bench {
        network,
        search,
        changes,
        names,
    }
}

impl Bench {
    fn other_says(&self, phase: &str) {
        let text = format!(
            r#"{{ "slaves": {{ "loop": {{ "id": 1, "follows": ["a/slaves/1"], "phase": {phase} }} }} }}"#
        );
        let publisher = self.network.publisher("coaxle/b/status", Urgency::Ordinary);
        publisher.unwrap().publish(text.into()).unwrap();
    }

    fn look(&mut self, millis: i64, phase: &str) -> Map<String, Value> {
        let text = format!(
            r#"{{ "slaves": {{ "loop": {{ "id": 1, "follows": ["b/slaves/1"], "phase": {phase} }} }} }}"#
        );
        let mut status = serde_json::from_str(&text).unwrap();
        let now = Instant::EPOCH + Span::from_millis(millis);
        self.search.look(now, &mut status, |_| true);
        status
    }

    fn given(&mut self) -> Vec<CircleState> {
        let given = std::iter::from_fn(|| self.changes.pop().ok());
        given.map(|change| change.state).collect()
    }
}

const CIRCLE: &str = "a/slaves/1 follows b/slaves/1 follows a/slaves/1";

#[test]
fn what_is_found_goes_to_the_cycle_once_and_into_the_status() {
    let mut bench = bench(Channel::Slaves);
    let status = bench.look(0, "null");
    assert_eq!(status["circles"]["unknown"], json!(["b"]));
    assert_eq!(status["slaves"]["loop"]["circle"], Value::Null);
    assert_eq!(bench.given(), []);

    bench.other_says("null");
    let status = bench.look(250, "null");
    assert_eq!(status["circles"]["found"], json!([CIRCLE]));
    assert_eq!(status["circles"]["unknown"], json!([]));
    assert_eq!(status["slaves"]["loop"]["circle"], CIRCLE);
    assert_eq!(bench.names.of("loop").as_deref(), Some(CIRCLE));
    assert_eq!(bench.given(), [CircleState::Open]);
    let _ = bench.look(500, "null");
    assert_eq!(bench.given(), []);

    bench.other_says("\"in-sync\"");
    let _ = bench.look(750, "\"in-sync\"");
    assert_eq!(bench.given(), [CircleState::Closed]);
}

#[test]
fn a_node_that_is_silent_is_not_known_any_more() {
    let mut bench = bench(Channel::FarAxes);
    bench.other_says("null");
    let _ = bench.look(0, "null");
    assert_eq!(bench.given(), [CircleState::Open]);
    // Exactly 5 s are no silence, a millisecond more is.
    let _ = bench.look(5_000, "null");
    assert_eq!(bench.given(), []);
    let status = bench.look(5_001, "null");
    assert_eq!(bench.given(), [CircleState::None]);
    assert_eq!(status["circles"]["unknown"], json!(["b"]));
    assert_eq!(bench.names.of("loop"), None);
}

#[test]
fn a_follower_of_senders_hears_no_status_and_says_nothing_of_circles() {
    let mut bench = bench(Channel::Axes);
    bench.other_says("null");
    let status = bench.look(0, "null");
    assert!(!status.contains_key("circles"));
    assert_eq!(bench.given(), []);
}

#[test]
fn a_full_ring_delays_what_the_cycle_is_given() {
    let mut bench = bench(Channel::Slaves);
    let change = CircleChange {
        channel: Channel::Slaves,
        id: 9,
        state: CircleState::None,
    };
    // Filled to the last place by axes that no circle has.
    while bench.search.to_cycle.push(change).is_ok() {}
    bench.other_says("null");
    let _ = bench.look(0, "null");
    assert_eq!(bench.given().len(), CHANGES);
    let _ = bench.look(250, "null");
    assert_eq!(bench.given(), [CircleState::Open]);
}
