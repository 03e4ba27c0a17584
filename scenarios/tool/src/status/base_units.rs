//! Names and units of metrics, as Prometheus recommends them: seconds and ratios, `_total` behind what is counted.

/// Ends of names with a unit, what Prometheus has instead, its unit, and its value of one of the former.
const UNITS: [(&str, &str, &str, f64); 5] = [
    ("_ns", "_seconds", "s", 1e-9),
    ("_us", "_seconds", "s", 1e-6),
    ("_ms", "_seconds", "s", 1e-3),
    ("_ppm", "_ratio", "", 1e-6),
    ("_s", "_seconds", "s", 1.0),
];

/// Whole numbers that do not only grow: codes, places, states and ages.
const NOT_COUNTED: [&str; 12] = [
    "age_cycles",
    "consecutive_equal_data",
    "cycle",
    "error",
    "id",
    "index",
    "program_step",
    "received_error",
    "refusal",
    "run",
    "waiting",
    "warning",
];

/// A metric of a signal.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MetricName {
    /// Name of the metric.
    pub(super) name: String,
    /// Unit of the metric; none if it is that of the signal.
    pub(super) unit: Option<&'static str>,
    /// Value of the metric where that of the signal is 1.
    pub(super) scale: f64,
    /// True if it only grows, but for restarts of the node.
    pub(super) is_counter: bool,
}

impl MetricName {
    /// The metric of a signal; `counts` for whole numbers from 0.
    pub(super) fn of(signal: &str, counts: bool) -> Self {
        let converted = UNITS.iter().find_map(|&(end, base, unit, scale)| {
            let stem = signal.strip_suffix(end)?;
            Some(Self {
                name: format!("{stem}{base}"),
                unit: Some(unit),
                scale,
                is_counter: false,
            })
        });
        if let Some(converted) = converted {
            return converted;
        }
        let is_counter = counts && !NOT_COUNTED.contains(&signal);
        let end = if is_counter { "_total" } else { "" };
        Self {
            name: format!("{signal}{end}"),
            unit: None,
            scale: 1.0,
            is_counter,
        }
    }
}
