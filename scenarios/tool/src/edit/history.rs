//! Texts, one after the other, back and forth.

/// Greatest number of steps.
// Texts are kept whole: 500 of some kilobytes are a few megabytes.
const MOST_STEPS: usize = 500;

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
            if self.past.len() == MOST_STEPS {
                // Moves 499 strings without their texts, once a gesture.
                self.past.remove(0);
            }
            self.past.push(before);
        }
        // Texts that were undone belong to the former course of changes.
        self.future.clear();
        self.gesture = gesture;
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
