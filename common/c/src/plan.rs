//! Plans: the motion that a node promises of its axes, as structs and as bytes (docs/WIRE.md).

use ::coaxle_axis::motion_plan::{MOST_PIECES, MotionPiece, MotionPlan};
use coaxle_clock::Span;
use coaxle_curve::profile::{Kinematics, Limits};
use coaxle_wire::RunCycle;
use coaxle_wire::plan::{AxisPlan, MAX_PLANS, PLANS_CAPACITY, encode_plans};

use crate::failure::{COAXLE_REJECTED, Failure};
use crate::handle::call;
use crate::memory::{readable_array, writable, writable_array};
use crate::wire::{COAXLE_MOST_BYTES, coaxle_key, rejected, sealed};

/// Greatest number of pieces of a plan.
pub const COAXLE_MOST_PIECES: usize = 8;
/// Greatest number of plans in a message.
pub const COAXLE_MOST_PLANS: usize = 8;

const _: () = assert!(COAXLE_MOST_PIECES == MOST_PIECES && COAXLE_MOST_PLANS == MAX_PLANS);
const _: () = assert!(PLANS_CAPACITY + 15 <= COAXLE_MOST_BYTES);

/// A piece of a planned motion, with constant jerk. It does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct coaxle_motion_piece {
    /// Begin of the piece, ns of the node's run: cycle count times cycle time.
    pub start_ns: i64,
    /// Duration of the piece, ns, above 0.
    pub duration_ns: i64,
    /// Position at its begin, u.
    pub position: f64,
    /// Velocity at its begin, u/s.
    pub velocity: f64,
    /// Acceleration at its begin, u/s².
    pub acceleration: f64,
    /// Jerk, u/s³.
    pub jerk: f64,
}

/// The planned motion of an axis, and its promise. It does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct coaxle_plan {
    /// Cycle count of the node when it made the plan.
    pub count: u64,
    /// The axis id.
    pub axis_id: u32,
    /// Number of pieces, 1 to `COAXLE_MOST_PIECES`.
    pub number: u32,
    /// Until then the axis does not deviate from the plan, ns of the node's run: within its pieces.
    pub promised_until_ns: i64,
    /// Largest velocity of the axis, u/s.
    pub max_velocity: f64,
    /// Largest acceleration of the axis, u/s².
    pub max_acceleration: f64,
    /// Largest deceleration of the axis, u/s².
    pub max_deceleration: f64,
    /// Largest jerk of the axis, u/s³.
    pub max_jerk: f64,
    /// The pieces, one after the other without a gap or a jump.
    pub pieces: [coaxle_motion_piece; COAXLE_MOST_PIECES],
}

/// Writes a message with up to `COAXLE_MOST_PLANS` plans of one cycle into `bytes`, which has room for `capacity`, and passes out its
/// `length`. The key is that of the node: `coaxle/<node>/plans`. `sender` and `epoch` are those of its frames.
///
/// # Errors
/// `COAXLE_REJECTED` names a plan that is no motion of its axis.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_plans_encode(
    key: *mut coaxle_key,
    sender: u32,
    epoch: u64,
    plans: *const coaxle_plan,
    number: usize,
    bytes: *mut u8,
    capacity: usize,
    length: *mut usize,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(key, |key| {
            let plans = readable_array(plans, number, "plans")?;
            if !(1..=MAX_PLANS).contains(&plans.len()) {
                return Err(Failure::range("number", plans.len(), "1 to 8 plans"));
            }
            let count = plans[0].count;
            let mut taken = [plans[0].of_axis()?; MAX_PLANS];
            for (place, plan) in taken.iter_mut().zip(plans).skip(1) {
                if plan.count != count {
                    return Err(Failure::range(
                        "count",
                        plan.count,
                        format_args!("{count}, that of all plans of a message"),
                    ));
                }
                *place = plan.of_axis()?;
            }
            let header = RunCycle {
                sender,
                epoch,
                count,
            };
            let mut body = [0; PLANS_CAPACITY];
            let written = encode_plans(&header, &taken[..plans.len()], &mut body);
            sealed(key, &body[..written], None, bytes, capacity, length)
        })
    }
}

