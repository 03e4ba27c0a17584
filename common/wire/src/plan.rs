//! Plans on the wire: `docs/WIRE.md` describes every byte.
//!
//! A message has the plans of up to [`MAX_PLANS`] axes of a node, each with its promise. Like a frame it is written up to
//! its send stamp in the cycle; the publishing thread appends the rest ([`KeySeal::seal`]).
//!
//! A node gets a plan piece by piece: each is as small as any other message, so that they pass through the same rings.

use coaxle_axis::motion_plan::{InvalidPlan, MOST_PIECES, MotionPiece, MotionPlan, PlanFault};
use coaxle_clock::Span;
use coaxle_curve::profile::{Kinematics, Limits};
use serde::{Deserialize, Serialize};

use crate::channel::Channel;
use crate::frame::{KeySeal, read, read_send_stamp, sender_id, write};
use crate::keys::NodeName;
use crate::message::{Message, PlannedPiece};
use crate::rejection::Rejection;
use crate::run_cycle::{ListPrefix, RunCycle};

/// Greatest number of plans in one message.
pub const MAX_PLANS: usize = 8;

/// A buffer of this many bytes holds the body of every message of plans.
pub const PLANS_CAPACITY: usize = 1 + 5 + 10 + 10 + 1 + MAX_PLANS * MAX_PLAN_LEN;

/// Axis id, four limits, promise, number of pieces, pieces.
const MAX_PLAN_LEN: usize = 5 + 4 * 8 + 10 + 1 + MOST_PIECES * (10 + 10 + 4 * 8);

/// Plan of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisPlan {
    /// The axis id.
    pub axis_id: u32,
    /// Its motion ahead.
    pub plan: MotionPlan,
}

/// Writes a message of plans up to its send stamp into `out` and returns its length. Of more than [`MAX_PLANS`] the first
/// are taken. Does not allocate.
pub fn encode_plans(
    header: &RunCycle,
    plans: &[AxisPlan],
    out: &mut [u8; PLANS_CAPACITY],
) -> usize {
    const ROOM: &str = "the buffer holds the longest plans";
    let plans = &plans[..plans.len().min(MAX_PLANS)];
    let mut used = write(&ListPrefix::of(header, plans.len()), out).expect(ROOM);
    for AxisPlan { axis_id, plan } in plans {
        let prefix = PlanPrefix::of(*axis_id, plan);
        used += write(&prefix, &mut out[used..]).expect(ROOM);
        for piece in plan.pieces() {
            used += write(&PieceBody::from(piece), &mut out[used..]).expect(ROOM);
        }
    }
    used
}

impl KeySeal {
    /// Checks a message of plans and passes them on one after the other, each with its axis id, or with its fault. Does
    /// not allocate.
    ///
    /// # Errors
    /// [`Rejection`], the first reason that applies. Nothing is handed out then.
    pub fn open_plans(
        &self,
        payload: &[u8],
        each: impl FnMut(u32, Result<MotionPlan, InvalidPlan>),
    ) -> Result<RunCycle, Rejection> {
        let plans = self.verified_plans(payload)?;
        plans.each(each)?;
        Ok(plans.header)
    }

    fn verified_plans<'a>(&self, payload: &'a [u8]) -> Result<ReadPlans<'a>, Rejection> {
        let content = self.verify(payload, |content| ReadPlans::read(content).map(drop))?;
        ReadPlans::read(content)
    }
}

/// Takes the plans of the axes that are followed out of the messages of one node.
#[derive(Clone, Debug)]
pub struct PlanIntake {
    seal: KeySeal,
    sender: u32,
    /// The ids that are followed, in order, with their numbers.
    places: Box<[(u32, u16)]>,
}

impl PlanIntake {
    /// Follows the axes `ids` of the node `sender`.
    #[must_use]
    pub fn new(sender: &NodeName, ids: &[u32]) -> Self {
        let mut places: Box<[_]> = ids.iter().copied().zip(0..).collect();
        places.sort_unstable();
        Self {
            seal: KeySeal::new(&sender.channel_key(Channel::Plans)),
            sender: sender_id(sender),
            places,
        }
    }

    /// Passes on the pieces of all good plans of followed axes, and the faults of others. Does not allocate.
    ///
    /// # Errors
    /// [`Rejection`], the first reason that applies. Nothing is handed out then.
    pub(crate) fn read(
        &self,
        payload: &[u8],
        mut each: impl FnMut(&Message<'_>),
    ) -> Result<(), Rejection> {
        let plans = self.seal.verified_plans(payload)?;
        let RunCycle {
            sender,
            epoch,
            count,
        } = plans.header;
        if sender != self.sender {
            return Err(Rejection::ForeignSender);
        }
        plans.each(|id, plan| {
            let Ok(place) = self.places.binary_search_by_key(&id, |(id, _)| *id) else {
                return;
            };
            let plan = match plan {
                Ok(plan) => plan,
                Err(InvalidPlan { fault, .. }) => return each(&Message::PlanRefused(fault)),
            };
            let of = plan.pieces().len() as u8;
            for (number, piece) in (0..).zip(plan.pieces()) {
                each(&Message::PlannedPiece(PlannedPiece {
                    epoch,
                    count,
                    axis: self.places[place].1,
                    number,
                    of,
                    promised_until: plan.promised_until(),
                    piece: *piece,
                }));
            }
        })
    }
}

#[derive(Serialize, Deserialize)]
struct PlanPrefix {
    axis_id: u32,
    velocity: f64,
    acceleration: f64,
    deceleration: f64,
    jerk: f64,
    promised_until: Span,
    pieces: u32,
}

#[derive(Serialize, Deserialize)]
struct PieceBody {
    start: Span,
    duration: Span,
    position: f64,
    velocity: f64,
    acceleration: f64,
    jerk: f64,
}

impl PlanPrefix {
    fn of(axis_id: u32, plan: &MotionPlan) -> Self {
        let limits = plan.limits();
        Self {
            axis_id,
            velocity: limits.velocity(),
            acceleration: limits.acceleration(),
            deceleration: limits.deceleration(),
            jerk: limits.jerk(),
            promised_until: plan.promised_until(),
            pieces: plan.pieces().len() as u32,
        }
    }

