//! Maps as a page holds them.

use serde_json::{Value, json};

use crate::figure::{Maps, bright};
use crate::plotting::short;

/// Number of colours.
// A cell takes a number of up to three digits in place of a colour of nine characters with its quotes.
const COLOURS: usize = 256;

/// Encodes maps for the page's script: cells as values, and as the numbers of their colours.
pub(super) fn encoded(maps: &Maps) -> Value {
    let last = (COLOURS - 1) as f64;
    let colours = (0..COLOURS).map(|n| {
        let (red, green, blue) = bright(n as f64 / last);
        format!("#{red:02x}{green:02x}{blue:02x}")
    });
    let all = maps.maps.iter().zip(maps.shares()).map(|(map, shares)| {
        let numbers = shares.iter();
        let numbers = numbers.map(|share| share.map(|share| (share * last).round() as usize));
        json!({
            "title": map.title,
            "cells": map.cells,
            "colours": numbers.collect::<Vec<_>>(),
        })
    });
    json!({
        "columns": maps.grid().0,
        "across": { "words": maps.across.0, "labels": maps.across.1 },
        "up": { "words": maps.up.0, "labels": maps.up.1 },
        "range": maps.range().map(|(low, high)| [short(low, 3), short(high, 3)]),
        "colours": colours.collect::<Vec<_>>(),
        "maps": all.collect::<Vec<_>>(),
    })
}
