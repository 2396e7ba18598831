//! Choices among named values, as scene files, the command line and reports write them.

/// A choice among values that have names.
pub trait Choice: Copy + PartialEq + 'static {
    /// All values, in the order in which they are listed.
    const ALL: &'static [Self];
    /// Their names, in the same order.
    const NAMES: &'static [&'static str];
    /// What each means, in the same order; empty where the name says it.
    const MEANINGS: &'static [&'static str];

    /// Returns the value of a name.
    fn named(name: &str) -> Option<Self> {
        let all = Self::NAMES.iter().zip(Self::ALL);
        all.into_iter().find(|(own, _)| **own == name).map(|(_, value)| *value)
    }
}

/// Implements [`Choice`] for an enum, and with it `Display` and `FromStr`: the noun of the choice,
/// and for each value its name and what it means.
macro_rules! choice {
    ($type:ty, $noun:literal: $($value:ident = $name:literal $meaning:literal),+ $(,)?) => {
        impl $type {
            /// All values, in the order in which they are listed.
            pub const ALL: [Self; [$(<$type>::$value),+].len()] = [$(Self::$value),+];

            /// Returns the name, as scene files and the command line have it.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $name),+
                }
            }
        }

        impl $crate::math::Choice for $type {
            const ALL: &'static [Self] = &<$type>::ALL;
            const NAMES: &'static [&'static str] = &[$($name),+];
            const MEANINGS: &'static [&'static str] = &[$($meaning),+];
        }

        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }

        impl std::str::FromStr for $type {
            type Err = $crate::Error;

            fn from_str(name: &str) -> $crate::Result<Self> {
                <Self as $crate::math::Choice>::named(name).ok_or_else(|| {
                    let names = <Self as $crate::math::Choice>::NAMES.join(", ");
                    let text = concat!("there is no ", $noun);
                    $crate::Error::Parameter(format!("{text} `{name}`: use one of {names}"))
                })
            }
        }
    };
}
pub(crate) use choice;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Unit;

    #[test]
    fn names_and_values_belong_together() {
        for (unit, name) in Unit::ALL.iter().zip(Unit::NAMES) {
            assert_eq!(unit.name(), *name);
            assert_eq!(name.parse::<Unit>().expect("its name"), *unit);
        }
        let message = "mile".parse::<Unit>().expect_err("no name").to_string();
        assert!(message.contains("no unit `mile`: use one of km, m, cm"), "{message}");
    }
}
