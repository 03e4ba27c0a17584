//! The jump-free transition onto a plate.

use super::placement::Path;

/// Remainder of a step between the old course and the new one. It fades over a distance of the master, to
/// either side, and starts and ends without a step in position, slope or curvature.
///
/// The slave follows the new course plus this remainder, so it needs no plan that a moving plate could
/// break.
#[derive(Clone, Copy, Debug)]
pub(super) struct GapRamp {
    start: f64,
    length: f64,
    gap: Path,
}

impl GapRamp {
    /// Makes a ramp from a gap (old course less new one) where the master is at `start`, u, over a
    /// `length` above 0, u.
    pub(super) const fn new(start: f64, length: f64, gap: Path) -> Self {
        Self { start, length, gap }
    }

    /// Returns the distance of the master that it takes, u.
    pub(super) const fn length(&self) -> f64 {
        self.length
    }

    /// Returns the magnitudes that the deviation's slope and curvature do not exceed.
    pub(super) fn bound(&self) -> Path {
        let Path {
            position,
            slope,
            curvature,
        } = self.gap;
        let (p, s, c) = (
            position.abs(),
            slope.abs() * self.length,
            curvature.abs() * self.length * self.length,
        );
        // Peaks of the first and second derivatives of the quintic's three parts over z, rounded up:
        // 15/8, 1 and 0.06779; 10/√3, 3.9402 and 1.
        Path {
            position: 0.0,
            slope: (1.8751 * p + 1.0001 * s + 0.0679 * c) / self.length,
            curvature: (5.7736 * p + 3.9404 * s + 1.0001 * c) / (self.length * self.length),
        }
    }

    /// Returns the deviation of the slave from the new course; none once that is reached.
    pub(super) fn at(&self, master: f64) -> Option<Path> {
        // Either direction: a master that reverses onto the ramp's other side fades the gap out there.
        let distance = master - self.start;
        let z = distance.abs() / self.length;
        // Exactly at the end the deviation is 0 in all three, so nothing steps when the ramp is dropped.
        if z >= 1.0 {
            return None;
        }
        // Mirrored behind the start, where the slope has the opposite sign.
        let side = if distance < 0.0 { -1.0 } else { 1.0 };
        let Path {
            position,
            slope,
            curvature,
        } = self.gap;
        let (p, s, c) = (
            position,
            // Derivatives over z instead of the master: one factor of the length for each order.
            side * slope * self.length,
            curvature * self.length * self.length,
        );
        let rest = 1.0 - z;
        // The quintic with these values at 0 and none at 1: rest³·(k0 + k1·z + k2·z²).
        // From f(0) = k0, f'(0) = k1 - 3k0 = s and f''(0) = 2k2 - 6k1 + 6k0 = c.
        let (k0, k1, k2) = (p, 3.0 * p + s, 6.0 * p + 3.0 * s + c / 2.0);
        let q = k0 + z * (k1 + z * k2);
        let dq = k1 + 2.0 * k2 * z;
        let ddq = 2.0 * k2;
        Some(Path {
            position: rest * rest * rest * q,
            slope: side * rest * rest * (rest * dq - 3.0 * q) / self.length,
            // Even in the distance, so the side does not count.
            curvature: rest * (rest * rest * ddq - 6.0 * rest * dq + 6.0 * q)
                / (self.length * self.length),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_starts_with_the_gap_and_ends_with_nothing() {
        let gap = Path {
            position: 3.0,
            slope: -2.0,
            curvature: 0.5,
        };
        let ramp = GapRamp::new(10.0, 4.0, gap);
        assert_eq!(ramp.at(10.0), Some(gap));
        for end in [14.0, 6.0] {
            assert_eq!(ramp.at(end), None);
            let near = ramp.at(end + (10.0 - end) * 1e-6).unwrap();
            assert!(near.position.abs() < 1e-12, "{near:?}");
            assert!(near.slope.abs() < 1e-9);
            assert!(near.curvature.abs() < 1e-4);
        }
    }

    #[test]
    fn it_keeps_within_its_bound_and_comes_near_it() {
        let gaps = [
            (3.0, 0.0, 0.0),
            (0.0, -2.0, 0.0),
            (0.0, 0.0, 0.5),
            (1.5, 0.7, -0.3),
        ];
        for (position, slope, curvature) in gaps {
            let gap = Path {
                position,
                slope,
                curvature,
            };
            let ramp = GapRamp::new(10.0, 4.0, gap);
            let most = (0..4_000).fold((0.0_f64, 0.0_f64), |(slope, curvature), step| {
                let path = ramp.at(10.0 + f64::from(step) * 1e-3).unwrap();
                (
                    slope.max(path.slope.abs()),
                    curvature.max(path.curvature.abs()),
                )
            });
            let bound = ramp.bound();
            assert!(
                most.0 <= bound.slope && most.1 <= bound.curvature,
                "{gap:?}: {most:?}"
            );
            let is_single = [position, slope, curvature]
                .iter()
                .filter(|part| **part != 0.0)
                .count()
                == 1;
            // Of the sum, the parts have their peaks in different places.
            let least = if is_single { 0.998 } else { 0.3 };
            assert!(
                most.0 >= least * bound.slope && most.1 >= least * bound.curvature,
                "{gap:?}: {most:?}"
            );
        }
    }

    #[test]
    fn it_agrees_with_the_hermite_basis_and_its_difference_quotients() {
        let gap = Path {
            position: 1.5,
            slope: 0.7,
            curvature: -0.3,
        };
        let length = 2.5;
        let ramp = GapRamp::new(0.0, length, gap);
        let at = |master: f64| ramp.at(master).unwrap();
        for i in -9..=9 {
            let master = f64::from(i) * 0.25;
            let t = master.abs() / length;
            let (slope, curvature) = (gap.slope * master.signum(), gap.curvature);
            let expected = gap.position
                * (1.0 - 10.0 * t.powi(3) + 15.0 * t.powi(4) - 6.0 * t.powi(5))
                + slope * length * (t - 6.0 * t.powi(3) + 8.0 * t.powi(4) - 3.0 * t.powi(5))
                + curvature
                    * length
                    * length
                    * (0.5 * t.powi(2) - 1.5 * t.powi(3) + 1.5 * t.powi(4) - 0.5 * t.powi(5));
            assert!((at(master).position - expected).abs() < 1e-14, "{master}");
            let h = 1e-5;
            let slope = (at(master + h).position - at(master - h).position) / (2.0 * h);
            let curvature = (at(master + h).slope - at(master - h).slope) / (2.0 * h);
            assert!((at(master).slope - slope).abs() < 1e-8, "{master}");
            assert!((at(master).curvature - curvature).abs() < 1e-4, "{master}");
        }
    }
}
