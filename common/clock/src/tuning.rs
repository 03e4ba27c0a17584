//! Tuned constants: those of a block stand together in one struct, each with the reason for its value.
//!
//! A block declares them by the macro `tuning`, and reads them as `TUNING.name`. In a usual build that is a constant. With
//! the feature `perturb`, which is for the example `tuning` alone, every thread can change one at a time and see what that does.

/// Declares the tuned constants of the module's block, and `TUNING`, which holds them.
macro_rules! tuning {
    ($(#[$about:meta])* $name:ident { $($(#[$reason:meta])* $field:ident: $kind:ty = $value:expr,)* }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug)]
        pub(crate) struct $name {
            $($(#[$reason])* pub(crate) $field: $kind,)*
        }

        impl $name {
            pub(crate) const DEFAULT: Self = Self { $($field: $value,)* };
        }

        #[cfg(not(feature = "perturb"))]
        pub(crate) const TUNING: $name = $name::DEFAULT;

        #[cfg(feature = "perturb")]
        std::thread_local! {
            static PERTURBED: core::cell::Cell<&'static $name> = core::cell::Cell::new($name::of_environment());
        }

        #[cfg(feature = "perturb")]
        pub(crate) static TUNING: $crate::tuning::Tuned<$name> = $crate::tuning::Tuned(&PERTURBED);

        #[cfg(feature = "perturb")]
        impl $name {
            /// The constants with one of them multiplied, and its value.
            fn perturbed(constant: &str, factor: f64) -> (&'static Self, std::string::String) {
                use $crate::tuning::Tunable;
                let mut tuning = Self::DEFAULT;
                let mut value = std::string::String::new();
                $(if constant == stringify!($field) {
                    tuning.$field = tuning.$field.times(factor);
                    value = std::format!("{:?}", tuning.$field);
                })*
                (std::boxed::Box::leak(std::boxed::Box::new(tuning)), value)
            }

            /// The constants, one of them multiplied if the environment says so.
            fn of_environment() -> &'static Self {
                match $crate::tuning::perturbed_by_environment(stringify!($name)) {
                    Some((constant, factor)) => Self::perturbed(&constant, factor).0,
                    None => &Self::DEFAULT,
                }
            }
        }

        #[cfg(feature = "perturb")]
        pub(crate) const TUNED: $crate::tuning::TunedBlock = $crate::tuning::TunedBlock {
            name: stringify!($name),
            constants: &[$(stringify!($field)),*],
            perturb: |constant, factor| {
                let (tuning, value) = $name::perturbed(constant, factor);
                PERTURBED.set(tuning);
                value
            },
            restore: || PERTURBED.set(&$name::DEFAULT),
        };
    };
}

pub(crate) use tuning;

#[cfg(feature = "perturb")]
pub use perturbed::TunedBlock;
#[cfg(feature = "perturb")]
pub(crate) use perturbed::{Tunable, Tuned, perturbed_by_environment};

#[cfg(feature = "perturb")]
mod perturbed {
    use core::cell::Cell;
    use std::string::String;
    use std::thread::LocalKey;

    use crate::instant::Span;

    /// The tuned constants of one block.
    #[derive(Clone, Copy, Debug)]
    pub struct TunedBlock {
        /// Name of their struct.
        pub name: &'static str,
        /// Names of the constants.
        pub constants: &'static [&'static str],
        /// Multiplies one of them in this thread, and restores the others. Returns its value.
        pub perturb: fn(&str, f64) -> String,
        /// Restores all of them in this thread.
        pub restore: fn(),
    }

    /// The constants of a block as this thread has them.
    pub(crate) struct Tuned<T: 'static>(pub(crate) &'static LocalKey<Cell<&'static T>>);

    impl<T> core::ops::Deref for Tuned<T> {
        type Target = T;

        fn deref(&self) -> &T {
            self.0.get()
        }
    }

    /// Name and factor of the constant of a block that the environment perturbs: `COAXLE_PERTURB=TeethTuning.level=0.7`.
    pub(crate) fn perturbed_by_environment(block: &str) -> Option<(String, f64)> {
        let wanted = std::env::var("COAXLE_PERTURB").ok()?;
        let (path, factor) = wanted.split_once('=')?;
        let (of_block, constant) = path.split_once('.')?;
        let factor = factor.parse().ok()?;
        (of_block == block).then(|| (constant.into(), factor))
    }

    /// A constant that can be multiplied.
    pub(crate) trait Tunable {
        fn times(self, factor: f64) -> Self;
    }

    impl Tunable for f64 {
        fn times(self, factor: f64) -> Self {
            self * factor
        }
    }

    impl<const N: usize> Tunable for [f64; N] {
        fn times(self, factor: f64) -> Self {
            self.map(|value| value * factor)
        }
    }

    impl Tunable for Span {
        fn times(self, factor: f64) -> Self {
            Self::from_secs_f64(self.as_secs_f64() * factor)
        }
    }

    macro_rules! whole {
        ($($kind:ty)*) => {
            $(impl Tunable for $kind {
                // By one at least: 1.3 times 1 is 1 otherwise.
                fn times(self, factor: f64) -> Self {
                    let times = (self as f64 * factor).round();
                    if factor == 1.0 {
                        return self;
                    }
                    let other = if factor < 1.0 { self.saturating_sub(1) } else { self + 1 };
                    if times as Self == self { other } else { times as Self }
                }
            })*
        };
    }

    whole!(u8 u16 u32 u64 i64 usize);
}
