//! The list of a running node: read again when its file changes.

use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, SystemTime};

use tokio::time::Instant;

use super::list::{MOST_LIST_BYTES, REVOKED_FILE, RevocationList};
use crate::events;

/// Interval between two looks at the file.
const LOOK: Duration = Duration::from_secs(1);

/// The newest list beside the certificate of an authority.
#[derive(Debug)]
pub struct RevocationWatch {
    authority: PathBuf,
    file: PathBuf,
    seen: Mutex<SeenFiles>,
}

#[derive(Debug, Default)]
struct SeenFiles {
    looked: Option<Instant>,
    modified: Option<SystemTime>,
    list: Arc<RevocationList>,
}

impl RevocationWatch {
    /// Watches the list beside the file with the certificate of the authority.
    #[must_use]
    pub fn beside(authority: &Path) -> Self {
        Self {
            authority: authority.to_owned(),
            file: authority.with_file_name(REVOKED_FILE),
            seen: Mutex::default(),
        }
    }

    /// Returns the newest list. Looks at the file once a second at most. A list that is removed, damaged or of
    /// somebody else changes nothing: what was revoked stays revoked.
    #[must_use]
    pub fn list(&self) -> Arc<RevocationList> {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        if seen.looked.is_none_or(|looked| now - looked >= LOOK) {
            seen.looked = Some(now);
            self.look(&mut seen);
        }
        Arc::clone(&seen.list)
    }

    fn look(&self, seen: &mut SeenFiles) {
        // Most networks have revoked nothing, and so have no such file.
        let modified = fs::metadata(&self.file).and_then(|facts| facts.modified());
        let Ok(modified) = modified else {
            return;
        };
        if seen.modified == Some(modified) {
            return;
        }
        seen.modified = Some(modified);
        match self.read() {
            // An older list may come with an older copy of the folder.
            Ok(list) if list.number >= seen.list.number => seen.list = Arc::new(list),
            Ok(list) => self.complain(&format!(
                "received list {}, expected a later one than {}, which is obeyed still",
                list.number, seen.list.number
            )),
            Err(error) => self.complain(&format!("{error}; the last one is obeyed still")),
        }
    }

    fn read(&self) -> Result<RevocationList, String> {
        let text = |file: &Path| {
            let mut text = String::new();
            let opened = fs::File::open(file).map_err(|error| error.to_string())?;
            // One more, so that a longer file is seen to be one.
            let read = opened.take(MOST_LIST_BYTES + 1).read_to_string(&mut text);
            match read.map_err(|error| error.to_string())? as u64 {
                0..=MOST_LIST_BYTES => Ok(text),
                _ => Err(format!(
                    "received more than {MOST_LIST_BYTES} bytes, expected at most that"
                )),
            }
        };
        let list = RevocationList::read_pem(&text(&self.file)?, &text(&self.authority)?);
        list.map_err(|error| error.to_string())
    }

    fn complain(&self, error: &str) {
        tracing::error!(target: events::LOG, "{}: {error}", self.file.display());
    }
}
