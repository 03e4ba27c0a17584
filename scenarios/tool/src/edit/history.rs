//! Texts, one after the other, back and forth.

/// Greatest number of steps.
// Texts are kept whole: 500 of some kilobytes are a few megabytes.
const MOST_STEPS: usize = 500;

/// Greatest sum of the lengths of former texts, bytes.
// A text may have 4 MiB, and 500 of those would be 2 GiB. Sixteen of the longest remain, and all steps of one with 128 KiB.
const MOST_BYTES: usize = 64 << 20;

/// The present text, and the former ones.
pub(super) struct History {
    now: String,
    past: Vec<String>,
    future: Vec<String>,
    /// The gesture under way: all of it is one step.
    gesture: Option<u64>,
}

impl History {
    pub(super) const fn of(text: String) -> Self {
        Self {
            now: text,
            past: Vec::new(),
            future: Vec::new(),
            gesture: None,
        }
    }

    pub(super) fn now(&self) -> &str {
        &self.now
    }

    pub(super) const fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    pub(super) const fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }

    /// Another text; with the gesture of the one before, it takes its place.
    pub(super) fn change(&mut self, text: String, gesture: Option<u64>) {
        // A change that changes nothing would cost an undo and the texts ahead.
        if text == self.now {
            return;
        }
        let before = std::mem::replace(&mut self.now, text);
        let goes_on = gesture.is_some() && gesture == self.gesture;
        if !goes_on {
            self.past.push(before);
            self.forget_oldest();
        }
        // Texts that were undone belong to the former course of changes.
        self.future.clear();
        self.gesture = gesture;
    }

    fn forget_oldest(&mut self) {
        let mut bytes: usize = self.past.iter().map(String::len).sum();
        let too_many = self.past.len().saturating_sub(MOST_STEPS);
        let is_kept = |(place, text): (usize, &String)| {
            let fits = place >= too_many && bytes <= MOST_BYTES;
            bytes -= text.len();
            fits
        };
        let oldest = self.past.iter().enumerate().position(is_kept);
        // Moves 499 strings without their texts, once a gesture. Without one that fits, all are forgotten.
        self.past.drain(..oldest.unwrap_or(self.past.len()));
    }

    pub(super) fn undo(&mut self) {
        if let Some(text) = self.past.pop() {
            self.future.push(std::mem::replace(&mut self.now, text));
        }
        self.gesture = None;
    }

    pub(super) fn redo(&mut self) {
        if let Some(text) = self.future.pop() {
            self.past.push(std::mem::replace(&mut self.now, text));
        }
        self.gesture = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of steps back after this many changes to texts of this length.
    fn steps(changes: usize, length: usize) -> usize {
        let mut history = History::of(String::new());
        for n in 0..changes {
            history.change(format!("{n:04}") + &" ".repeat(length - 4), None);
        }
        let mut steps = 0;
        while history.can_undo() {
            history.undo();
            steps += 1;
        }
        steps
    }

    #[test]
    fn former_texts_are_bounded_in_number_and_in_bytes() {
        assert_eq!(steps(600, 10), MOST_STEPS);
        assert_eq!(steps(3, 10), 3);
        assert_eq!(steps(40, 4 << 20), 16);
    }
}
