//! A straight line through points, by least squares.

/// The line, and how well it fits.
pub(crate) struct StraightLine {
    /// The means of the times and of the values, s: it goes through them.
    pub(crate) time: f64,
    pub(crate) value: f64,
    pub(crate) slope: f64,
    /// Sums of squares: of the times from their mean, and of the values from the line.
    pub(crate) squares: f64,
    pub(crate) scatter: f64,
    count: f64,
}

impl StraightLine {
    /// Fits pairs of a time and a value, s: at least three, not all of one time.
    pub(crate) fn through(points: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let count = points.clone().count() as f64;
        let time = points.clone().map(|point| point.0).sum::<f64>() / count;
        let value = points.clone().map(|point| point.1).sum::<f64>() / count;
        // About the means: sums of squares of times since the start would cancel in all their digits.
        let centred = points.map(|point| (point.0 - time, point.1 - value));
        let squares = centred.clone().map(|(t, _)| t * t).sum::<f64>();
        let slope = centred.clone().map(|(t, v)| t * v).sum::<f64>() / squares;
        let off = centred.map(|(t, v)| v - slope * t);
        Self {
            time,
            value,
            slope,
            squares,
            scatter: off.map(|off| off * off).sum(),
            count,
        }
    }

    /// The variance of a value.
    pub(crate) fn variance(&self) -> f64 {
        // Two degrees of freedom are in the line.
        self.scatter / (self.count - 2.0)
    }

    /// The standard deviation of the slope.
    pub(crate) fn slope_sigma(&self) -> f64 {
        libm::sqrt(self.variance() / self.squares)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_and_what_is_off_it_are_found() {
        let points = [(1.0, 5.0), (2.0, 6.0), (3.0, 9.0), (4.0, 10.0)];
        let line = StraightLine::through(points.into_iter());
        assert_eq!((line.time, line.value, line.slope), (2.5, 7.5, 1.8));
        assert!((line.scatter - 0.8).abs() < 1e-12, "{}", line.scatter);
        assert!((line.variance() - 0.4).abs() < 1e-12);
        assert!((line.slope_sigma() - 0.08_f64.sqrt()).abs() < 1e-12);
    }
}
