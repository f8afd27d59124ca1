//! Measurements of a force or a vector field.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::limits::{MAX_SOLVER_TOLERANCE, MIN_CURL};
use crate::signal::SIGNIFICANT;

/// The kind of function under test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FieldKind {
    /// A force F(q): is it a gradient?
    Force,
    /// A vector field (q, p)' = f(q, p): is it Hamiltonian?
    Field,
}

/// A position or a momentum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CoordinateName {
    /// `'q'` or `'p'`.
    pub coordinate: char,
    /// Degree of freedom.
    pub dof: usize,
}

impl CoordinateName {
    /// Coordinate c, positions first.
    pub(super) fn of(c: usize, dof: usize) -> Self {
        CoordinateName {
            coordinate: if c < dof { 'q' } else { 'p' },
            dof: c % dof,
        }
    }
}

impl fmt::Display for CoordinateName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}[{}]", self.coordinate, self.dof)
    }
}

/// Which loop it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FieldLoopKind {
    /// A random loop of three Fourier modes around the centre.
    Random,
    /// A small ellipse along two random directions.
    Directions,
    /// A small circle in the plane of two coordinates, in units of their radii.
    Coordinates {
        /// The first.
        first: CoordinateName,
        /// The second.
        second: CoordinateName,
    },
    /// A loop on which one position gains its period.
    Winding {
        /// The degree of freedom.
        dof: usize,
    },
}

/// The integral of a force along a loop: ∮ F·dq, or ∮ (f_q·dp − f_p·dq) with the weights of the momenta.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopWork {
    /// Which loop it is.
    pub kind: FieldLoopKind,
    /// Samples that the integral was computed from.
    pub samples: usize,
    /// The integral, in units of force × position.
    pub integral: f64,
    /// Its uncertainty because the number of samples is finite.
    pub quadrature_error: f64,
    /// Its uncertainty because of rounding and the noise of the force.
    pub noise: f64,
    /// The size that the integral would have if the force were a rotation everywhere, with no gradient in it.
    pub scale: f64,
    /// Whether the force is the same on all of the loop, to rounding.
    pub is_constant: bool,
    /// Whether the quadrature error is below the noise.
    pub is_resolved: bool,
    /// How far the power of the force jumps along the loop, if it does, in the same units.
    pub jumps: Option<f64>,
    /// The parameter s of a jump that bisection found, if the integral is not zero.
    pub jump_at: Option<f64>,
    /// Whether bisection showed a steep part of the force that samples do not resolve instead.
    pub is_steep: bool,
    /// ∮ p·dq of the loop, with the weights; 0 for forces.
    pub action: f64,
}

impl LoopWork {
    /// Half the width of the interval in which the integral lies.
    pub fn error(&self) -> f64 {
        self.quadrature_error + self.noise
    }

    /// Whether the integral is not zero, but for what rounded constants of the force make of it.
    pub(super) fn is_clear(&self) -> bool {
        self.integral.abs() > SIGNIFICANT * self.error() && self.relative() > MIN_CURL
    }

    /// The integral over the scale.
    pub fn relative(&self) -> f64 {
        ratio(self.integral.abs(), self.scale)
    }

    /// An upper bound on the relative integral.
    pub fn bound(&self) -> f64 {
        ratio(self.integral.abs() + self.error(), self.scale)
    }
}

/// a/b, and 0 of 0/0.
fn ratio(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a / b }
}

/// λ = ‖A‖/‖J‖: the antisymmetric part A of the Jacobian J of the force in units of the radii, in Frobenius norms.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curl {
    /// λ, from 0 to 1.
    pub value: f64,
    /// Half the width of the interval in which it lies: errors of the integrals, and the scatter of random pairs.
    pub error: f64,
    /// Pairs of directions.
    pub pairs: usize,
    /// Whether they are all pairs of coordinates.
    pub all: bool,
}

/// Two coordinates of which the force has a curl.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorstPair {
    /// The first.
    pub first: CoordinateName,
    /// The second.
    pub second: CoordinateName,
    /// ∂G_second/∂(first) − ∂G_first/∂(second) of the one-form G: F, or −f_p and f_q with the weights. Its average over a small disc.
    pub curl: f64,
    /// Half the width of the interval in which it lies.
    pub error: f64,
}

/// Everything that was measured of a force or a vector field.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FieldEvidence {
    /// The kind of function.
    pub kind: FieldKind,
    /// Degrees of freedom.
    pub dof: usize,
    /// Coordinates that loops move.
    pub moving: usize,
    /// The smallest and the largest radius of these.
    pub radius: (f64, f64),
    /// Whether a position is periodic.
    pub is_periodic: bool,
    /// The standard deviation of the force over short distances, relative to its change along a loop. It is not larger than
    /// rounding if it is below 1e-15.
    pub noise: f64,
    /// The largest difference of the force at positions that were evaluated again, relative in the same way.
    pub repetitions: f64,
    /// Random loops, loops around periods, and pairs of directions.
    pub loops: Vec<LoopWork>,
    /// λ, if pairs were tested and the force changes.
    pub curl: Option<Curl>,
    /// The two coordinates with the largest curl that was found, if it is not zero.
    pub worst: Option<WorstPair>,
    /// The rate γ by which a vector field damps uniformly, with its error, if all loops show the same one.
    pub damping: Option<(f64, f64)>,
    /// Whether larger loops were searched for jumps of a solver, which is done if all that speaks against a gradient is small.
    pub is_searched: bool,
    /// Parts of the test that the budget did not allow.
    pub omitted: Vec<OmittedPart>,
    /// States at which the force was evaluated.
    pub evaluations: usize,
    /// The most that were allowed.
    pub budget: usize,
}

impl FieldEvidence {
    /// The largest jump of the power along a random loop, relative to its scale; 0 without jumps.
    pub(super) fn jumps(&self) -> f64 {
        let random = self.loops.iter();
        let random = random.filter(|work| work.kind == FieldLoopKind::Random);
        let jumps = random.filter_map(|work| Some(work.jumps? / work.scale));
        jumps.fold(0.0, f64::max)
    }

    /// Whether some loop integral is not zero, but all are as small as an iteration that stops at a tolerance leaves them.
    pub(super) fn is_small(&self) -> bool {
        let mut clear = self.loops.iter().filter(|work| work.is_clear()).peekable();
        clear.peek().is_some() && clear.all(|work| work.relative() < MAX_SOLVER_TOLERANCE)
    }
}

/// A part of the test that was left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OmittedPart {
    /// Random loops.
    Loops {
        /// How many.
        count: usize,
    },
    /// Pairs of directions.
    Pairs,
    /// Loops around periods of some positions.
    Periods {
        /// How many positions.
        count: usize,
    },
}
