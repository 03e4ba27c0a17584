//! The flags of a sync mode in words.

use coaxle_saw::SyncMask;

/// Returns the flags as files spell them, joined by "or": one of them is enough.
pub(crate) fn any_of(flags: SyncMask) -> String {
    flags.iter().map(flag_name).collect::<Vec<_>>().join(" or ")
}

/// A flag as files spell it.
pub(crate) fn flag_name(flag: SyncMask) -> String {
    // A mask is a list of names in files, and that of a single flag has one.
    let names: Vec<String> = serde_json::to_value(flag)
        .and_then(serde_json::from_value)
        .unwrap_or_default();
    names.concat()
}
