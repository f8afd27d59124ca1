//! A journal of evaluations, so that the diagnosis of a costly map that was stopped can go on.
//!
//! A diagnosis asks for the same evaluations in the same order whenever it is run. [`Journal::advance`] stands between it and
//! the map: it writes what the map makes of some states to a file, and where the file has it already, the map
//! is not called. A run that was stopped at any moment, by SIGKILL too, goes on where it was.
//!
//! | module | holds |
//! | --- | --- |
//! | `journal` | the journal: calls of a map, made or replayed |
//! | `round` | calls that are to be made elsewhere, in a file |
//! | `record` | the bytes of a header and of a record, with checksums |
//! | `scan` | what a file holds, also where bytes of it changed |
//! | `key` | what a call is known by |
//! | `difference` | what two journals are of, compared |

mod difference;
mod error;
mod journal;
mod key;
mod record;
mod round;
mod scan;

pub use error::JournalError;
pub use journal::{Claim, Journal};
pub use key::{Key, key};
pub use record::Call;
pub use round::{Request, calls_in, read_round, write_round};
