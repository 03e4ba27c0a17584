//! Log events of wrapping far axis positions without a configured modulo period.

use super::{Level, Note};
use crate::snapshot::ReceiverSnapshot;

/// A line for each axis, at its first wrap.
pub(super) fn of_wraps(
    before: &ReceiverSnapshot,
    now: &ReceiverSnapshot,
    names: &[String],
) -> Vec<Note> {
    let axes = before.signals.axes.iter().zip(&now.signals.axes);
    let wrapped = axes.zip(names).filter_map(|((before, now), name)| {
        // The first wrap only: an axis that turns wraps again and again.
        let length = now.wrap_length.filter(|_| before.wraps == 0)?;
        let text = format!(
            "{name}: received set positions that wrap by {length}, expected ones that go on: if they are within the \
             turn, say position = \"within-turn\" and modulo = {length:.0} of this axis"
        );
        Some(Note::new(Level::Warning, text))
    });
    wrapped.collect()
}
