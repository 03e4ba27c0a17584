//! The timing channel of a node in a secure network.

use std::net::SocketAddr;
use std::path::Path;

use coaxle_node::audit::{AuditDoor, AuditEntry, AuditOutcome};
use coaxle_node::beacon::PairKeys;

use crate::network::credentials::{AUTHORITY_FILE, RevocationWatch};
use crate::node::audit;

/// Keys of the pairs, and the list of those that are revoked.
pub(crate) struct SecuredBeacons {
    keys: PairKeys,
    revoked: RevocationWatch,
    /// Number of the list that the keys obey.
    obeyed: u64,
}

impl SecuredBeacons {
    /// Takes the keys of a folder.
    pub(crate) fn new(keys: PairKeys, folder: &Path) -> Self {
        let revoked = RevocationWatch::beside(&folder.join(AUTHORITY_FILE));
        let mut secured = Self {
            keys,
            revoked,
            obeyed: 0,
        };
        // Before the first beacon.
        secured.obey();
        secured
    }

    pub(super) const fn keys(&self) -> &PairKeys {
        &self.keys
    }

    /// Withdraws the keys of members that were revoked since the last call.
    pub(super) fn obey(&mut self) {
        let list = self.revoked.list();
        if list.number == self.obeyed {
            return;
        }
        self.obeyed = list.number;
        for (name, before) in &list.before {
            // Copies of the key are in the seals of both directions, and are withdrawn with it.
            self.keys.withdraw(name, *before);
        }
    }

    /// Notes a beacon that was refused.
    pub(super) fn note_refused(from: SocketAddr) {
        let from = from.to_string();
        let entry = AuditEntry::new(
            AuditDoor::Beacon,
            Some(&from),
            "beacon",
            AuditOutcome::Refused,
        );
        audit::note(&entry.because("it is not authenticated by the key of a pair with this node"));
    }
}
