//! The names and codes of the motion laws.

/// Law that moves the slave from one point to the next: `MC_MotionFunctionType` (TF5050 8.9).
///
/// The letters after a name are the conditions of a law at its two ends: `R` rest (no velocity, no
/// acceleration), `T` turn (no velocity, an acceleration of the law's own), `V` a velocity of the point
/// and no acceleration, `M` velocity and acceleration of the point. Laws without letters lead from rest
/// to rest.
#[doc(alias = "MC_MotionFunctionType")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[repr(u16)]
pub enum MotionLaw {
    /// A straight line: synchronous.
    #[doc(alias = "MOTIONFUNCTYPE_POLYNOM1")]
    Polynom1 = 1,
    /// Parabolic velocity; its acceleration jumps at both ends.
    #[doc(alias = "MOTIONFUNCTYPE_POLYNOM3")]
    Polynom3 = 3,
    /// The 3-4-5 polynomial.
    #[doc(alias = "MOTIONFUNCTYPE_POLYNOM5")]
    Polynom5 = 5,
    /// The 4-5-6-7 polynomial: no jerk at the ends.
    #[doc(alias = "MOTIONFUNCTYPE_POLYNOM7")]
    Polynom7 = 7,
    /// Degree 8: no jerk at the start, no jerk and no snap at the end.
    #[doc(alias = "MOTIONFUNCTYPE_POLYNOM8")]
    Polynom8 = 8,
    /// Degree 9: no jerk and no snap at the ends.
    #[doc(alias = "MOTIONFUNCTYPE_POLYNOM9")]
    Polynom9 = 9,
    /// Half a cosine; its acceleration jumps at both ends.
    #[doc(alias = "MOTIONFUNCTYPE_SINUSLINIE")]
    Sinuslinie = 10,
    /// Modified sine: a fast ramp of the acceleration, a slow middle.
    #[doc(alias = "MOTIONFUNCTYPE_MODSINUSLINIE")]
    Modsinuslinie = 11,
    /// Inclined sine line: the acceleration is one full sine.
    #[doc(alias = "MOTIONFUNCTYPE_BESTEHORN")]
    Bestehorn = 12,
    /// Modified acceleration trapezoid.
    #[doc(alias = "MOTIONFUNCTYPE_BESCHLTRAPEZ")]
    Beschltrapez = 13,
    /// Quintic between any two motions.
    #[doc(alias = "MOTIONFUNCTYPE_POLYNOM5_MM")]
    Polynom5Mm = 15,
    /// Half and quarter sine, rest to turn.
    #[doc(alias = "MOTIONFUNCTYPE_HARMONIC_KOMBI_RT")]
    HarmonicKombiRt = 17,
    /// Quarter and half sine, turn to rest.
    #[doc(alias = "MOTIONFUNCTYPE_HARMONIC_KOMBI_TR")]
    HarmonicKombiTr = 18,
    /// Half and quarter sine, velocity to turn.
    #[doc(alias = "MOTIONFUNCTYPE_HARMONIC_KOMBI_VT")]
    HarmonicKombiVt = 19,
    /// Quarter and half sine, turn to velocity.
    #[doc(alias = "MOTIONFUNCTYPE_HARMONIC_KOMBI_TV")]
    HarmonicKombiTv = 20,
    /// Modified acceleration trapezoid, rest to turn.
    #[doc(alias = "MOTIONFUNCTYPE_BESCHLTRAPEZ_RT")]
    BeschltrapezRt = 21,
    /// Modified acceleration trapezoid, turn to rest.
    #[doc(alias = "MOTIONFUNCTYPE_BESCHLTRAPEZ_TR")]
    BeschltrapezTr = 22,
    /// Modified sine between two velocities.
    #[doc(alias = "MOTIONFUNCTYPE_MODSINUSLINIE_VV")]
    ModsinuslinieVv = 23,
    /// Septic between any two motions, jerk included.
    #[doc(alias = "MOTIONFUNCTYPE_POLYNOM7_MM")]
    Polynom7Mm = 24,
    /// Modified acceleration trapezoid, rest to velocity.
    #[doc(alias = "MOTIONFUNCTYPE_BESCHLTRAPEZ_RV")]
    BeschltrapezRv = 38,
    /// Modified acceleration trapezoid, velocity to rest.
    #[doc(alias = "MOTIONFUNCTYPE_BESCHLTRAPEZ_VR")]
    BeschltrapezVr = 39,
    /// Cubic between two velocities, for any acceleration at the points.
    #[doc(alias = "MOTIONFUNCTYPE_POLYNOM3_VV")]
    Polynom3Vv = 40,
    /// Degree 11: the first five derivatives vanish at the ends.
    #[doc(alias = "MOTIONFUNCTYPE_POLYNOM11")]
    Polynom11 = 41,
    /// Peisekah's polynomial of degree 11: low acceleration for its smoothness.
    #[doc(alias = "MOTIONFUNCTYPE_PEISEKAH11")]
    Peisekah11 = 45,
    /// An inner point of a cubic spline.
    #[doc(alias = "MOTIONFUNCTYPE_SPLINE")]
    Spline = 100,
    /// The first or last point of a natural spline: no curvature there.
    #[doc(alias = "MOTIONFUNCTYPE_SPLINE_NATURAL")]
    SplineNatural = 101,
    /// The first or last point of a spline with the point's slope.
    #[doc(alias = "MOTIONFUNCTYPE_SPLINE_TANGENTIAL")]
    SplineTangential = 102,
    /// The first or last point of a spline that closes on itself.
    #[doc(alias = "MOTIONFUNCTYPE_SPLINE_PERIODIC")]
    SplinePeriodic = 103,
    /// The first or last point of a spline whose end slope is the secant of its end piece.
    #[doc(alias = "MOTIONFUNCTYPE_SPLNE_LINEAR")]
    SplineLinear = 120,
}

