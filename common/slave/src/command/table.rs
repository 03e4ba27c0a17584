//! The table of a kind of commands: an enum whose variants are its rows.

/// Fixed properties of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CommandRow<T: 'static> {
    /// Key of the command in files and messages: `move-absolute`.
    pub key: &'static str,
    /// PLC name of the command; its key if there is no such block.
    pub name: &'static str,
    /// Traits that its kind of commands distinguishes.
    pub traits: T,
}

/// Defines a kind of commands: an enum and the table of its variants.
///
/// A row has the doc comment of the command, its PLC name, its variant with the fields, and after
/// `=>` its traits, where they are not the usual ones. Everything else about a command by name
/// follows from the rows: `ROWS`, `row()`, `key()`, `name()`.
#[macro_export]
macro_rules! commands {
    (
        $(#[$of_all:meta])*
        pub enum $commands:ident $(<$param:ident = $default:ty>)?, each $traits:ty = $usual:expr;
        $(
            $(#[$of_one:meta])*
            $name:literal $command:ident $(($payload:ty))? $({ $($fields:tt)* })? $(=> $own:expr)?,
        )*
    ) => {
        $(#[$of_all])*
        pub enum $commands $(<$param = $default>)? {
            $(
                $(#[$of_one])*
                #[doc(alias = $name)]
                $command $(($payload))? $({ $($fields)* })?,
            )*
        }

        impl $(<$param>)? $commands $(<$param>)? {
            /// Rows of all commands of this kind.
            pub const ROWS: &'static [$crate::CommandRow<$traits>] = &[
                $( $crate::CommandRow {
                    key: {
                        const VARIANT: &str = stringify!($command);
                        const KEY: [u8; $crate::key::length(VARIANT)] = $crate::key::of(VARIANT);
                        $crate::key::text(&KEY)
                    },
                    name: $name,
                    traits: $crate::commands!(@first $($own,)? $usual),
                }, )*
            ];

            /// Returns the row of the command.
            #[must_use]
            pub const fn row(&self) -> &'static $crate::CommandRow<$traits> {
                enum RowNumber { $( $command, )* }
                &Self::ROWS[match self { $( Self::$command { .. } => RowNumber::$command, )* } as usize]
            }

            /// Returns the key of the command in files and messages.
            #[must_use]
            pub const fn key(&self) -> &'static str {
                self.row().key
            }

            /// Returns the PLC name of the command; its key if there is no such block.
            #[must_use]
            pub const fn name(&self) -> &'static str {
                self.row().name
            }
        }
    };
    (@first $own:expr, $usual:expr) => { $own };
    (@first $usual:expr) => { $usual };
}
