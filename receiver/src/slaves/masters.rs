//! The masters of one slave, in one cycle.

use coaxle_axis::Masters;

use super::Master;
use crate::config::MasterRef;

/// What leads a slave in a cycle, by the number of the master; none where there is nothing of it yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct SlaveMasters {
    all: [Option<Master>; Masters::MOST],
    count: usize,
}

impl SlaveMasters {
    /// Those that these mean.
    pub(super) fn of(
        sources: &[MasterRef],
        mut master: impl FnMut(MasterRef) -> Option<Master>,
    ) -> Self {
        let mut all = [None; Masters::MOST];
        for (place, source) in all.iter_mut().zip(sources) {
            *place = master(*source);
        }
        let count = sources.len();
        Self { all, count }
    }

    /// The master of everything that has but one.
    pub(super) const fn first(&self) -> Option<&Master> {
        self.all[0].as_ref()
    }

    /// All of them are there, without an error, and their clocks are known.
    pub(super) fn are_ready(&self) -> bool {
        let mut all = self.all.iter().take(self.count);
        all.all(|master| master.is_some_and(|master| master.is_ready))
    }

    /// All that there is anything of, be it lost or in error.
    pub(super) fn all(&self) -> Masters {
        as_couplings_see(self.all)
    }

    /// As couplings see them: none where one is lost or in error.
    pub(super) fn sound(&self) -> Masters {
        as_couplings_see(self.all.map(|master| master.filter(|one| one.is_sound)))
    }
}

fn as_couplings_see(all: [Option<Master>; Masters::MOST]) -> Masters {
    Masters::of(all.map(|master| Some(master?.set))).going(all.map(|master| master?.travel))
}
