//! Files: loops for and from other codes, hashes, and files that are written as a whole.
//!
//! | module | holds |
//! | --- | --- |
//! | [`loop_file`] | loops in `.npz`, pairs of `.npy`, and `.csv` |
//! | [`hashed_file`] | a file by its contents |
//! | [`whole_file`] | a file that is there as a whole or not at all |

pub mod hashed_file;
pub mod loop_file;
pub mod whole_file;

pub use hashed_file::HashedFile;
pub use loop_file::{LoopFile, LoopFileError};
pub use whole_file::write_whole;
