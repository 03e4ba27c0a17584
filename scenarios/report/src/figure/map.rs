//! Maps: values over two axes as coloured cells.

use super::scale::Scale;

/// Maps of one quantity over the same two axes, in the same colours.
#[derive(Clone, Debug, Default)]
pub struct Maps {
    /// Name within the page.
    pub id: String,
    /// The quantity.
    pub title: String,
    /// Caption: the feature to look at.
    pub caption: String,
    /// Horizontal axis: its quantity and its values.
    pub across: (String, Vec<String>),
    /// Vertical axis, from the bottom up: its quantity and its values.
    pub up: (String, Vec<String>),
    /// Maps, beside and below each other.
    pub maps: Vec<Map>,
    /// Number of maps left out.
    pub left_out: usize,
}

/// A map.
#[derive(Clone, Debug, Default)]
pub struct Map {
    /// Title above the map.
    pub title: String,
    /// Value at each place, row by row upwards; none where nothing is known.
    pub cells: Vec<Option<f64>>,
}

/// Greatest number of maps beside each other.
const MOST_COLUMNS: usize = 3;

impl Maps {
    /// Returns the numbers of columns and rows of maps.
    pub(crate) fn grid(&self) -> (usize, usize) {
        let columns = self.maps.len().clamp(1, MOST_COLUMNS);
        (columns, self.maps.len().div_ceil(columns))
    }

    /// Returns the least and the largest value; none without values.
    pub(crate) fn range(&self) -> Option<(f64, f64)> {
        super::extent(self.values())
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        let cells = self.maps.iter().flat_map(|map| &map.cells);
        cells.flatten().copied()
    }

    /// Returns the cells of each map as shares of the way from the least to the largest value, logarithmic where that suits
    /// them.
    pub(crate) fn shares(&self) -> Vec<Vec<Option<f64>>> {
        let scale = Scale::suiting(self.values());
        let (low, high) = self.range().unwrap_or_default();
        let (low, high) = (scale.place(low), scale.place(high));
        let share = |value: f64| {
            let share = (scale.place(value) - low) / (high - low);
            // All values are equal.
            if share.is_finite() { share } else { 0.0 }
        };
        let of = |map: &Map| map.cells.iter().map(|cell| cell.map(share)).collect();
        self.maps.iter().map(of).collect()
    }
}

/// Viridis at five places: dark is little, bright is much, with any colour vision and in print.
// The colours of matplotlib's table at 0, ¼, ½, ¾ and 1, with straight lines between them.
const VIRIDIS: [[f64; 3]; 5] = [
    [68.0, 1.0, 84.0],
    [59.0, 82.0, 139.0],
    [33.0, 145.0, 140.0],
    [94.0, 201.0, 98.0],
    [253.0, 231.0, 37.0],
];

/// Returns the colour of a share.
pub(crate) fn bright(share: f64) -> (u8, u8, u8) {
    // Without the clamp a share past an end would panic: no colour is there.
    let place = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let (below, above) = (VIRIDIS[place as usize], VIRIDIS[place.ceil() as usize]);
    let part = |n: usize| (below[n] + place.fract() * (above[n] - below[n])).round() as u8;
    (part(0), part(1), part(2))
}

/// Returns the colour of a number that is written on the colour of a share.
pub(crate) const fn ink(share: f64) -> (u8, u8, u8) {
    // The colour in the middle has a relative luminance of 0.22: a contrast of 3.8 with white, and of 5.5 with black.
    if share < 0.5 {
        (0xff, 0xff, 0xff)
    } else {
        (0, 0, 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn maps(cells: &[Option<f64>]) -> Maps {
        let map = Map {
            cells: cells.to_vec(),
            ..Map::default()
        };
        Maps {
            maps: vec![map],
            ..Maps::default()
        }
    }

    #[test]
    fn colours_are_those_of_the_ends_at_the_ends() {
        assert_eq!(bright(0.0), (68, 1, 84));
        assert_eq!(bright(0.5), (33, 145, 140));
        assert_eq!(bright(1.0), (253, 231, 37));
    }

    #[test]
    fn shares_go_from_the_least_to_the_largest_and_by_decades_over_many() {
        assert_eq!(
            maps(&[Some(1.0), None, Some(3.0), Some(2.0)]).shares(),
            [[Some(0.0), None, Some(1.0), Some(0.5)]]
        );
        let shares = maps(&[Some(1.0), Some(10.0), Some(100.0)]).shares();
        assert_eq!(shares, [[Some(0.0), Some(0.5), Some(1.0)]]);
        assert_eq!(maps(&[Some(7.0), Some(7.0)]).shares(), [[Some(0.0); 2]]);
        assert_eq!(maps(&[None]).range(), None);
        assert_eq!(Maps::default().grid(), (1, 0));
    }
}
