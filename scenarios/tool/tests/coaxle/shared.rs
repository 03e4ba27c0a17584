//! Helpers of the tool's tests.

use std::path::{Path, PathBuf};

use coaxle_os::ClaimedPort;

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[allow(dead_code, reason = "not every test of the tool writes files")]
pub(crate) fn written(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let file = folder.join(name);
    std::fs::write(&file, bytes).expect("the folder can be written");
    file
}

/// An endpoint that nobody else is given while these tests run.
pub(crate) fn free_endpoint() -> String {
    let port = ClaimedPort::find().expect("a free port").keep();
    format!("tcp/127.0.0.1:{port}")
}
