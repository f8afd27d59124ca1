//! The true defect of loops with kinks, and with it the error of the rule that the paper takes.
//!
//! The pseudospectral rule's own estimate bounds its error on such loops, but may be hundreds of times too
//! large. The piecewise rule cuts the loop at its kinks and comes close to round-off, so that the difference of
//! both is the error itself.

use std::collections::HashMap;

use symplint::rules::Piecewise;
use symplint::{Loop, TimeAdvance};

use super::error::PaperError;
use super::estimate::Estimate;
use super::sweep::Record;

/// Relative change of the true loop integral in one step.
#[derive(Clone, Copy, Debug)]
pub struct TrueDefect {
    /// (I(h) − I(0)) / |I(0)|.
    pub signed: f64,
    /// How far off it may be.
    pub error: f64,
}

/// Most degrees of freedom of a loop that is cheap enough to be cut twice.
const MAX_DOF_OF_TWO_CUTS: usize = 16;

/// Measures the true defect of every record, once for each step size.
pub fn measure(
    map: &dyn TimeAdvance,
    phase_loop: &dyn Loop,
    records: &mut [Record],
) -> Result<(), PaperError> {
    let mut found: HashMap<u64, TrueDefect> = HashMap::new();
    for record in records {
        let defect = match found.get(&record.step_size.to_bits()) {
            Some(defect) => *defect,
            None => of_step(map, phase_loop, record)?,
        };
        found.insert(record.step_size.to_bits(), defect);
        record.true_defect = Some(defect.signed);
        record.true_defect_error = Some(defect.error);
    }
    Ok(())
}

/// The true defect of one step. I(0) is that of the record: on a circle, which is smooth, its rule is as good as
/// exact.
fn of_step(
    map: &dyn TimeAdvance,
    phase_loop: &dyn Loop,
    record: &Record,
) -> Result<TrueDefect, PaperError> {
    let few = phase_loop.dof() <= MAX_DOF_OF_TWO_CUTS;
    // Among the kinks of hundreds of particles, finer differences drown in the round-off of the forces.
    let tolerance = if few { 1e-13 } else { 1e-9 };
    let integral = |pieces| {
        let rule = Piecewise {
            tolerance,
            pieces,
            ..Piecewise::default()
        };
        let found = rule.integrate(map, phase_loop, record.step_size)?;
        Ok::<_, PaperError>(found.continuous)
    };
    let advanced = integral(4)?;
    let mut error = advanced.quadrature_error.unwrap_or(f64::INFINITY);
    if few {
        // Other cuts put every node elsewhere; the rule's own estimate bounds what a kink could cost.
        let difference = integral(7)?.value - advanced.value;
        error = error.min(10.0 * difference.abs());
    }
    Ok(TrueDefect {
        signed: (advanced.value - record.initial) / record.initial.abs(),
        error: (error + advanced.roundoff) / record.initial.abs() + record.roundoff,
    })
}

/// The largest size that the true defects of `records` may have; infinite where they are not known.
pub fn largest<'a>(records: impl IntoIterator<Item = &'a Record>) -> f64 {
    (records.into_iter())
        .map(|r| match (r.true_defect, r.true_defect_error) {
            (Some(signed), Some(error)) => signed.abs() + error,
            _ => f64::INFINITY,
        })
        .fold(0.0, f64::max)
}

/// The largest error of the rule itself over `records`; none where one is not known.
pub fn largest_error<'a>(records: impl IntoIterator<Item = &'a Record>) -> Option<Estimate> {
    (records.into_iter())
        .map(Record::rule_error)
        .reduce(|a, b| Some(a?.max(b?)))
        .flatten()
}
