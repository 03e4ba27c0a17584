use super::*;

fn name(name: &str) -> NodeName {
    NodeName::new(name).unwrap()
}

/// A node in a simulation of statuses: its slave 1 follows slave 1 of the next node.
struct Node {
    name: String,
    follows: String,
    is_coupled: bool,
    watch: CircleWatch,
    status: Map<String, Value>,
    finding: CircleFinding,
}

impl Node {
    fn new(of: &str, next: &str) -> Self {
        let follows = format!("{next}/slaves/1");
        Self {
            name: of.to_owned(),
            follows,
            is_coupled: false,
            watch: CircleWatch::new(name(of), [name(next)]),
            status: Map::new(),
            finding: CircleFinding::default(),
        }
    }

    fn report(&mut self) {
        let phase = self.is_coupled.then_some("in-sync");
        // A phase is what makes a slave coupled.
        let mut status = json!({
            "slaves": { "loop": { "id": 1, "follows": [self.follows], "phase": phase } }
        });
        self.finding = self.watch.look(status.as_object().unwrap());
        status["circles"] = self.finding.to_json();
        self.status = status.as_object().unwrap().clone();
    }

    fn state(&self) -> CircleState {
        self.finding.states[0].state
    }
}

/// A ring of this number of nodes.
fn ring(nodes: usize) -> Vec<Node> {
    let of = |n: usize| format!("n{}", n % nodes);
    (0..nodes).map(|n| Node::new(&of(n), &of(n + 1))).collect()
}

/// Publishes the statuses of all nodes this number of times: each reads only the next node's.
fn statuses(nodes: &mut [Node], times: usize) {
    for _ in 0..times {
        nodes.iter_mut().for_each(Node::report);
        let said: Vec<_> = nodes
            .iter()
            .map(|node| (name(&node.name), node.status.clone()))
            .collect();
        // All at once, so that each turn passes a status one node on.
        for node in &mut *nodes {
            said.iter()
                .for_each(|(of, status)| node.watch.take(of, status));
        }
    }
    nodes.iter_mut().for_each(Node::report);
}

#[test]
fn a_circle_is_found_over_any_number_of_nodes_after_as_many_statuses() {
    for count in [2, 3, 10] {
        let mut nodes = ring(count);
        statuses(&mut nodes, 0);
        assert_eq!(nodes[0].state(), CircleState::None);
        assert_eq!(nodes[0].finding.unknown, [name("n1")]);
        statuses(&mut nodes, count - 1);
        for node in &nodes {
            assert_eq!(node.state(), CircleState::Open, "{count}: {}", node.name);
            let texts: Vec<_> = node.finding.circles.iter().map(Circle::to_string).collect();
            assert_eq!(texts.len(), 1);
            assert_eq!(texts[0].matches(" follows ").count(), count);
            assert_eq!(node.finding.unknown, []);
        }
    }
    let mut two = ring(2);
    statuses(&mut two, 1);
    let text = "n0/slaves/1 follows n1/slaves/1 follows n0/slaves/1";
    assert_eq!(two[0].finding.circles[0].to_string(), text);
}

#[test]
fn a_circle_is_closed_when_each_of_its_axes_is_coupled() {
    let mut nodes = ring(3);
    nodes[0].is_coupled = true;
    nodes[1].is_coupled = true;
    // Two of three: one axis that is free leaves the circle open.
    statuses(&mut nodes, 3);
    assert!(nodes.iter().all(|node| node.state() == CircleState::Open));
    nodes[2].is_coupled = true;
    statuses(&mut nodes, 3);
    assert!(nodes.iter().all(|node| node.state() == CircleState::Closed));
    nodes[1].is_coupled = false;
    statuses(&mut nodes, 3);
    assert!(nodes.iter().all(|node| node.state() == CircleState::Open));
}

#[test]
fn what_follows_a_circle_is_not_in_it() {
    let mut nodes = ring(2);
    nodes.push(Node::new("tail", "n0"));
    statuses(&mut nodes, 4);
    assert_eq!(nodes[2].state(), CircleState::None);
    assert_eq!(nodes[2].finding.circles, []);
}

#[test]
fn what_is_known_of_an_axis_that_left_does_not_go_round_for_ever() {
    let mut nodes = ring(3);
    // Another master of the last node, whose own master is the first node's axis.
    nodes[2].follows = "gone/slaves/1".to_owned();
    nodes[2].watch = CircleWatch::new(name("n2"), [name("gone"), name("n0")]);
    let gone = json!({ "slaves": { "x": { "id": 1, "follows": ["n0/slaves/1"], "phase": null } } });
    nodes[2]
        .watch
        .take(&name("gone"), gone.as_object().unwrap());
    statuses(&mut nodes, 3);
    assert_eq!(nodes[0].state(), CircleState::Open);
    nodes[2].watch.forget(&name("gone"));
    // Twice as often as the most hops, so that the last entry has gone wherever it could.
    statuses(&mut nodes, 2 * MOST_HOPS as usize);
    assert_eq!(nodes[0].state(), CircleState::None);
    assert_eq!(nodes[2].finding.unknown, [name("gone")]);
    assert_eq!(nodes[0].finding.unknown, [name("gone")]);
}

#[test]
fn axes_of_senders_are_neither_known_nor_missed() {
    let watch = CircleWatch::new(name("a"), []);
    let status =
        json!({ "slaves": { "x": { "id": 1, "follows": ["line/axes/3"], "phase": "in-sync" } } });
    let finding = watch.look(status.as_object().unwrap());
    assert_eq!(finding.unknown, []);
    assert_eq!(finding.states[0].state, CircleState::None);
}

#[test]
fn a_status_that_is_none_is_nobodys_axes() {
    let mut watch = CircleWatch::new(name("a"), [name("b")]);
    for status in [
        json!({}),
        json!({ "slaves": 1, "axes": [], "circles": 3 }),
        // An id beyond 32 bits, a negative one, and masters that are no addresses.
        json!({ "slaves": { "x": 1, "y": { "id": -1 }, "z": { "id": 5e12, "follows": [1, ""] } } }),
        json!({ "circles": { "upstream": [1, {}, { "axis": "b/slaves/1", "coupled": 1 }] } }),
    ] {
        watch.take(&name("b"), status.as_object().unwrap());
        let own = json!({ "slaves": { "x": { "id": 1, "follows": ["b/slaves/1"] } } });
        let finding = watch.look(own.as_object().unwrap());
        assert_eq!((finding.circles.len(), finding.unknown.len()), (0, 0));
    }
}
