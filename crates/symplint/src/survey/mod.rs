//! What is learnt of a map before anything is measured.

mod deformation;
mod precision;
mod purity;

pub(crate) use deformation::{deformation, motion, winds};
pub(crate) use precision::own_up;
pub(crate) use purity::check;
