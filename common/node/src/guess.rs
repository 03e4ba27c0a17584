//! What may have been meant by a name that nobody has.

/// `; did you mean "conveyor"?` where one of the known names is much like what was received, otherwise nothing.
#[must_use]
pub fn did_you_mean<'n>(received: &str, known: impl IntoIterator<Item = &'n str>) -> String {
    match most_alike(received, known) {
        Some(name) => format!("; did you mean {name:?}?"),
        None => String::new(),
    }
}

/// The one of the known names that is much like what was received, if there is one.
#[must_use]
pub fn most_alike<'n>(received: &str, known: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    let likeness = |name: &&str| {
        let (name, received) = (name.to_lowercase(), received.to_lowercase());
        strsim::jaro_winkler(&name, &received)
            .max(strsim::normalized_damerau_levenshtein(&name, &received))
    };
    let alike = known
        .into_iter()
        .filter(|name| !name.is_empty() && *name != received)
        .map(|name| (likeness(&name), name))
        .filter(|(likeness, _)| *likeness > LEAST_LIKENESS);
    let most = alike.max_by(|(a, _), (b, _)| a.total_cmp(b));
    most.map(|(_, name)| name)
}

/// How much alike two names are, 0 to 1, of which one may have been meant by the other; as clap has it.
const LEAST_LIKENESS: f64 = 0.8;
