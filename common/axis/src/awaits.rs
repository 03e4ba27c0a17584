//! Checks that a waiting command still has to pass.

bitflags::bitflags! {
    /// Checks repeated when a waiting command is due: it can still be refused then, and the axis
    /// continues without it.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub struct Awaits: u8 {
        /// No jump of the slave.
        const JUMP = 1;
        /// Changed object still couples the slave.
        const STILL_COUPLED = 1 << 1;
        /// No other change of that kind pending.
        const NOTHING_PENDING = 1 << 2;
        /// Removal of the last plate for one cycle excluded.
        const NOT_THE_LAST = 1 << 3;
        /// Finite set values.
        const FINITE = 1 << 4;
        /// Motion to the masters within the limits.
        const LIMITS = 1 << 5;
    }
}

impl Awaits {
    /// Names of the checks.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        const NAMES: [(Awaits, &str); 6] = [
            (Awaits::JUMP, "no-jump"),
            (Awaits::STILL_COUPLED, "still-coupled"),
            (Awaits::NOTHING_PENDING, "nothing-pending"),
            (Awaits::NOT_THE_LAST, "not-the-last-plate"),
            (Awaits::FINITE, "finite"),
            (Awaits::LIMITS, "limits"),
        ];
        let is_awaited = move |(flag, _): &(Self, &'static str)| self.contains(*flag);
        NAMES.into_iter().filter(is_awaited).map(|(_, name)| name)
    }
}
