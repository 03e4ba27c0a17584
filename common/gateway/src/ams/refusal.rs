//! Errors of an ADS device that refuses a request.

use std::fmt;

/// An error code of ADS. `0x710`, say, is a symbol that the PLC does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AdsRefusal(pub u32);

/// Errors that a gateway meets, in our own words. The others are in Beckhoff's list of ADS return codes.
const KNOWN: [(u32, &str); 12] = [
    (0x006, "no PLC at this AMS port"),
    (
        0x007,
        "the router knows no such AMS net id, or has no route back to this PC",
    ),
    (0x01e, "access denied"),
    (0x701, "not supported by the PLC"),
    (0x702, "wrong index group"),
    (0x703, "wrong index offset"),
    (0x704, "reading or writing is not permitted"),
    (0x705, "the variable has another length"),
    (0x706, "wrong value"),
    (0x707, "the PLC is not ready"),
    (0x710, "the PLC has no such symbol"),
    (0x711, "the PLC program has changed"),
];

impl fmt::Display for AdsRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let known = KNOWN.iter().find(|(code, _)| *code == self.0);
        let text = known.map_or("see Beckhoff's ADS return codes", |(_, text)| text);
        write!(f, "ADS error {:#x}: {text}", self.0)
    }
}

impl std::error::Error for AdsRefusal {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_told_with_what_they_mean() {
        let text = AdsRefusal(0x710).to_string();
        assert_eq!(text, "ADS error 0x710: the PLC has no such symbol");
        let text = AdsRefusal(0x1234).to_string();
        assert_eq!(text, "ADS error 0x1234: see Beckhoff's ADS return codes");
    }
}