impl MotionLaw {
    /// Laws by ascending code.
    pub const ALL: &[Self] = &[
        Self::Polynom1,
        Self::Polynom3,
        Self::Polynom5,
        Self::Polynom7,
        Self::Polynom8,
        Self::Polynom9,
        Self::Sinuslinie,
        Self::Modsinuslinie,
        Self::Bestehorn,
        Self::Beschltrapez,
        Self::Polynom5Mm,
        Self::HarmonicKombiRt,
        Self::HarmonicKombiTr,
        Self::HarmonicKombiVt,
        Self::HarmonicKombiTv,
        Self::BeschltrapezRt,
        Self::BeschltrapezTr,
        Self::ModsinuslinieVv,
        Self::Polynom7Mm,
        Self::BeschltrapezRv,
        Self::BeschltrapezVr,
        Self::Polynom3Vv,
        Self::Polynom11,
        Self::Peisekah11,
        Self::Spline,
        Self::SplineNatural,
        Self::SplineTangential,
        Self::SplinePeriodic,
        Self::SplineLinear,
    ];

    /// Returns the number of the law in the PLC.
    #[must_use]
    pub const fn code(self) -> u16 {
        self as u16
    }

    /// Returns the law with a code; none if no law has it.
    #[must_use]
    pub const fn from_code(code: u16) -> Option<Self> {
        // A loop, since iterators are not available in a `const fn`.
        let mut i = 0;
        while i < Self::ALL.len() {
            if Self::ALL[i].code() == code {
                return Some(Self::ALL[i]);
            }
            i += 1;
        }
        None
    }

