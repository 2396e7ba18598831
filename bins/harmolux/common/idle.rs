//! Flags that would have no effect on what they are given with: none is passed over in silence.

use harmolux::{Error, Result};

/// Refuses those of these flags that are given; `why` says what is there and what they are for.
pub(crate) fn refuse(why: &str, flags: &[(bool, &str)]) -> Result<()> {
    let given = flags.iter().filter(|(given, _)| *given).map(|(_, flag)| format!("`{flag}`"));
    let given = given.collect::<Vec<_>>().join(" and ");
    if given.is_empty() {
        return Ok(());
    }
    Err(Error::Parameter(format!("{why}: leave out {given}")))
}
