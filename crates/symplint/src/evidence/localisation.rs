//! The origin of a defect: which substep of the map, which part of the loop.

use serde::{Deserialize, Serialize};

/// The origin of the defect of one loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Localisation {
    /// Which loop: 0 is the given one.
    #[serde(rename = "loop")]
    pub loop_index: usize,
    /// Step size h; `None` for a map without one.
    pub step_size: Option<f64>,
    /// What each substep changes, the first one first; empty for a map without substeps.
    pub substeps: Vec<SubstepDefect>,
    /// What each part of the loop contributes; empty for broken loops, and for those that cannot be
    /// contracted.
    pub sectors: Vec<Sector>,
}

/// The place of the change of a loop integral in the disc that the loop bounds, the fan of segments from a point within.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contraction {
    /// The loop parameters between which the patch lies that carries most of it.
    pub s: [f64; 2],
    /// How far from the centre: 0 there and 1 on the loop.
    pub r: [f64; 2],
    /// How many patches carry nine tenths of it.
    pub points: usize,
    /// Their area as a part of that of the disc. The disc is halved as long as few halves carry the change: of a map
    /// whose defect is spread over an area it is large.
    pub area: f64,
}

/// What one substep of the map does to the loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SubstepDefect {
    /// Which substep, 0 for the first.
    pub substep: usize,
    /// Its name.
    pub name: String,
    /// Signed change of the loop integral, with its breaks closed, relative to that before the step.
    pub change: f64,
    /// How far off `change` may be; `None` where that is not known.
    pub uncertainty: Option<f64>,
    /// Breaks of the loop after this substep.
    pub breaks: usize,
    /// Those of them that were not there before it.
    pub new_breaks: usize,
}

/// What one sector of the disc within a loop contributes to the defect of the loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sector {
    /// The loop parameter where it begins.
    pub from: f64,
    /// And where it ends.
    pub to: f64,
    /// Signed change of its loop integral, relative to that of the whole loop.
    pub change: f64,
    /// How far off `change` may be; `None` where that is not known.
    pub uncertainty: Option<f64>,
}
