//! Trigonometric laws as weighted sums of two fixed ones.

use super::arc::{Arc, Chain};
use super::motion::Motion;

/// A fixed law from 0 and its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BlendPart {
    pub(super) weight: f64,
    pub(super) arcs: &'static [Arc],
}

/// `start` + `slope`·z plus two fixed laws with arcs of equal joints and angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BlendedLaw {
    start: f64,
    slope: f64,
    parts: [BlendPart; 2],
}

impl BlendedLaw {
    /// Makes a sum of two laws.
    pub(super) const fn new(start: f64, slope: f64, parts: [BlendPart; 2]) -> Self {
        Self {
            start,
            slope,
            parts,
        }
    }

    /// Makes a single law.
    pub(super) const fn single(start: f64, stroke: f64, arcs: &'static [Arc]) -> Self {
        let law = BlendPart {
            weight: stroke,
            arcs,
        };
        // The law again with weight 0: joints and angles of both parts agree.
        let nothing = BlendPart { weight: 0.0, arcs };
        Self::new(start, 0.0, [law, nothing])
    }

    /// Returns the value and derivatives at the share `z` of the segment, with respect to z.
    #[inline]
    pub(super) fn at(&self, z: f64) -> Motion {
        self.arc(self.index_at(z)).at(z)
    }
}

impl Chain for BlendedLaw {
    fn len(&self) -> usize {
        self.parts[0].arcs.len()
    }

    #[inline]
    fn arc(&self, index: usize) -> Arc {
        let [one, other] = &self.parts;
        let (a, b) = (&one.arcs[index], &other.arcs[index]);
        // Summed as coefficients, so that one sine and cosine serve both laws.
        let sum = |k: usize| one.weight * a.powers[k] + other.weight * b.powers[k];
        Arc {
            begin: a.begin,
            omega: a.omega,
            powers: [
                self.start + self.slope * a.begin + sum(0),
                self.slope + sum(1),
                sum(2),
            ],
            wave: a.wave.scaled(one.weight).plus(&b.wave.scaled(other.weight)),
        }
    }

    #[inline]
    fn index_at(&self, z: f64) -> usize {
        let arcs = self.parts[0].arcs;
        arcs.iter().rposition(|arc| arc.begin <= z).unwrap_or(0)
    }
}
