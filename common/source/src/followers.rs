//! Followers of an axis, as their nodes report them.

use coaxle_curve::profile::Limits;

/// State of all followers of an axis together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Followers {
    /// True if each of them has slaves of the axis, and all of these are in sync.
    pub are_in_sync: bool,
    /// True if a slave of one of them is in error, or if one is silent or has begun again.
    pub have_failed: bool,
    /// Limits within which the axis leads all slaves that are not in error within theirs, u.
    pub limits: Limits,
}

impl Followers {
    /// Followers that have not reported yet.
    pub const UNKNOWN: Self = Self {
        are_in_sync: false,
        have_failed: false,
        limits: Limits::NONE,
    };
}
