//! HKDF with SHA-256 (RFC 5869): keys derived from a secret.

use hmac::{Hmac, Mac};
use sha2::Sha256;

/// Length of a derived key, in bytes: that of the hash.
const HASH_LEN: usize = 32;

/// Fills `out` with the key of this purpose. At most 255 hashes can be derived; ours takes one.
pub(super) fn derive(salt: &[u8], secret: &[u8], info: &[u8], out: &mut [u8]) {
    let pseudorandom = mac(salt, &[secret]);
    // T(n) = HMAC(PRK, T(n - 1) | info | n): section 2.3.
    let mut block: [u8; HASH_LEN] = [0; HASH_LEN];
    let mut known = 0;
    for (part, number) in out.chunks_mut(HASH_LEN).zip(1_u8..=u8::MAX) {
        block = mac(&pseudorandom, &[&block[..known], info, &[number]]);
        known = HASH_LEN;
        part.copy_from_slice(&block[..part.len()]);
    }
}

fn mac(key: &[u8], parts: &[&[u8]]) -> [u8; HASH_LEN] {
    let mut mac = Hmac::<Sha256>::new_from_slice(key).expect("a key of any length will do");
    for part in parts {
        mac.update(part);
    }
    mac.finalize().into_bytes().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(hex: &str) -> Vec<u8> {
        let digits = |at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap();
        (0..hex.len()).step_by(2).map(digits).collect()
    }

    #[test]
    fn the_test_vectors_of_the_rfc_are_met() {
        let range = |from: u8, to: u8| (from..=to).collect::<Vec<_>>();
        // RFC 5869, A.1 to A.3: input, salt, info, output.
        let cases = [
            (
                vec![0x0b; 22],
                range(0x00, 0x0c),
                range(0xf0, 0xf9),
                "3cb25f25faacd57a90434f64d0362f2a2d2d0a90cf1a5a4c5db02d56ecc4c5bf34007208d5b887185865",
            ),
            (
                range(0x00, 0x4f),
                range(0x60, 0xaf),
                range(0xb0, 0xff),
                "b11e398dc80327a1c8e7f78c596a49344f012eda2d4efad8a050cc4c19afa97c59045a99cac7827271cb41c65e590e09da3275600c2f09b8367793a9aca3db71cc30c58179ec3e87c14c01d5c1f3434f1d87",
            ),
            (
                vec![0x0b; 22],
                Vec::new(),
                Vec::new(),
                "8da4e775a563c18f715f802a063c5a31b8a11f5c5ee1879ec3454e5f3c738d2d9d201395faa4b61a96c8",
            ),
        ];
        for (secret, salt, info, expected) in cases {
            let expected = bytes(expected);
            let mut out = vec![0; expected.len()];
            derive(&salt, &secret, &info, &mut out);
            assert_eq!(out, expected);
        }
    }
}
