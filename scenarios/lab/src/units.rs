//! Units of figures: the axes' unit, where all figures shown together have it.

use coaxle_node::config::Unit;

/// The unit that all of these have; `u` where they differ, or where there is none.
pub fn common<'a>(units: impl IntoIterator<Item = &'a Unit>) -> Unit {
    let mut units = units.into_iter();
    // The default is `u`, which stands for any unit.
    let first = units.next().cloned().unwrap_or_default();
    if units.all(|unit| *unit == first) {
        first
    } else {
        Unit::default()
    }
}

/// Unit of small lengths.
#[derive(Clone, Debug, PartialEq)]
pub struct Fine {
    /// Number of these in a unit of the axis.
    pub factor: f64,
    /// Name of the unit.
    pub unit: String,
}

/// Millimetres and metres have a thousandth with a name of its own; other units stay.
pub fn fine(unit: &Unit) -> Fine {
    let (factor, unit) = match unit.as_str() {
        "mm" => (1e3, "µm"),
        "m" => (1e3, "mm"),
        // A thousandth of a degree or a revolution has no name that everybody knows.
        other => (1.0, other),
    };
    Fine {
        factor,
        unit: unit.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_that_differ_have_none_in_common() {
        let unit = |text| Unit::new(text).unwrap();
        assert_eq!(common(&[unit("mm"), unit("mm")]), unit("mm"));
        assert_eq!(common(&[unit("mm"), unit("°")]), unit("u"));
        assert_eq!(common(&[]), unit("u"));
    }

    #[test]
    fn only_lengths_with_a_named_thousandth_are_shown_in_it() {
        let shown = |text| {
            let Fine { factor, unit } = fine(&Unit::new(text).unwrap());
            (factor, unit)
        };
        assert_eq!(shown("mm"), (1e3, "µm".to_owned()));
        assert_eq!(shown("°"), (1.0, "°".to_owned()));
    }
}
