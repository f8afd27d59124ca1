//! Results about the map apart from loop integrals.

use serde::{Deserialize, Serialize};

use crate::error::Error;

/// Results about the map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Survey {
    /// How coarsely the map rounds the states that it returns, if it does more than double precision does.
    pub output_precision: Option<OutputPrecision>,
    /// Whether the map works in single precision inside, whatever it returns.
    #[serde(default)]
    pub single_inside: bool,
    /// Whether all samples of the given loop came out at one state.
    #[serde(default)]
    pub one_state: bool,
    /// A coordinate that the largest step sets to one value at some samples of the given loop.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held: Option<HeldCoordinate>,
    /// The relative rounding error of the states, if it was stated and is above that of double precision.
    #[serde(default)]
    pub stated_roundoff: Option<f64>,
    /// By how much results of one state differ, if they do.
    #[serde(default)]
    pub scatter: Option<Scatter>,
    /// Whether a state has the same result at all step sizes.
    #[serde(default)]
    pub ignores_step_size: bool,
    /// Whether the Jacobian of a step is singular at points of the given loop. It is tested if random loops or the
    /// Jacobian show a defect that the given loop does not have.
    #[serde(default)]
    pub singular: Option<SingularJacobian>,
    /// The rank of the symplectic form on the manifold of a map in non-canonical coordinates, if the form is degenerate there.
    #[serde(default)]
    pub degenerate_form: Option<Rank>,
    /// How far the largest step moves states off the manifold, or off the leaf, to which their projection keeps them, in units of the
    /// loop's radii, if it is more than a bound may be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub off_manifold: Option<f64>,
    /// A stated period that is not one of the map: no random loop winds round it.
    #[serde(default)]
    pub wrong_period: Option<WrongPeriod>,
}

/// A coordinate that has one value after the step, to the last bit, at states which differ before it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldCoordinate {
    /// `'q'` or `'p'`.
    pub coordinate: char,
    /// Degree of freedom.
    pub dof: usize,
    /// The value.
    pub value: f64,
    /// The part of the samples, next to each other, that have it.
    pub part: f64,
    /// The loop parameter of the middle one of them.
    pub s: f64,
}

/// A stated period P that is not one of the map: Φ(q + P, p) differs from Φ(q, p) + (P, 0).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WrongPeriod {
    /// `'q'` or `'p'`.
    pub coordinate: char,
    /// Degree of freedom.
    pub dof: usize,
    /// The stated period.
    pub period: f64,
    /// The largest difference of a coordinate.
    pub difference: f64,
}

impl WrongPeriod {
    /// As an error, if a loop cannot do without this period.
    pub(crate) fn into_error(self) -> Error {
        Error::NotAPeriod {
            coordinate: self.coordinate,
            dof: self.dof,
            period: self.period,
            difference: self.difference,
        }
    }
}

impl Survey {
    /// Whether states, or what they come of, have fewer digits than double precision.
    pub fn is_rounded(&self) -> bool {
        self.output_precision.is_some() || self.single_inside || self.stated_roundoff.is_some()
    }
}

/// Results of one state differ, and nothing explains it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scatter {
    /// `'q'` or `'p'`: the coordinate that scatters most, relative to its range on the loop.
    pub coordinate: char,
    /// Degree of freedom.
    pub dof: usize,
    /// The standard deviation; the largest difference, if results differ rarely, or by rounding.
    pub size: f64,
    /// Its cause.
    #[serde(default)]
    pub kind: ScatterKind,
}

impl Scatter {
    /// Whether the step draws random numbers.
    pub fn is_random(&self) -> bool {
        self.kind == ScatterKind::RandomNumbers
    }
}

/// Why results of one state differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ScatterKind {
    /// Rounding that depends on the batch: matrix products add up in another order.
    Rounding,
    /// Noise: parallel sums, or a solver that starts at random.
    #[default]
    Noise,
    /// Noise that is larger than rounding in single precision: random numbers, or something kept from earlier calls.
    RandomNumbers,
}

/// A Jacobian with a direction that the step projects away, as for a map onto a constraint manifold. In canonical
/// units: of a symplectic map singular values come in pairs σ and 1/σ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SingularJacobian {
    /// The loop parameter of the point.
    pub s: f64,
    /// The smallest singular value.
    pub smallest: f64,
    /// The largest one.
    pub largest: f64,
    /// Their uncertainty.
    pub uncertainty: f64,
    /// The rank of the Jacobian, if the symplectic form is degenerate on its image: the map is then symplectic on no manifold.
    #[serde(default)]
    pub degenerate: Option<Rank>,
}

impl SingularJacobian {
    /// The smallest singular value; 0 if it is rounding of the largest. Their squares were computed: what rounding makes of one that is 0
    /// depends on the processor.
    pub(crate) fn known_smallest(&self) -> f64 {
        let is_rounding = self.smallest <= f64::EPSILON.sqrt() * self.largest;
        if is_rounding { 0.0 } else { self.smallest }
    }
}

/// The rank of a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rank {
    /// The rank.
    pub rank: usize,
    /// The rank of a regular one.
    pub of: usize,
}

/// Returned states that have fewer digits than double precision, where those before the step have not.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutputPrecision {
    /// `'q'` or `'p'`.
    pub coordinate: char,
    /// Degree of freedom.
    pub dof: usize,
    /// The numbers that it returns.
    pub format: OutputFormat,
    /// The distance of neighbouring values.
    pub unit: f64,
}

/// Formats of numbers with few digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutputFormat {
    /// Decimal numbers of this number of significant digits.
    Decimal {
        /// Digits.
        digits: usize,
    },
    /// Multiples of the unit.
    Multiples,
    /// Single precision.
    Single,
    /// Binary numbers of this number of significant digits: 11 of half precision, 8 of bfloat16.
    Binary {
        /// Digits.
        digits: usize,
    },
}
