//! The states an axis reports.

bitflags::bitflags! {
    /// `nStateDWord`, bit by bit. Bits without a name survive unchanged.
    #[doc(alias = "nStateDWord")]
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub struct StateWord: u32 {
        /// Ready for motion commands.
        const OPERATIONAL = 1 << 0;
        /// Referenced.
        const HOMED = 1 << 1;
        /// Standing still.
        const NOT_MOVING = 1 << 2;
        /// Within the position window.
        const IN_POSITION_AREA = 1 << 3;
        /// In the target position.
        const IN_TARGET_POSITION = 1 << 4;
        /// In a protected mode.
        const PROTECTED = 1 << 5;
        /// An error is held back.
        const ERROR_PROPAGATION_DELAYED = 1 << 6;
        /// Has been stopped.
        const HAS_BEEN_STOPPED = 1 << 7;
        /// Executes a command.
        const HAS_JOB = 1 << 8;
        /// Moves towards larger positions.
        const POSITIVE_DIRECTION = 1 << 9;
        /// Moves towards smaller positions.
        const NEGATIVE_DIRECTION = 1 << 10;
        /// The reference run is under way.
        const HOMING_BUSY = 1 << 11;
        /// Moves at constant velocity.
        const CONSTANT_VELOCITY = 1 << 12;
        /// A superposed movement compensates a distance.
        const COMPENSATING = 1 << 13;
        /// External set points are in force.
        const EXT_SET_POINT_GEN_ENABLED = 1 << 14;
        /// An external latch value is valid.
        const EXTERNAL_LATCH_VALID = 1 << 16;
        /// Has a new target position.
        const NEW_TARGET_POS = 1 << 17;
        /// Moves without an end.
        const CONTINUOUS_MOTION = 1 << 19;
        /// The control loop is closed.
        const CONTROL_LOOP_CLOSED = 1 << 20;
        /// A new cam table waits for its activation.
        const CAM_TABLE_QUEUED = 1 << 21;
        /// Changed cam points wait for their activation.
        const CAM_DATA_QUEUED = 1 << 22;
        /// A cam scaling waits for its activation.
        const CAM_SCALING_PENDING = 1 << 23;
        /// A command is buffered.
        const CMD_BUFFERED = 1 << 24;
        /// In point-to-point mode.
        const PTP_MODE = 1 << 25;
        /// Below the lower software limit.
        const SOFT_LIMIT_MIN_EXCEEDED = 1 << 26;
        /// Above the upper software limit.
        const SOFT_LIMIT_MAX_EXCEEDED = 1 << 27;
        /// The drive reports an error.
        const DRIVE_DEVICE_ERROR = 1 << 28;
        /// Motion commands are locked.
        const MOTION_COMMANDS_LOCKED = 1 << 29;
        /// The I/O data are invalid.
        const IO_DATA_INVALID = 1 << 30;
        /// The axis is in error.
        const ERROR = 1 << 31;

        // Unknown bits of newer controllers are kept.
        const _ = !0;
    }
}

impl StateWord {
    /// Bits of a velocity: standing still, or its direction.
    #[must_use]
    pub fn of_velocity(velocity: f64) -> Self {
        let mut word = Self::empty();
        // Exactly 0: planners end at 0, and a threshold would call a slow axis standing.
        word.set(Self::NOT_MOVING, velocity == 0.0);
        word.set(Self::POSITIVE_DIRECTION, velocity > 0.0);
        word.set(Self::NEGATIVE_DIRECTION, velocity < 0.0);
        word
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for StateWord {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u32(self.bits())
    }
}

#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for StateWord {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        // Unknown bits of newer controllers are kept.
        u32::deserialize(deserializer).map(Self::from_bits_retain)
    }
}

macro_rules! coded_state {
    ($(#[$meta:meta])* $name:ident { $($(#[$variant_meta:meta])* $variant:ident = $code:literal,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[cfg_attr(feature = "serde", serde(from = "u32", into = "u32"))]
        pub enum $name {
            $($(#[$variant_meta])* $variant,)*
            /// A code that the manuals do not name, kept unchanged.
            Other(u32),
        }

        impl From<u32> for $name {
            fn from(code: u32) -> Self {
                match code {
                    $($code => Self::$variant,)*
                    other => Self::Other(other),
                }
            }
        }

        impl From<$name> for u32 {
            fn from(state: $name) -> Self {
                match state {
                    $($name::$variant => $code,)*
                    $name::Other(code) => code,
                }
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self::from(0)
            }
        }
    };
}

coded_state! {
    /// `nAxisState`: state of the axis's motion. 11 to 13 are for slaves.
    #[doc(alias = "nAxisState")]
    AxisState {
        /// No command.
        Inactive = 0,
        /// A command runs.
        Running = 1,
        /// The override is zero.
        OverrideZero = 2,
        /// Constant velocity.
        ConstantVelocity = 3,
        /// Accelerating.
        Accelerating = 4,
        /// Decelerating.
        Decelerating = 5,
        /// Slave: before the synchronisation.
        SlavePrephase = 11,
        /// Slave: synchronising.
        SlaveSynchronizing = 12,
        /// Slave: synchronous.
        SlaveSynchronous = 13,
    }
}

coded_state! {
    /// `nCoupleState`: the axis's role in couplings.
    #[doc(alias = "nCoupleState")]
    CoupleState {
        /// Not coupled.
        Single = 0,
        /// Master of at least one slave.
        Master = 1,
        /// Slave of one axis, master of another.
        MasterSlave = 2,
        /// Slave.
        Slave = 3,
    }
}

impl AxisState {
    /// State of an axis with its own motion.
    #[must_use]
    pub fn of_motion(velocity: f64, acceleration: f64) -> Self {
        // Opposite signs first: else a deceleration would count as an acceleration.
        if velocity * acceleration < 0.0 {
            Self::Decelerating
        } else if acceleration != 0.0 {
            Self::Accelerating
        } else if velocity != 0.0 {
            Self::ConstantVelocity
        } else {
            Self::Inactive
        }
    }
}
