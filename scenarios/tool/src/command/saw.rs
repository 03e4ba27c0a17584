//! A response's figures of a flying saw, for people.

use coaxle_node::command::{SawFigures, SawRefused};
use coaxle_report::inspect::{name, shown};

use crate::sync_flags::any_of;

/// Figures of an accepted synchronisation.
pub(super) fn accepted(saw: &SawFigures) -> String {
    let duration = saw.duration.map_or_else(
        || "for as long as the master stands".to_owned(),
        |duration| format!("{} s", shown(duration)),
    );
    let mut words = format!(
        "; {}, {duration}, synchronous with the master at {}, the slave at {}; at most velocity {}, \
         acceleration {}, jerk {}",
        name(&saw.form),
        shown(saw.master_sync_position),
        shown(saw.slave_sync_position),
        shown(saw.peak_velocity),
        shown(saw.peak_acceleration),
        shown(saw.peak_jerk),
    );
    for value in saw.characteristics.iter().flatten() {
        words += &format!("\n{} = {}", value.name, shown(value.value));
    }
    if let Some(table) = &saw.table {
        words += &format!(
            "\ntable {}: {}, rows {}, columns {}",
            table.id,
            name(&table.table_type),
            table.rows,
            table.columns
        );
    }
    words
}

/// Values that would pass.
pub(super) fn refused(saw: &SawRefused) -> String {
    let distance = saw.remedy.master_distance.map(|distance| {
        format!(
            "; would pass with the master {distance} before its synchronisation position instead"
        )
    });
    let speed = saw
        .remedy
        .master_speed
        .map(|speed| format!("; would pass with the master at most {speed} fast"));
    let flags = (!saw.remedy.flags.is_empty()).then(|| {
        format!(
            "; would pass with {} in the mask too",
            any_of(saw.remedy.flags)
        )
    });
    let strategy = saw
        .remedy
        .strategy
        .map(|strategy| format!("; would pass with strategy {}", name(&strategy)));
    [distance, speed, flags, strategy]
        .into_iter()
        .flatten()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use coaxle_node::command::NamedValue;
    use coaxle_saw::{SawForm, SawRemedy, SyncMask, SyncStrategy};

    #[test]
    fn what_a_saw_comes_to_is_said() {
        let saw = SawFigures {
            form: SawForm::QuinticLine,
            duration: Some(3.0),
            master_sync_position: 1000.0,
            slave_sync_position: 900.0,
            peak_velocity: 500.0,
            peak_acceleration: 187.5,
            peak_jerk: 375.0,
            characteristics: None,
            table: None,
        };
        let expected = "; quintic-line, 3 s, synchronous with the master at 1000, the slave at 900; \
                        at most velocity 500, acceleration 187.5, jerk 375";
        assert_eq!(accepted(&saw), expected);
        let standing = SawFigures {
            duration: None,
            characteristics: Some(vec![NamedValue {
                name: "fMasterVeloNom".to_owned(),
                value: 0.0,
            }]),
            ..saw
        };
        let words = accepted(&standing);
        assert!(
            words.contains("for as long as the master stands"),
            "{words}"
        );
        assert!(words.ends_with("\nfMasterVeloNom = 0"), "{words}");
    }

    #[test]
    fn what_would_pass_is_said() {
        let remedy = SawRemedy {
            master_distance: Some(120.5),
            master_speed: Some(80.0),
            ..SawRemedy::default()
        };
        let refusal = SawRefused {
            violation: None,
            remedy,
        };
        let words = refused(&refusal);
        assert!(words.contains("the master 120.5 before"), "{words}");
        assert!(words.ends_with("at most 80 fast"), "{words}");
        let refusal = SawRefused {
            violation: None,
            remedy: SawRemedy {
                flags: SyncMask::PREFER_CONST_VELO | SyncMask::MAX_VELO,
                strategy: Some(SyncStrategy::Slow),
                ..SawRemedy::default()
            },
        };
        assert_eq!(
            refused(&refusal),
            "; would pass with max-velo or prefer-const-velo in the mask too; would pass with \
             strategy slow"
        );
    }
}
