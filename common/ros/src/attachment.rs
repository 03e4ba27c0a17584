//! The attachment that rmw_zenoh adds to the payload of each sample: without it a subscriber of ROS
//! complains.

/// The attachment of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// Sequence number of the sample at its publisher, from 1 on.
    pub sequence: i64,
    /// Time of publication, ns since 1970.
    pub published: i64,
    /// Gid of the publisher.
    pub gid: [u8; 16],
}

/// Length of an attachment, bytes.
pub const ATTACHMENT_BYTES: usize = 8 + 8 + 1 + 16;

impl Attachment {
    /// Writes the format of rmw_zenoh since ROS 2 Jazzy's 0.2.4: the numbers with their low bytes first,
    /// and the length of the gid before it.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; ATTACHMENT_BYTES] {
        let mut bytes = [0; ATTACHMENT_BYTES];
        bytes[..8].copy_from_slice(&self.sequence.to_le_bytes());
        bytes[8..16].copy_from_slice(&self.published.to_le_bytes());
        // A sequence in CDR begins with its length; 16 fits one byte.
        bytes[16] = self.gid.len() as u8;
        bytes[17..].copy_from_slice(&self.gid);
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_has_33_bytes_in_order() {
        let attachment = Attachment {
            sequence: 1,
            published: 0x0102,
            gid: [7; 16],
        };
        let mut expected = vec![1, 0, 0, 0, 0, 0, 0, 0, 2, 1, 0, 0, 0, 0, 0, 0, 16];
        expected.extend([7; 16]);
        assert_eq!(attachment.to_bytes().as_slice(), expected);
    }
}
