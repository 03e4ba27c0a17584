//! Names of the far axes: each leads to one axis.

use std::collections::BTreeSet;

use coaxle_node::config::Wrong;

use super::ReceiverConfig;

/// Checks that no two far axes share a name, and that none is called by node and id of another: these are always accepted as
/// well.
pub(super) fn check_names(config: &ReceiverConfig) -> Result<(), Wrong> {
    let mut names = config.far_axis_names();
    // Sorted, equal names are neighbours.
    names.sort_unstable();
    if let Some(pair) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        let received = format!("the name {:?} for two axes", pair[0]);
        return Err(Wrong::of("far", received, "one of its own for each"));
    }
    let full_names = config
        .far_axes()
        .map(|(_, far, axis)| far.full_name(axis.id));
    let full_names: BTreeSet<String> = full_names.collect();
    for (_, far, axis) in config.far_axes() {
        let (name, own) = (far.axis_name(axis), far.full_name(axis.id));
        if name != own && full_names.contains(&name) {
            let received = format!(
                "the name {name:?} for the axis {own:?}, which means another axis by node and id"
            );
            return Err(Wrong::of("far", received, "a name of its own"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::MasterRef;

    fn config(axes: &str, master: &str) -> Result<ReceiverConfig, String> {
        let text = format!(
            "name = 'r'\ncycle-time-us = 1000\n[[far]]\nnode = 'a'\naxes = {axes}\n[[far]]\nnode = 'b'\n\
             [[slave]]\nname = 's'\nmaster = '{master}'"
        );
        coaxle_node::config::parse("r.toml", &text).map_err(|error| error.to_string())
    }

    #[test]
    fn node_and_id_lead_to_that_axis_alone() {
        for (axes, name, axis) in [
            // Wherever the named axis is in the list.
            (
                "[{ id = 1, name = 'a.2' }, { id = 2, name = 'x' }]",
                "a.2",
                "a.1",
            ),
            (
                "[{ id = 2, name = 'x' }, { id = 1, name = 'a.2' }]",
                "a.2",
                "a.1",
            ),
            ("[{ id = 1, name = 'b.1' }]", "b.1", "a.1"),
            (
                "[{ id = 1, name = 'a.2' }, { id = 2, name = 'a.1' }]",
                "a.2",
                "a.1",
            ),
        ] {
            let error = config(axes, "b.1").expect_err("refused");
            assert!(error.contains(&format!("{name:?}")), "{axes}: {error}");
            if name != "b.1" {
                let expected = format!(
                    "far: received the name {name:?} for the axis {axis:?}, which means another axis by node and \
                     id, expected a name of its own"
                );
                assert!(error.contains(&expected), "{axes}: {error}");
            }
        }
    }

    #[test]
    fn an_axis_may_be_called_by_its_own_node_and_id_or_by_those_of_none() {
        for (name, master, expected) in [("a.1", "a.1", 0), ("a.3", "a.3", 0), ("c.1", "a.2", 1)] {
            let axes = format!("[{{ id = 1, name = '{name}' }}, 2]");
            let config = config(&axes, master).expect("a config");
            assert_eq!(config.master_of(0), Ok(MasterRef::Far(expected)), "{name}");
        }
    }
}