/// Reads a message of plans: up to `capacity` of its good plans; passes out their `number`, the run (`epoch`) of its sender, and how many
/// were `refused` because they are no motion of their axis.
///
/// # Errors
/// `COAXLE_REJECTED` and the reason.
///
/// # Safety
/// The rules of the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn coaxle_plans_decode(
    key: *mut coaxle_key,
    bytes: *const u8,
    length: usize,
    epoch: *mut u64,
    plans: *mut coaxle_plan,
    capacity: usize,
    number: *mut usize,
    refused: *mut usize,
) -> i32 {
    // SAFETY: as for this function.
    unsafe {
        call(key, |key| {
            let bytes = readable_array(bytes, length, "bytes")?;
            let plans = writable_array(plans, capacity, "plans")?;
            let epoch = writable(epoch, "epoch")?;
            let (number, refused) = (writable(number, "number")?, writable(refused, "refused")?);
            (*number, *refused) = (0, 0);
            let opened = key.seal.open_plans(bytes, |id, plan| match plan {
                Ok(plan) => {
                    if let Some(place) = plans.get_mut(*number) {
                        *place = coaxle_plan::of(id, &plan);
                        *number += 1;
                    }
                }
                Err(_) => *refused += 1,
            });
            let header = opened.map_err(rejected)?;
            *epoch = header.epoch;
            for plan in &mut plans[..*number] {
                plan.count = header.count;
            }
            Ok(())
        })
    }
}

impl coaxle_plan {
    /// Converts a plan, without the count of its message.
    fn of(axis_id: u32, plan: &MotionPlan) -> Self {
        let mut pieces = [coaxle_motion_piece::default(); MOST_PIECES];
        for (place, piece) in pieces.iter_mut().zip(plan.pieces()) {
            *place = coaxle_motion_piece::of(piece);
        }
        let limits = plan.limits();
        Self {
            count: 0,
            axis_id,
            // At most 8.
            number: plan.pieces().len() as u32,
            promised_until_ns: plan.promised_until().as_nanos(),
            max_velocity: limits.velocity(),
            max_acceleration: limits.acceleration(),
            max_deceleration: limits.deceleration(),
            max_jerk: limits.jerk(),
            pieces,
        }
    }

    fn of_axis(&self) -> Result<AxisPlan, Failure> {
        Ok(AxisPlan {
            axis_id: self.axis_id,
            plan: self.checked()?,
        })
    }

    pub(crate) fn checked(&self) -> Result<MotionPlan, Failure> {
        let number = usize::try_from(self.number).unwrap_or(usize::MAX);
        let Some(given) = self.pieces.get(..number) else {
            return Err(Failure::range("number", self.number, "1 to 8 pieces"));
        };
        let limits = Limits::new(
            self.max_velocity,
            self.max_acceleration,
            self.max_deceleration,
            self.max_jerk,
        );
        let limits = limits.map_err(|wrong| Failure::new(COAXLE_REJECTED, wrong))?;
        let mut pieces = [MotionPiece::default(); MOST_PIECES];
        for (place, piece) in pieces.iter_mut().zip(given) {
            *place = piece.taken();
        }
        let until = Span::from_nanos(self.promised_until_ns);
        MotionPlan::new(&pieces[..number], until, &limits)
            .map_err(|wrong| Failure::new(COAXLE_REJECTED, wrong))
    }
}

impl coaxle_motion_piece {
    const fn of(piece: &MotionPiece) -> Self {
        Self {
            start_ns: piece.start.as_nanos(),
            duration_ns: piece.duration.as_nanos(),
            position: piece.from.position,
            velocity: piece.from.velocity,
            acceleration: piece.from.acceleration,
            jerk: piece.jerk,
        }
    }

    const fn taken(&self) -> MotionPiece {
        MotionPiece {
            start: Span::from_nanos(self.start_ns),
            duration: Span::from_nanos(self.duration_ns),
            from: Kinematics {
                position: self.position,
                velocity: self.velocity,
                acceleration: self.acceleration,
            },
            jerk: self.jerk,
        }
    }
}
