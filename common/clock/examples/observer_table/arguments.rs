//! The command line.

use std::path::PathBuf;

use crate::{cases, details};

pub(crate) const USAGE: &str = "\
usage: observer_table [--seeds N] [--first-seed N] [--recorded DIR] [GROUP...]
       observer_table SEEDS [FIRST-SEED [DETAIL...]]

The first form prints a table of the observer beside simple methods.
  GROUP         independent correlated drift steps load busy cycles recorded; all if none is told
  --seeds       runs of each case (10). The first run of a recording drifts by 10 ppm, further ones by
                1 to 100 ppm
  --first-seed  seed of the first run (1)
  --recorded    a directory of recordings instead of the repository's own

The second form prints more figures of the generated cases.
  DETAIL        cases unordered steps peers hour load busy other; all if none is told";

pub(crate) enum Arguments {
    Help,
    Table(Table),
    Details {
        seeds: u64,
        first_seed: u64,
        words: Vec<String>,
    },
}

pub(crate) struct Table {
    pub(crate) seeds: u64,
    pub(crate) first_seed: u64,
    pub(crate) recorded: PathBuf,
    /// Groups in the order of the table.
    pub(crate) groups: Vec<&'static str>,
}

pub(crate) fn parse(arguments: &[String]) -> Result<Arguments, String> {
    if arguments
        .iter()
        .any(|word| word == "--help" || word == "-h")
    {
        return Ok(Arguments::Help);
    }
    // No group is a number, so the two forms cannot be confused.
    let starts_with_number = arguments.first().is_some_and(|word| number(word).is_ok());
    if starts_with_number {
        parse_details(arguments)
    } else {
        parse_table(arguments).map(Arguments::Table)
    }
}

fn parse_details(arguments: &[String]) -> Result<Arguments, String> {
    let seeds = number(&arguments[0])?;
    let first_seed = arguments.get(1).map_or(Ok(1), |word| number(word))?;
    let words = arguments.get(2..).unwrap_or_default().to_vec();
    for word in &words {
        known(word, &details::WORDS)?;
    }
    Ok(Arguments::Details {
        seeds,
        first_seed,
        words,
    })
}

fn parse_table(arguments: &[String]) -> Result<Table, String> {
    let mut table = Table {
        seeds: 10,
        first_seed: 1,
        recorded: [env!("CARGO_MANIFEST_DIR"), "data", "arrivals"]
            .iter()
            .collect(),
        groups: Vec::new(),
    };
    let mut chosen = Vec::new();
    let mut words = arguments.iter();
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| format!("{word} needs a value"));
        match word.as_str() {
            "--seeds" => table.seeds = number(value()?)?,
            "--first-seed" => table.first_seed = number(value()?)?,
            "--recorded" => table.recorded = value()?.into(),
            group => chosen.push(known(group, &cases::GROUPS)?),
        }
    }
    // In the order of the table and each once, however they were given.
    let groups = cases::GROUPS.into_iter();
    table.groups = groups
        .filter(|group| chosen.is_empty() || chosen.contains(group))
        .collect();
    Ok(table)
}

fn number(word: &str) -> Result<u64, String> {
    let number = word.parse().ok().filter(|number| *number > 0);
    number.ok_or_else(|| format!("{word}: a number above 0 is wanted"))
}

fn known(word: &str, words: &[&'static str]) -> Result<&'static str, String> {
    let found = words.iter().find(|known| **known == word);
    found
        .copied()
        .ok_or_else(|| format!("{word}: not one of {}", words.join(" ")))
}
