//! The integral of a loop from those of its degrees of freedom.

use super::{LoopIntegral, least};
use crate::error::Error;
use crate::signal::CompensatedSum;

impl LoopIntegral {
    /// Adds integrals over one degree of freedom or some, all of one loop: codes whose state is spread over processes
    /// integrate where the rows lie. Momenta were multiplied by their weights already.
    ///
    /// The result depends on the order of the parts, which has to be that of the degrees of freedom, and with one part for
    /// each of them on nothing else. `value` is then that of [`LoopIntegral::in_coordinates`] for the whole
    /// loop, to the last bit, and so is `roundoff` but for its own rounding. The parts must all be of one rule.
    ///
    /// # Errors
    /// If there are no integrals, or the integral overflows.
    ///
    /// ```
    /// use symplint::{Circle, Ensemble, LoopIntegral, Phases, Rule};
    ///
    /// let of = |q: f64| -> Result<LoopIntegral, symplint::Error> {
    ///     let row = Ensemble::sample(&Circle::new(vec![q], vec![0.1], 0.7)?, 64)?;
    ///     LoopIntegral::of(&row, &Rule::Pseudospectral)
    /// };
    /// let whole = Circle::new(vec![0.3, 4.0], vec![0.1; 2], 0.7)?.with_phases(Phases::Equal);
    /// let whole = Ensemble::sample(&whole, 64)?;
    /// let whole = LoopIntegral::of(&whole, &Rule::Pseudospectral)?;
    /// let merged = LoopIntegral::merged(&[of(0.3)?, of(4.0)?])?;
    /// assert_eq!(merged.value, whole.value);
    /// assert!((merged.roundoff / whole.roundoff - 1.0).abs() < 1e-14);
    /// # Ok::<(), symplint::Error>(())
    /// ```
    pub fn merged(parts: &[LoopIntegral]) -> Result<Self, Error> {
        let Some(first) = parts.first() else {
            return Err(Error::OutOfRange {
                what: "number of parts of a loop integral",
                value: 0.0,
                remedy: "give one or more",
            });
        };
        let mut total = LoopIntegral {
            value: 0.0,
            contributions: Vec::with_capacity(parts.len()),
            quadrature_error: Some(0.0),
            roundoff: 0.0,
            scale: 0.0,
            omitted: first.omitted.is_some().then(Vec::new),
            regularity: None,
        };
        let mut value = CompensatedSum::default();
        for part in parts {
            for &contribution in &part.contributions {
                value.add(contribution);
                total.contributions.push(contribution);
            }
            total.quadrature_error =
                (total.quadrature_error.zip(part.quadrature_error)).map(|(sum, error)| sum + error);
            // The rounding of the value of a part, which the sum of all contributions does not have.
            total.roundoff += (part.roundoff - f64::EPSILON * part.value.abs()).max(0.0);
            total.scale += part.scale;
            total.regularity = least(total.regularity, part.regularity);
            if let (Some(omitted), Some(of_part)) = (&mut total.omitted, &part.omitted) {
                let before = total.contributions.len() - part.contributions.len();
                omitted.extend(of_part.iter().map(|cell| super::OmittedCell {
                    dof: before + cell.dof,
                    ..*cell
                }));
            }
        }
        total.value = value.total();
        total.roundoff += f64::EPSILON * total.value.abs();
        if !(total.value.is_finite() && total.scale.is_finite()) {
            let infinite = |value: &f64| !value.is_finite();
            return Err(Error::Overflow {
                dof: total.contributions.iter().position(infinite).unwrap_or(0),
                value: total.value,
            });
        }
        Ok(total)
    }
}
