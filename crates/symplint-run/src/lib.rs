//! Runs of costly maps: no finished evaluation is made twice, and none is lost.
//!
//! A diagnosis asks for the same evaluations in the same order whenever it is run. [`Journal::advance`] stands between it and
//! the map: it writes the result of each call to a file, and if the file has the result already, the map
//! is not called. A run that was stopped at any moment, also by SIGKILL, resumes where it was.
//!
//! [`CommandMap`] is a map whose calls are runs of a program: it reads a file of states, and writes the same states advanced by one
//! step. [`RunOutput`] is the folder of a run with its journal, and [`Round`] has the calls that the jobs of a scheduler make.
//!
//! | module | holds |
//! | --- | --- |
//! | `journal` | the journal, calls made or replayed; `log`, its bytes, with checksums; `round`, calls for jobs in a file |
//! | `command` | the map, which cuts blocks into calls; `call`, one call and its files; `process`, with a time limit and a group; `workspace`, the temporary folder; `program_file`, which identifies the program; `planned`, calls that jobs make; `stop`, an end by a signal |
//! | `folder` | `output`, the folder of a run; `earlier`, what it held before; `jobs`, a round of calls in it |
//! | `difference` | the first difference of two runs |

mod command;
mod difference;
mod folder;
mod journal;

pub use command::{CallsError, CommandError, CommandMap, FileFormat, Limits, stop_all};
pub use folder::{OccupiedError, Round, RunError, RunOutput, command_of, loop_file};
pub use journal::{
    Call, Journal, JournalError, Key, Record, Request, key, read_round, records, write_round,
};
