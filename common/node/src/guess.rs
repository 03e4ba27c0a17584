//! Suggestions for an unknown name.

/// `; did you mean "conveyor"?` if one of the known names is similar to the received one, otherwise
/// empty.
#[must_use]
pub fn did_you_mean<'n>(received: &str, known: impl IntoIterator<Item = &'n str>) -> String {
    match most_similar(received, known) {
        Some(name) => format!("; did you mean {name:?}?"),
        None => String::new(),
    }
}

/// The most similar of the known names, if one is similar enough.
#[must_use]
pub fn most_similar<'n>(
    received: &str,
    known: impl IntoIterator<Item = &'n str>,
) -> Option<&'n str> {
    // Jaro and Winkler for swapped letters and common beginnings, Damerau and Levenshtein for the rest.
    let likeness = |name: &&str| {
        let (name, received) = (name.to_lowercase(), received.to_lowercase());
        strsim::jaro_winkler(&name, &received)
            .max(strsim::normalized_damerau_levenshtein(&name, &received))
    };
    let alike = known
        .into_iter()
        // The name itself is no suggestion.
        .filter(|name| !name.is_empty() && *name != received)
        .map(|name| (likeness(&name), name))
        .filter(|(likeness, _)| *likeness > LEAST_LIKENESS);
    // `total_cmp`: similarities are finite, but floats have no order of their own.
    let most = alike.max_by(|(a, _), (b, _)| a.total_cmp(b));
    most.map(|(_, name)| name)
}

/// Least similarity of two names for a suggestion, 0 to 1; as in clap.
const LEAST_LIKENESS: f64 = 0.8;
