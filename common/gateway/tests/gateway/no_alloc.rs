//! The cycle of a gateway does not allocate.

use assert_no_alloc::assert_no_alloc;
use coaxle_clock::{CycleIndex, Instant, Local, Span};
use coaxle_gateway::config::GatewayConfig;
use coaxle_gateway::{Gateway, LinkState, PlcOutput, PlcSample, Port};
use coaxle_node::config::parse;
use coaxle_node::{Message, Node, TimeRequest};

/// A PLC with a new cycle every other time.
struct Wires {
    sample: PlcSample,
    calls: u32,
    outputs: usize,
}

impl Port for Wires {
    fn receive(&mut self, now: Instant<Local>, sample: &mut PlcSample) -> bool {
        self.calls += 1;
        // A cycle asks until there is nothing: three calls in two cycles, and a sample in every other one.
        if !self.calls.is_multiple_of(3) {
            return false;
        }
        self.sample.index = CycleIndex(self.sample.index.0.wrapping_add(1));
        self.sample.at = now;
        sample.replace(&self.sample);
        true
    }

    fn send(&mut self, output: &PlcOutput<'_>) {
        self.outputs += output.axes.len();
    }

    fn state(&self) -> LinkState {
        LinkState::default()
    }
}

#[test]
fn cycles_do_not_allocate() {
    let text = "name = 'plc'\ncycle-time-us = 1000\n[pipe]\n[[axis]]\nid = 1\nname = 'a'\n\
                [[axis]]\nid = 2\nname = 'b'\n[[output]]\nnode = 'saw'\n[[output.axis]]\nid = 1\n";
    let config: GatewayConfig = parse("g", text).unwrap();
    let wires = Wires {
        sample: PlcSample::of_axes(2),
        calls: 0,
        outputs: 0,
    };
    let mut gateway = Gateway::new(&config, wires, Instant::EPOCH, 1);
    let mut snapshot = gateway.snapshot().clone();
    let mut sent = 0;
    assert_no_alloc(|| {
        for k in 0..6_000 {
            // Half of the cycle time, as the gateway runs.
            let now = Instant::EPOCH + Span::from_micros(500 * k);
            let request = Message::TimeRequest(TimeRequest::default());
            gateway.receive(now - Span::from_micros(100), 0, &request);
            let _ = gateway.cycle(now);
            while let Some(outgoing) = gateway.transmit() {
                sent += outgoing.body.len();
            }
            snapshot.clone_from(gateway.snapshot());
        }
    });
    #[cfg(not(debug_assertions))]
    assert_eq!(assert_no_alloc::violation_count(), 0);
    assert!(sent > 100_000, "{sent}");
}