    fn limits(&self) -> Result<Limits, InvalidPlan> {
        let Self {
            velocity,
            acceleration,
            deceleration,
            jerk,
            ..
        } = *self;
        Limits::new(velocity, acceleration, deceleration, jerk).map_err(|wrong| InvalidPlan {
            fault: PlanFault::InvalidLimits,
            piece: None,
            received: wrong.received,
            expected: None,
        })
    }
}

impl From<&MotionPiece> for PieceBody {
    fn from(piece: &MotionPiece) -> Self {
        Self {
            start: piece.start,
            duration: piece.duration,
            position: piece.from.position,
            velocity: piece.from.velocity,
            acceleration: piece.from.acceleration,
            jerk: piece.jerk,
        }
    }
}

impl From<PieceBody> for MotionPiece {
    fn from(body: PieceBody) -> Self {
        Self {
            start: body.start,
            duration: body.duration,
            from: Kinematics {
                position: body.position,
                velocity: body.velocity,
                acceleration: body.acceleration,
            },
            jerk: body.jerk,
        }
    }
}

/// Piece of a plan in a recorded scan.
#[derive(Serialize, Deserialize)]
pub(crate) struct PlannedPieceOnWire {
    epoch: u64,
    count: u64,
    axis: u16,
    number: u8,
    of: u8,
    promised_until: Span,
    piece: PieceBody,
}

impl From<PlannedPiece> for PlannedPieceOnWire {
    fn from(planned: PlannedPiece) -> Self {
        Self {
            epoch: planned.epoch,
            count: planned.count,
            axis: planned.axis,
            number: planned.number,
            of: planned.of,
            promised_until: planned.promised_until,
            piece: PieceBody::from(&planned.piece),
        }
    }
}

impl From<PlannedPieceOnWire> for PlannedPiece {
    fn from(planned: PlannedPieceOnWire) -> Self {
        Self {
            epoch: planned.epoch,
            count: planned.count,
            axis: planned.axis,
            number: planned.number,
            of: planned.of,
            promised_until: planned.promised_until,
            piece: planned.piece.into(),
        }
    }
}

/// Message of plans, read to its end.
struct ReadPlans<'a> {
    header: RunCycle,
    count: u32,
    /// Bytes that begin with the plans.
    plans: &'a [u8],
}

impl<'a> ReadPlans<'a> {
    fn read(content: &'a [u8]) -> Result<Self, Rejection> {
        let (header, count, plans) = ListPrefix::read(content, MAX_PLANS)?;
        let mut rest = plans;
        for _ in 0..count {
            (_, rest) = read_plan(rest)?;
        }
        read_send_stamp(rest)?;
        Ok(Self {
            header,
            count,
            plans,
        })
    }

    fn each(
        &self,
        mut each: impl FnMut(u32, Result<MotionPlan, InvalidPlan>),
    ) -> Result<(), Rejection> {
        let mut rest = self.plans;
        for _ in 0..self.count {
            let ((axis_id, plan), behind) = read_plan(rest)?;
            rest = behind;
            each(axis_id, plan);
        }
        Ok(())
    }
}

/// A plan with the id of its axis, and the bytes behind it.
type ReadPlan<'a> = ((u32, Result<MotionPlan, InvalidPlan>), &'a [u8]);

fn read_plan(bytes: &[u8]) -> Result<ReadPlan<'_>, Rejection> {
    let (prefix, mut rest) = read::<PlanPrefix>(bytes)?;
    let mut pieces = [MotionPiece::default(); MOST_PIECES];
    // Too many are read to their end, too: what follows them may be good. Their bytes bound their number.
    for n in 0..prefix.pieces as usize {
        let body;
        (body, rest) = read::<PieceBody>(rest)?;
        if let Some(piece) = pieces.get_mut(n) {
            *piece = body.into();
        }
    }
    let plan = match pieces.get(..prefix.pieces as usize) {
        Some(pieces) => prefix
            .limits()
            .and_then(|limits| MotionPlan::new(pieces, prefix.promised_until, &limits)),
        None => Err(InvalidPlan::of_plan(
            PlanFault::TooManyPieces,
            prefix.pieces.into(),
            MOST_PIECES as f64,
        )),
    };
    Ok(((prefix.axis_id, plan), rest))
}
