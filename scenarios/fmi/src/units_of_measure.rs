//! Units of measure in terms of SI, as a description states them.

/// A unit: exponents of base units, and the factor to them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BaseUnit {
    pub(crate) m: i32,
    pub(crate) s: i32,
    pub(crate) rad: i32,
    pub(crate) factor: f64,
}

/// The base of a unit; none for one of a user's own, as `u` or `pieces`.
pub(crate) fn base_of(unit: &str) -> Option<BaseUnit> {
    let mut parts = unit.split('/');
    let mut base = simple(parts.next()?)?;
    for below in parts {
        let (below, power) = match below.strip_suffix('²') {
            Some(below) => (below, 2),
            None => (below, 1),
        };
        let below = simple(below)?;
        base.m -= power * below.m;
        base.s -= power * below.s;
        base.rad -= power * below.rad;
        base.factor /= below.factor.powi(power);
    }
    Some(base)
}

fn simple(unit: &str) -> Option<BaseUnit> {
    let [length, time, angle, none] = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]];
    let ([m, s, rad], factor) = match unit {
        "m" => (length, 1.0),
        "cm" => (length, 1e-2),
        "mm" => (length, 1e-3),
        "µm" | "um" => (length, 1e-6),
        "in" => (length, 0.0254),
        "s" => (time, 1.0),
        "ms" => (time, 1e-3),
        "µs" => (time, 1e-6),
        "ns" => (time, 1e-9),
        "rad" => (angle, 1.0),
        "°" | "deg" => (angle, core::f64::consts::PI / 180.0),
        "ppm" => (none, 1e-6),
        _ => return None,
    };
    Some(BaseUnit { m, s, rad, factor })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_motion_have_their_base() {
        let base = |m, s, rad, factor| Some(BaseUnit { m, s, rad, factor });
        assert_eq!(base_of("mm/s²"), base(1, -2, 0, 1e-3));
        assert_eq!(
            base_of("°/s"),
            base(0, -1, 1, core::f64::consts::PI / 180.0)
        );
        assert_eq!(base_of("ns"), base(0, 1, 0, 1e-9));
        // A root has none.
        for unit in ["u", "u/s", "ppm/√s", "pieces", ""] {
            assert_eq!(base_of(unit), None, "{unit}");
        }
    }
}
