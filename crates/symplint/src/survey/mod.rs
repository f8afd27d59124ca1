//! What a few samples show of a map, apart from loop integrals.

mod deformation;
mod precision;
mod purity;

pub(crate) use deformation::{motion, winds};
pub(crate) use purity::check_purity;

use crate::error::Error;
use crate::evidence::Survey;
use crate::rules::Subject;
use crate::state::Ensemble;
use deformation::Deformation;
use precision::Precision;

/// Samples that the survey looks at, of those that were advanced anyway.
const SAMPLES: usize = 64;

/// Samples that are advanced for the survey alone, where no others stay in memory.
const FEW_SAMPLES: usize = 32;

/// Surveys the map by samples of a loop that were advanced.
pub(crate) fn of_samples(subject: Subject<'_>, after: &Ensemble) -> Survey {
    let every = after.samples().div_ceil(SAMPLES);
    let columns: Vec<usize> = (0..after.samples()).step_by(every).collect();
    let s: Vec<f64> = (columns.iter())
        .map(|&k| k as f64 / after.samples() as f64)
        .collect();
    let dof = after.dof();
    let mut before = Ensemble::zeros(dof, s.len());
    subject.phase_loop.sample(&s, &mut before.block());
    let mut picked = Ensemble::zeros(dof, s.len());
    let mut block = picked.block();
    for i in 0..dof {
        for (value, &k) in block.q.row_mut(i).iter_mut().zip(&columns) {
            *value = after.q().row(i)[k];
        }
        for (value, &k) in block.p.row_mut(i).iter_mut().zip(&columns) {
            *value = after.p().row(i)[k];
        }
    }
    let mut deformation = Deformation::new(dof);
    deformation.add(&before, &picked, subject.coordinates());
    let mut precision = Precision::new(dof);
    precision.add(&before, &picked);
    Survey {
        deformation: deformation.value(),
        output_precision: precision.value(),
    }
}

/// Surveys the map by a few samples, advanced for that alone: in so many degrees of freedom that none stay in
/// memory.
///
/// # Errors
/// Those of the map.
pub(crate) fn of_few_samples(subject: Subject<'_>, h: f64) -> Result<Survey, Error> {
    let dof = subject.dof();
    let (mut deformation, mut precision) = (Deformation::new(dof), Precision::new(dof));
    Ensemble::in_parts(subject.phase_loop, FEW_SAMPLES, |before| {
        let mut after = before.clone();
        subject.evaluator.advance(&mut after, h)?;
        deformation.add(&before, &after, subject.coordinates());
        precision.add(&before, &after);
        Ok(())
    })?;
    Ok(Survey {
        deformation: deformation.value(),
        output_precision: precision.value(),
    })
}
