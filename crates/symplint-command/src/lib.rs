//! Maps that are programs: one call reads a file of states and writes the same states advanced by one step.
//!
//! [`CommandMap`] is the map. For every call it writes `before.npz` into a folder of its own (arrays `q` and `p` of shape
//! (samples, dof), `h`, `period`, `weight`), runs the command, and reads `after.npz`.
//!
//! | module | holds |
//! | --- | --- |
//! | `map` | the map: blocks of samples cut into calls, some at a time |
//! | `planned` | calls that are asked for, and made by the jobs of a scheduler |
//! | `call` | one call: its files, and what can go wrong |
//! | `lack` | what the system could not do for a call, which is no failure of the map |
//! | `known_files` | the files that the program is known by, and whether they changed |
//! | `names` | what a command may name files by |
//! | `search` | where the system finds a program |
//! | `process` | a process with a time limit, and its group |
//! | `workspace` | the temporary folder, and folders that killed runs left behind |
//! | `running` | all processes and folders of this program, for an end by a signal |

mod call;
mod error;
mod known_files;
mod lack;
mod map;
mod names;
mod planned;
mod process;
mod running;
mod search;
mod workspace;

pub use error::{CallsError, CommandError};
pub use lack::Lack;
pub use map::{CommandMap, Limits};
pub use running::stop_all;
