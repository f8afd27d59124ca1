//! Exit statuses.

/// The exit status of a command.
pub type Status = u8;

/// The command did what it was asked to, or the map is symplectic.
pub const SUCCESS: Status = 0;

/// Bad usage, bad input or a failed run.
pub const FAILED: Status = 2;
