//! Channels of a node, each under a key of its own.

/// Kind of frames of a node; each kind has a key of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// `coaxle/<node>/axes`: a sender's own axes.
    Axes,
    /// `coaxle/<node>/slaves`: a receiver's slave axes.
    Slaves,
    /// `coaxle/<node>/time-requests`: time requests to the node, published by others.
    TimeRequests,
    /// `coaxle/<node>/time-responses`: the node's responses to them.
    TimeResponses,
    /// `coaxle/<node>/far-axes`: the axes that a receiver follows, as corrected.
    FarAxes,
    /// `coaxle/<node>/beacon-requests`: beacons to the node from its followers. Beside the transport.
    BeaconRequests,
    /// `coaxle/<node>/beacon-responses`: the node's responses to them. Beside the transport.
    BeaconResponses,
    /// `coaxle/<node>/plans`: motions of a sender's own axes, promised ahead.
    Plans,
    /// `coaxle/<node>/followers`: reports of a receiver on its slaves, to the nodes that it follows.
    Followers,
}

impl Channel {
    /// Every channel.
    pub const ALL: [Self; 9] = [
        Self::Axes,
        Self::Slaves,
        Self::TimeRequests,
        Self::TimeResponses,
        Self::FarAxes,
        Self::BeaconRequests,
        Self::BeaconResponses,
        Self::Plans,
        Self::Followers,
    ];

    /// Returns the last part of its key.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Axes => "axes",
            Self::Slaves => "slaves",
            Self::TimeRequests => "time-requests",
            Self::TimeResponses => "time-responses",
            Self::FarAxes => "far-axes",
            Self::BeaconRequests => "beacon-requests",
            Self::BeaconResponses => "beacon-responses",
            Self::Plans => "plans",
            Self::Followers => "followers",
        }
    }

    /// True for the timing channel, whose beacons travel beside the transport. Its key is only part of
    /// their check sums.
    #[must_use]
    pub const fn is_timing(self) -> bool {
        matches!(self, Self::BeaconRequests | Self::BeaconResponses)
    }

    /// True if its frames hold axes and come once per cycle. All other frames are stamped when they
    /// leave, whatever is configured: they are of no use without a stamp.
    #[must_use]
    pub const fn carries_axes(self) -> bool {
        matches!(self, Self::Axes | Self::Slaves | Self::FarAxes)
    }
}
