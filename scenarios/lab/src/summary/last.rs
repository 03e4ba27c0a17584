//! Signals of the last cycle that their declaration keeps for the summary.

use coaxle_node::fields_of;
use coaxle_node::signal::{Signal, Signals};
use coaxle_receiver::signals::{FarAxisSignals, FarNodeSignals, NodeSignals};
use serde::{Serialize, Serializer};
use serde_json::Value;

/// A receiver's signals in its last cycle, with those of one of its far axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LastSignals {
    /// The receiver itself.
    pub node: NodeSignals,
    /// The node that publishes the axis.
    pub far: FarNodeSignals,
    /// The axis.
    pub axis: FarAxisSignals,
}

impl LastSignals {
    /// Every signal in the summary, with its value, in the order of the declarations.
    pub fn values(&self) -> impl Iterator<Item = (&'static Signal, Value)> {
        values(&self.node)
            .chain(values(&self.far))
            .chain(values(&self.axis))
    }
}

impl Serialize for LastSignals {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.values().map(|(signal, value)| (signal.name, value)))
    }
}

/// Serializes a field of such signals: those in the summary.
pub(super) fn summarized<T: Signals + Serialize, S: Serializer>(
    signals: &T,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(values(signals).map(|(signal, value)| (signal.name, value)))
}

fn values<T: Signals + Serialize>(signals: &T) -> impl Iterator<Item = (&'static Signal, Value)> {
    let mut fields = fields_of(signals);
    T::SIGNALS
        .iter()
        .filter(|signal| signal.is_summarized)
        // In the order of the declarations, which a map of fields does not keep.
        .map(move |signal| (signal, fields.remove(signal.name).unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_groups_summarize_a_signal_of_one_name() {
        let last = LastSignals::default();
        let mut names: Vec<_> = last.values().map(|(signal, _)| signal.name).collect();
        names.sort_unstable();
        let all = names.len();
        names.dedup();
        assert_eq!(names.len(), all, "{names:?}");
    }

    #[test]
    fn what_is_not_summarized_is_left_out() {
        let mut last = LastSignals::default();
        last.far.lost = 7;
        let json = serde_json::to_value(&last).unwrap();
        assert_eq!(json["lost"], 7);
        assert_eq!(json.get("age_cycles"), None);
    }
}
