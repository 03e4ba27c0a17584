//! Messages of a node that waits for another one.

use coaxle_clock::Span;
use coaxle_node::guess::did_you_mean;
use coaxle_node::keys::NodeName;

/// Text on the time since the last arrival.
pub(crate) fn last_came(age: Option<Span>, running: Span) -> String {
    let seconds = |span: Span| span.as_secs_f64();
    // Tenths of a second: the status comes every quarter.
    match age {
        Some(age) => format!("the last one came {:.1} s ago", seconds(age)),
        None => format!("none came in {:.1} s", seconds(running)),
    }
}

/// Text on the visible nodes instead of the missing one, whose name may be misspelt.
pub(crate) fn others(missing: &NodeName, names: &[String]) -> String {
    let meant = || did_you_mean(missing.as_str(), names.iter().map(String::as_str));
    match names {
        [] => String::new(),
        names => format!("; it sees {}{}", names.join(", "), meant()),
    }
}

/// Text on the axes received instead of the followed ones.
pub(crate) fn other_axes(ids: &[u32]) -> String {
    let ids: Vec<_> = ids.iter().map(u32::to_string).collect();
    match ids.as_slice() {
        [] => String::new(),
        [one] => format!(": it has axis {one}, and none of those that are followed"),
        ids => format!(
            ": it has the axes {}, and none of those that are followed",
            ids.join(", ")
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_waits_says_since_when_nothing_came_and_who_is_there() {
        let second = Span::from_secs(1);
        assert_eq!(last_came(None, second * 12), "none came in 12.0 s");
        let age = Some(Span::from_millis(2_340));
        assert_eq!(last_came(age, second), "the last one came 2.3 s ago");
        let missing = NodeName::new("conveior").unwrap();
        assert_eq!(others(&missing, &[]), "");
        let names = ["conveyor", "press"].map(str::to_owned);
        assert_eq!(
            others(&missing, &names),
            "; it sees conveyor, press; did you mean \"conveyor\"?"
        );
    }
}
