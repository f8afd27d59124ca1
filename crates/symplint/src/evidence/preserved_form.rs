//! Whether a map that is not symplectic preserves another constant two-form.

use serde::{Deserialize, Serialize};

/// The search for a constant two-form Ω that a step preserves: MᵀΩM = Ω for its Jacobian M at every state.
///
/// Coordinates are counted from 0, all positions first, then all momenta, as the map has them: without weights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PreservedForm {
    /// The step size h; `None` for a map without one.
    pub step_size: Option<f64>,
    /// Degrees of freedom d.
    pub dof: usize,
    /// Whether all constant forms were tried; otherwise those of weights and signs, Σ c_i dq_i∧dp_i.
    pub all_constant: bool,
    /// Whether forms with a magnetic field that is a polynomial in q were tried, after no constant form was preserved.
    #[serde(default)]
    pub with_fields: bool,
    /// Whether the step is linear: its Jacobian is the same at all states.
    #[serde(default)]
    pub is_linear: bool,
    /// For linear steps: the number of digits of the matrix, if it is small and rounding to it explains the defect.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub digits_of_matrix: Option<DigitsOfMatrix>,
    /// States whose Jacobians were used.
    pub states: usize,
    /// The answer: `None` if the Jacobians are not precise enough for one.
    pub exists: Option<bool>,
    /// Without a preserved form: by how much the form that comes nearest changes, in units of the loop and relative to its largest entry.
    /// `None` if forms Σ c dq∧dp are preserved in which a weight c is 0.
    pub change: Option<f64>,
    /// The entries of the form that are not 0, by their coordinates.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub entries: Vec<FormEntry>,
    /// Groups of coordinates with no motion in common: the factor of the form of each group is free.
    pub groups: usize,
    /// What loops show of the form.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loops: Vec<FormOnLoop>,
}

/// The digits of the entries of a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DigitsOfMatrix {
    /// This number of digits after the point.
    Decimals(i32),
    /// This number of significant digits.
    Significant(i32),
}

/// A term of a form Ω: its value times dz_a∧dz_b, a < b; or times d(z_a q0^k q1^l q2^m dz_b)/(1 + m_a) if it has powers of q: the part of
/// a closed form that begins with q0^k q1^l q2^m dz_a∧dz_b. Here m_a is the power of z_a.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FormEntry {
    /// The coordinates a and b.
    pub coordinates: [usize; 2],
    /// The powers k, l, m of q0, q1 and q2.
    #[serde(default, skip_serializing_if = "is_constant")]
    pub powers: [u8; 3],
    /// Its value, rounded to the digits that its error supports.
    pub value: f64,
    /// The error before rounding.
    pub error: f64,
    /// The group of coordinates to which it belongs.
    pub group: usize,
}

/// The change of two loop integrals in one step, each with its uncertainty, relative to the sum of the sizes of all terms of the
/// integral.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FormOnLoop {
    /// Which loop: 0 is the given one.
    pub loop_index: usize,
    /// Of the canonical form, with the weights of the coordinates.
    pub canonical: [f64; 2],
    /// Of the preserved form.
    pub preserved: [f64; 2],
}

fn is_constant(powers: &[u8; 3]) -> bool {
    *powers == [0; 3]
}

/// The product of powers of the first coordinates.
pub(crate) fn monomial(powers: [u8; 3], q: impl Fn(usize) -> f64) -> f64 {
    let of_q = powers.iter().enumerate().filter(|(_, power)| **power > 0);
    of_q.map(|(i, power)| q(i).powi((*power).into())).product()
}

/// The largest relative error of an entry, rounding at least: loops that one entry contributes little to do not show it. Entries with six
/// digits fewer than their errors support have no error: they are numbers that a person chose.
pub(crate) fn uncertain_part(entries: &[FormEntry]) -> f64 {
    const FEWER: f64 = 1e-6;
    let error = |of: &FormEntry| {
        let error = of.relative_error();
        let number = format!("{:e}", of.value.abs());
        let digits = number
            .chars()
            .take_while(|c| *c != 'e')
            .filter(char::is_ascii_digit);
        match error < FEWER * 10f64.powi(-(digits.count() as i32)) {
            true => 0.0,
            false => error,
        }
    };
    entries.iter().map(error).fold(f64::EPSILON, f64::max)
}

impl FormOnLoop {
    /// The largest change that the preserved form may have.
    pub(crate) fn bound(&self) -> f64 {
        self.preserved[0].abs() + self.preserved[1]
    }
}

impl FormEntry {
    /// The error, relative.
    pub(crate) fn relative_error(&self) -> f64 {
        self.error / self.value.abs()
    }
}