    /// Returns the name of the law in the PLC, in the manual's own spelling.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Polynom1 => "MOTIONFUNCTYPE_POLYNOM1",
            Self::Polynom3 => "MOTIONFUNCTYPE_POLYNOM3",
            Self::Polynom5 => "MOTIONFUNCTYPE_POLYNOM5",
            Self::Polynom7 => "MOTIONFUNCTYPE_POLYNOM7",
            Self::Polynom8 => "MOTIONFUNCTYPE_POLYNOM8",
            Self::Polynom9 => "MOTIONFUNCTYPE_POLYNOM9",
            Self::Sinuslinie => "MOTIONFUNCTYPE_SINUSLINIE",
            Self::Modsinuslinie => "MOTIONFUNCTYPE_MODSINUSLINIE",
            Self::Bestehorn => "MOTIONFUNCTYPE_BESTEHORN",
            Self::Beschltrapez => "MOTIONFUNCTYPE_BESCHLTRAPEZ",
            Self::Polynom5Mm => "MOTIONFUNCTYPE_POLYNOM5_MM",
            Self::HarmonicKombiRt => "MOTIONFUNCTYPE_HARMONIC_KOMBI_RT",
            Self::HarmonicKombiTr => "MOTIONFUNCTYPE_HARMONIC_KOMBI_TR",
            Self::HarmonicKombiVt => "MOTIONFUNCTYPE_HARMONIC_KOMBI_VT",
            Self::HarmonicKombiTv => "MOTIONFUNCTYPE_HARMONIC_KOMBI_TV",
            Self::BeschltrapezRt => "MOTIONFUNCTYPE_BESCHLTRAPEZ_RT",
            Self::BeschltrapezTr => "MOTIONFUNCTYPE_BESCHLTRAPEZ_TR",
            Self::ModsinuslinieVv => "MOTIONFUNCTYPE_MODSINUSLINIE_VV",
            Self::Polynom7Mm => "MOTIONFUNCTYPE_POLYNOM7_MM",
            Self::BeschltrapezRv => "MOTIONFUNCTYPE_BESCHLTRAPEZ_RV",
            Self::BeschltrapezVr => "MOTIONFUNCTYPE_BESCHLTRAPEZ_VR",
            Self::Polynom3Vv => "MOTIONFUNCTYPE_POLYNOM3_VV",
            Self::Polynom11 => "MOTIONFUNCTYPE_POLYNOM11",
            Self::Peisekah11 => "MOTIONFUNCTYPE_PEISEKAH11",
            Self::Spline => "MOTIONFUNCTYPE_SPLINE",
            Self::SplineNatural => "MOTIONFUNCTYPE_SPLINE_NATURAL",
            Self::SplineTangential => "MOTIONFUNCTYPE_SPLINE_TANGENTIAL",
            Self::SplinePeriodic => "MOTIONFUNCTYPE_SPLINE_PERIODIC",
            // The manual's own spelling, without the I.
            Self::SplineLinear => "MOTIONFUNCTYPE_SPLNE_LINEAR",
        }
    }

    /// Returns the name of the law in cam files and orders.
    #[must_use]
    pub const fn file_name(self) -> &'static str {
        match self {
            Self::Polynom1 => "polynom1",
            Self::Polynom3 => "polynom3",
            Self::Polynom5 => "polynom5",
            Self::Polynom7 => "polynom7",
            Self::Polynom8 => "polynom8",
            Self::Polynom9 => "polynom9",
            Self::Sinuslinie => "sinuslinie",
            Self::Modsinuslinie => "modsinuslinie",
            Self::Bestehorn => "bestehorn",
            Self::Beschltrapez => "beschltrapez",
            Self::Polynom5Mm => "polynom5-mm",
            Self::HarmonicKombiRt => "harmonic-kombi-rt",
            Self::HarmonicKombiTr => "harmonic-kombi-tr",
            Self::HarmonicKombiVt => "harmonic-kombi-vt",
            Self::HarmonicKombiTv => "harmonic-kombi-tv",
            Self::BeschltrapezRt => "beschltrapez-rt",
            Self::BeschltrapezTr => "beschltrapez-tr",
            Self::ModsinuslinieVv => "modsinuslinie-vv",
            Self::Polynom7Mm => "polynom7-mm",
            Self::BeschltrapezRv => "beschltrapez-rv",
            Self::BeschltrapezVr => "beschltrapez-vr",
            Self::Polynom3Vv => "polynom3-vv",
            Self::Polynom11 => "polynom11",
            Self::Peisekah11 => "peisekah11",
            Self::Spline => "spline",
            Self::SplineNatural => "spline-natural",
            Self::SplineTangential => "spline-tangential",
            Self::SplinePeriodic => "spline-periodic",
            Self::SplineLinear => "spline-linear",
        }
    }

    /// True if the law is a point of a spline, whose pieces depend on all points of the spline.
    #[must_use]
    pub const fn is_spline(self) -> bool {
        // Codes of splines begin at 100, those of laws between two points end at 45.
        self.code() >= Self::Spline.code()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_law_is_found_by_its_code() {
        for &law in MotionLaw::ALL {
            assert_eq!(MotionLaw::from_code(law.code()), Some(law));
        }
        assert!(MotionLaw::ALL.is_sorted());
        assert_eq!(MotionLaw::ALL.len(), 29);
        assert_eq!(MotionLaw::from_code(0), None);
        // The manual has no 14: its codes have gaps.
        assert_eq!(MotionLaw::from_code(14), None);
    }

    #[test]
    fn names_are_the_variants_in_capitals() {
        for &law in MotionLaw::ALL {
            let plain = law.name().replace("MOTIONFUNCTYPE", "").replace('_', "");
            let variant = std::format!("{law:?}").to_uppercase();
            assert_eq!(plain.replace("SPLNE", "SPLINE"), variant);
        }
    }

    #[test]
    fn names_in_files_are_the_variants_in_small_letters() {
        for &law in MotionLaw::ALL {
            let plain = law.file_name().replace('-', "");
            assert_eq!(plain, std::format!("{law:?}").to_lowercase());
        }
    }

    #[test]
    fn only_splines_are_splines() {
        let splines = MotionLaw::ALL.iter().filter(|law| law.is_spline()).count();
        assert_eq!(splines, 5);
        assert!(!MotionLaw::Peisekah11.is_spline());
    }
}
