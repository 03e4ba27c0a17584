//! Units of signals as OPC UA has them: codes of UNECE Recommendation 20.

/// Namespace of the codes.
pub const UNIT_NAMESPACE: &str = "http://www.opcfoundation.org/UA/units/un/cefact";

/// Units with a code, as signals and axes spell them.
// Part 8 of OPC UA, annex A: the code's characters are the bytes of the id.
const CODES: [(&str, &str); 30] = [
    ("m", "MTR"),
    ("cm", "CMT"),
    ("mm", "MMT"),
    ("µm", "4H"),
    ("nm", "C45"),
    ("in", "INH"),
    ("inch", "INH"),
    ("ft", "FOT"),
    ("°", "DD"),
    ("deg", "DD"),
    ("rad", "C81"),
    ("s", "SEC"),
    ("ms", "C26"),
    ("µs", "B98"),
    ("ns", "C47"),
    ("min", "MIN"),
    ("h", "HUR"),
    ("m/s", "MTS"),
    ("mm/s", "C16"),
    ("m/s²", "MSK"),
    ("mm/s²", "M41"),
    ("°/s", "E96"),
    ("deg/s", "E96"),
    ("rad/s", "2A"),
    ("rad/s²", "2B"),
    ("m/min", "2X"),
    ("%", "P1"),
    ("ppm", "59"),
    ("Hz", "HTZ"),
    ("rev", "M44"),
];

/// Id of a unit without a code.
const NO_ID: i32 = -1;

/// Id of a unit; -1 if it has no code, so that its name alone counts.
///
/// ```
/// // "MMT": 0x4d4d54.
/// assert_eq!(coaxle_opcua::unit::unit_id("mm"), 5_066_068);
/// assert_eq!(coaxle_opcua::unit::unit_id("pcs/s"), -1);
/// ```
#[must_use]
pub fn unit_id(unit: &str) -> i32 {
    let code = CODES.iter().find(|(name, _)| *name == unit);
    code.map_or(NO_ID, |(_, code)| {
        code.bytes().fold(0, |id, byte| (id << 8) | i32::from(byte))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_those_of_the_standard() {
        // Examples of part 8.
        assert_eq!(unit_id("s"), 5_457_219);
        assert_eq!(unit_id("°"), 17_476);
        assert_eq!(unit_id("m/s"), 5_067_859);
        assert_eq!(unit_id("u"), -1);
    }
}
