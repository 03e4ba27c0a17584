//! Keys of the timing channels of a node.

use std::path::{Path, PathBuf};

use coaxle_node::beacon::{PairKeys, TimingSecret};
use coaxle_node::keys::NodeName;
use coaxle_node::text_file::{self, MOST_CONFIG_BYTES};

use super::{BadCredentials, PROFILE_FILE};

/// Keys that authenticate the beacons of timing channels, one for each other node that this one follows or is
/// followed by.
pub const TIMING_KEYS_FILE: &str = "timing.keys";

/// Secret that earlier versions gave to every node of a network.
pub const OLD_TIMING_KEY_FILE: &str = "timing.key";

/// Greatest length of the files, bytes.
// A key has at most 64 + 20 + 64 characters: those of some six thousand nodes.
const MOST_KEY_BYTES: u64 = 1 << 20;

/// Keys of a folder.
#[derive(Clone, Debug)]
pub struct TimingKeys {
    /// The keys.
    pub keys: PairKeys,
    /// True for a folder of an earlier version, whose secret is that of all pairs.
    pub from_shared_secret: bool,
}

/// Returns the keys of a node; none in a folder without any. A folder of an earlier version has the secret of the
/// whole network, from which the keys are derived: of the pairs with `followed`, and with those that its profile
/// names as followers.
///
/// # Errors
/// [`BadCredentials`] names the file that has no keys or cannot be read.
pub fn timing_keys<'a>(
    folder: &Path,
    own: &NodeName,
    followed: impl IntoIterator<Item = &'a NodeName>,
) -> Result<Option<TimingKeys>, BadCredentials> {
    if let Some((file, text)) = read(folder, TIMING_KEYS_FILE)? {
        let keys = PairKeys::from_text(&text);
        let keys = keys.map_err(|error| BadCredentials::new(file, error))?;
        return Ok(Some(TimingKeys {
            keys,
            from_shared_secret: false,
        }));
    }
    let Some((file, text)) = read(folder, OLD_TIMING_KEY_FILE)? else {
        return Ok(None);
    };
    let secret = TimingSecret::from_hex(&text);
    let secret = secret.map_err(|error| BadCredentials::new(file, error))?;
    let others: Vec<_> = followed
        .into_iter()
        .cloned()
        .chain(followers(folder, own))
        .collect();
    Ok(Some(TimingKeys {
        keys: PairKeys::derived(&secret, own, &others),
        from_shared_secret: true,
    }))
}

/// Followers of a node by the rules of its profile, which let each announce that it sees the node.
fn followers(folder: &Path, own: &NodeName) -> Vec<NodeName> {
    let text = text_file::read(&folder.join(PROFILE_FILE), MOST_CONFIG_BYTES).unwrap_or_default();
    let announced = format!("coaxle/{own}/seen-by/");
    let quoted = text
        .split('"')
        .filter_map(|word| word.strip_prefix(&announced));
    // The wildcard of the node's own subscription is no name.
    quoted.filter_map(|name| NodeName::new(name).ok()).collect()
}

fn read(folder: &Path, name: &str) -> Result<Option<(PathBuf, String)>, BadCredentials> {
    let file = folder.join(name);
    if !file.exists() {
        return Ok(None);
    }
    match text_file::read(&file, MOST_KEY_BYTES) {
        Ok(text) => Ok(Some((file, text))),
        Err(error) => Err(BadCredentials::new(file, error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_of_an_earlier_version_has_the_keys_of_all_pairs() {
        let folder = tempfile::tempdir().unwrap();
        let (saw, line) = (
            NodeName::new("saw").unwrap(),
            NodeName::new("line").unwrap(),
        );
        let keys = || timing_keys(folder.path(), &saw, [&line]);
        assert!(keys().unwrap().is_none());
        let secret = TimingSecret::new([3; 32]);
        std::fs::write(folder.path().join(OLD_TIMING_KEY_FILE), secret.to_hex()).unwrap();
        // A rule of the profile names a follower.
        let rules =
            "[\"coaxle/saw/seen-by/press\", \"coaxle/saw/seen-by/*\", \"coaxle/line/seen-by/saw\"]";
        std::fs::write(folder.path().join(PROFILE_FILE), rules).unwrap();
        let old = keys().unwrap().unwrap();
        let press = NodeName::new("press").unwrap();
        assert!(old.from_shared_secret && old.keys.of(&line).is_some());
        assert!(old.keys.of(&press).is_some() && old.keys.of(&saw).is_none());
        let file = folder.path().join(TIMING_KEYS_FILE);
        std::fs::write(
            &file,
            PairKeys::line(&line, 0, &secret.pair(&line, &saw, 0)),
        )
        .unwrap();
        let new = keys().unwrap().unwrap();
        assert!(!new.from_shared_secret && new.keys.of(&line).is_some());
        std::fs::write(&file, "line 0 secret").unwrap();
        let error = keys().unwrap_err().to_string();
        assert!(
            error.contains("timing.keys") && error.contains("line 1"),
            "{error}"
        );
    }
}
