//! What a command that waits still has to pass.

bitflags::bitflags! {
    /// What is checked again when a command that waits is due: it can still be refused then, and the
    /// axis goes on without it.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub struct Awaits: u8 {
        /// That the slave does not jump.
        const JUMP = 1;
        /// That what it changes still couples the slave.
        const STILL_COUPLED = 1 << 1;
        /// That no other change of that kind is still to be undone.
        const NOTHING_PENDING = 1 << 2;
        /// That it is not to take out the last plate for one cycle.
        const NOT_THE_LAST = 1 << 3;
        /// That the set values are finite.
        const FINITE = 1 << 4;
        /// That the way to the masters keeps the limits.
        const LIMITS = 1 << 5;
    }
}

impl Awaits {
    /// The names of what is checked.
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
