//! Units and plates in words.

use coaxle_files::cam::CamFile;
use coaxle_plate::{Course, Plate, TableType};
use coaxle_report::inspect::{QUANTITIES, shown};

/// The unit of one of the [`QUANTITIES`].
pub(super) fn unit(cam: &CamFile, quantity: usize) -> String {
    let CamFile {
        master_unit: master,
        slave_unit: slave,
        ..
    } = cam;
    match quantity {
        0 => slave.clone(),
        1 => format!("{slave}/{master}"),
        2 => format!("{slave}/{master}²"),
        _ => format!("{slave}/{master}³"),
    }
}

/// The name of such a value with its unit.
pub(super) fn heading(cam: &CamFile, quantity: usize) -> String {
    format!("{} ({})", QUANTITIES[quantity], unit(cam, quantity))
}

/// The name of the master with its unit.
pub(super) fn master_heading(cam: &CamFile) -> String {
    format!("master ({})", cam.master_unit)
}

/// A plate in a few words.
pub(super) fn description(cam: &CamFile, plate: &Plate) -> String {
    let rows = plate.rows();
    let kind = match plate.table_type() {
        TableType::MotionFunction => format!("motion function of {rows} points"),
        TableType::Equidistant => format!("equidistant table of {rows} rows"),
        TableType::NonEquidistant => format!("non-equidistant table of {rows} rows"),
    };
    let (start, end) = plate.master_range();
    let (start, end) = (shown(start), shown(end));
    let range = format!("master {start} to {end} {}", cam.master_unit);
    match (plate.course(), plate.lift()) {
        (Course::Linear, _) => format!("{kind}, linear, {range}"),
        // `lift` is exactly 0 for a closed plate: rounding is taken out of it.
        (Course::Cyclic, 0.0) => format!("{kind}, cyclic, {range}"),
        (Course::Cyclic, lift) => {
            let lift = shown(lift);
            format!("{kind}, cyclic, {range}, lift {lift} {}", cam.slave_unit)
        }
    }
}

/// Place of the largest velocity step of the slave and the number of steps; none without steps.
pub(super) fn velocity_steps(cam: &CamFile, plate: &Plate) -> Option<String> {
    // The largest one stands for all: a table with linear interpolation steps at every row.
    let largest = plate.largest_velocity_step()?;
    let number = plate.velocity_steps().count();
    let places = if number == 1 {
        "1 place".to_owned()
    } else {
        format!("{number} places, most")
    };
    Some(format!(
        "the velocity steps at {places} at master {} {}, from {} to {} {}",
        shown(largest.master),
        cam.master_unit,
        shown(largest.before),
        shown(largest.after),
        unit(cam, 1)
    ))
}

/// A number on the command line.
pub(super) fn parse_finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        // Rust reads `inf` and `nan` as numbers.
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err("expected a finite number".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_finite_numbers_are_taken() {
        assert_eq!(parse_finite("-1.5e3"), Ok(-1500.0));
        for text in ["", "x", "nan", "inf", "1e999", "1,5"] {
            assert!(parse_finite(text).is_err(), "{text}");
        }
    }
}
