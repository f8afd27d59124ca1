//! The two sides of a break.

use serde::{Deserialize, Serialize};

/// The image of a loop on both sides of a break, and what else tells why the map jumps there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BreakSides {
    /// Which loop: 0 is the given one.
    pub loop_index: usize,
    /// The step size h; `None` for a map without one.
    pub step_size: Option<f64>,
    /// The loop parameter of the break.
    pub s: f64,
    /// Coordinates that jump or are constant on one side, those that jump furthest first, and at most a dozen; and the other
    /// coordinate of each of their degrees of freedom.
    pub coordinates: Vec<CoordinateAtBreak>,
    /// All degrees of freedom of the map.
    pub dof: usize,
    /// All coordinates that jump.
    pub jumping: usize,
    /// All momenta that do.
    pub jumping_p: usize,
    /// The time that leads from one side to the other along the flow of the map, if there is one.
    pub along_flow: Option<BreakAlongFlow>,
    /// The degree of freedom that led to the break.
    pub of_break: usize,
    /// Its states at this break and at further ones.
    pub places: Vec<PositionAtBreak>,
}

/// One coordinate at a break.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoordinateAtBreak {
    /// `q` or `p`.
    pub coordinate: char,
    /// The degree of freedom.
    pub dof: usize,
    /// Its value on the loop before the step.
    pub before: f64,
    /// Its values after the step, for s below that of the break and above.
    pub after: [f64; 2],
    /// Whether it jumps by more than the rounding of its values.
    pub jumps: bool,
    /// On which side its value is the same, to the last bit, at states that differ.
    pub constant: [bool; 2],
    /// Its range after the largest step, as far as samples of the given loop show it; 0 if it is not known.
    #[serde(default)]
    pub range: f64,
    /// Half its range on the loop, or what tests take for it if the loop leaves it at rest.
    pub radius: f64,
}

/// A break whose one side the map takes to the other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BreakAlongFlow {
    /// The step size that does so, as a part of h.
    pub part: f64,
    /// By how much it misses the other side, as a part of the jump.
    pub distance: f64,
}

/// The state of the degree of freedom that jumps at a break.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PositionAtBreak {
    /// The position before the step.
    pub before: f64,
    /// The momentum before it, with the weight of the coordinates taken out.
    pub velocity: f64,
    /// The position after it, in the middle between both sides.
    pub after: f64,
    /// The jump of the position.
    pub jump_q: f64,
}

impl BreakSides {
    /// One of the coordinates.
    pub(crate) fn coordinate(&self, coordinate: char, dof: usize) -> Option<&CoordinateAtBreak> {
        let mut all = self.coordinates.iter();
        all.find(|of| of.coordinate == coordinate && of.dof == dof)
    }
}

impl CoordinateAtBreak {
    /// The value above the break less the one below.
    pub(crate) fn jump(&self) -> f64 {
        self.after[1] - self.after[0]
    }

    /// The value in the middle between both sides.
    pub(crate) fn middle(&self) -> f64 {
        0.5 * (self.after[0] + self.after[1])
    }
}
