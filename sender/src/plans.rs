//! Plans of the sender's axes: published on every new decision, and again before they end.

use coaxle_clock::cycle::Tick;
use coaxle_clock::{Instant, Local, Span};
use coaxle_node::plan::{MAX_PLANS, PLANS_CAPACITY, encode_plans};
use coaxle_node::{AxisPlan, Channel, Outgoing, RunCycle};
use coaxle_source::SourceAxis;
use coaxle_source::config::AxisConfig;

/// Longest time between two plans of an axis: after a lost one, or to a receiver that has only just started, the next one
/// comes this soon.
const PERIOD: Span = Span::from_millis(100);

/// Publisher of the plans.
#[derive(Debug)]
pub(crate) struct PlanPublisher {
    /// Run and node.
    header: RunCycle,
    /// Start of the node after the ideal start of its cycle 0, with which the instants of a run begin.
    origin: Span,
    /// Axes that plan, in the order in which they have a turn.
    axes: Box<[AxisInTurn]>,
    /// The next one.
    turn: usize,
    message: Vec<AxisPlan>,
    body: Box<[u8; PLANS_CAPACITY]>,
    /// Length of the pending body.
    waiting: Option<usize>,
    /// Number of plans published.
    pub(crate) published: u64,
}

/// An axis that plans.
#[derive(Debug)]
struct AxisInTurn {
    id: u32,
    /// Time between two plans without a new decision.
    period: Span,
    /// Time of the next one.
    due: Span,
    /// Decisions in the newest plan.
    decisions: Option<u64>,
}

impl PlanPublisher {
    /// Creates the publisher of the axes with a lead; none if there is no such axis.
    pub(crate) fn new(
        configs: &[AxisConfig],
        cycle: Span,
        origin: Span,
        header: RunCycle,
    ) -> Option<Self> {
        let planned = configs.iter().filter(|axis| axis.lead() > Span::ZERO);
        let axes: Box<[_]> = planned.map(|axis| AxisInTurn::new(axis, cycle)).collect();
        (!axes.is_empty()).then(|| Self {
            header,
            origin,
            axes,
            turn: 0,
            // Sized once, because the cycle must not allocate.
            message: Vec::with_capacity(MAX_PLANS),
            body: Box::new([0; PLANS_CAPACITY]),
            waiting: None,
            published: 0,
        })
    }

    /// Encodes the plans that are due in a cycle, `since_start` after the start of the node, of some of the `sources`.
    pub(crate) fn encode<'a>(
        &mut self,
        tick: &Tick,
        since_start: Span,
        source_of: impl Fn(u32) -> Option<&'a SourceAxis>,
    ) {
        self.message.clear();
        // One message a cycle bounds its work: many axes take turns.
        for _ in 0..self.axes.len() {
            if self.message.len() == MAX_PLANS {
                break;
            }
            let turn = self.turn;
            self.turn = (turn + 1) % self.axes.len();
            let axis = &mut self.axes[turn];
            let Some(source) = source_of(axis.id) else {
                continue;
            };
            let is_new = axis.decisions != Some(source.decisions());
            if !is_new && since_start < axis.due {
                continue;
            }
            if let Some(plan) = source.plan(since_start, self.origin) {
                axis.decisions = Some(source.decisions());
                axis.due = since_start + axis.period;
                let axis_id = axis.id;
                self.message.push(AxisPlan { axis_id, plan });
            }
        }
        self.header.count = tick.count;
        self.published += self.message.len() as u64;
        self.waiting = (!self.message.is_empty())
            .then(|| encode_plans(&self.header, &self.message, &mut self.body));
    }

    /// Takes the pending message, once.
    pub(crate) fn transmit(&mut self, ideal_start: Instant<Local>) -> Option<Outgoing<'_>> {
        let length = self.waiting.take()?;
        Some(Outgoing {
            channel: Channel::Plans,
            far: 0,
            ideal_start,
            body: &self.body[..length],
        })
    }
}

impl AxisInTurn {
    fn new(axis: &AxisConfig, cycle: Span) -> Self {
        Self {
            id: axis.id.get(),
            // A promise of L that is renewed every L/2 lasts for L/2 at least.
            period: PERIOD.min(axis.lead() / 2).max(cycle),
            due: Span::ZERO,
            decisions: None,
        }
    }
}
