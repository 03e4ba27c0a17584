//! What a node publishes, each under a key of its own.

/// What a node's frames are about; each kind has a key of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// `coaxle/<node>/axes`: a sender's own axes.
    Axes,
    /// `coaxle/<node>/slaves`: a receiver's slave axes.
    Slaves,
    /// `coaxle/<node>/time-requests`: what others ask the node, published by them.
    TimeRequests,
    /// `coaxle/<node>/time-responses`: how the node responds.
    TimeResponses,
    /// `coaxle/<node>/far-axes`: the axes that a receiver follows, as corrected.
    FarAxes,
    /// `coaxle/<node>/beacon-requests`: beacons to the node, of those who follow it. Beside the transport.
    BeaconRequests,
    /// `coaxle/<node>/beacon-responses`: how it answers them. Beside the transport.
    BeaconResponses,
}

impl Channel {
    /// Every channel.
    pub const ALL: [Self; 7] = [
        Self::Axes,
        Self::Slaves,
        Self::TimeRequests,
        Self::TimeResponses,
        Self::FarAxes,
        Self::BeaconRequests,
        Self::BeaconResponses,
    ];

    /// The last part of its key.
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
        }
    }

    /// Whether it is part of the timing channel, whose beacons travel beside the transport; its key is in their check sums
    /// alone.
    #[must_use]
    pub const fn is_timing(self) -> bool {
        matches!(self, Self::BeaconRequests | Self::BeaconResponses)
    }

    /// Whether its frames hold axes and come once per cycle. The others are stamped whenever they
    /// leave, whatever is configured: they are of no use without.
    #[must_use]
    pub const fn carries_axes(self) -> bool {
        matches!(self, Self::Axes | Self::Slaves | Self::FarAxes)
    }
}
