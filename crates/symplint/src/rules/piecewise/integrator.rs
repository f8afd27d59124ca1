//! The piecewise rule in a diagnosis: pieces beside equispaced samples, which show what pieces may miss.

use super::{Piecewise, PiecewiseIntegral};
use crate::error::Error;
use crate::map::{EvaluationCount, Evaluator, StepFailure, TimeAdvance};
use crate::rules::sampled::{cells_apart, is_substantial, substantial_break};
use crate::rules::{
    Advanced, Closed, Defect, LoopIntegral, LoopIntegrator, Rule, RuleKind, Samples, Subject,
};
use crate::state::{Block, Coordinates, Ensemble};

impl LoopIntegrator for Piecewise {
    fn kind(&self) -> RuleKind {
        RuleKind::Piecewise
    }

    fn before(&self, subject: &Subject<'_>, samples: Samples<'_>) -> Result<LoopIntegral, Error> {
        let (before, coordinates) = (samples.kept(), subject.coordinates());
        let count = EvaluationCount::unlimited();
        let rest = Identity(coordinates);
        let rest = Evaluator::new(&rest, &count)?;
        let pieces = Piecewise::unlimited(self).integrate_beside(
            &rest,
            subject.phase_loop,
            1.0,
            Some(before),
        )?;
        let mut initial = pieces.continuous;
        widen_for_spikes(&mut initial, before, coordinates, false)?;
        Ok(initial)
    }

    /// A few pieces can miss narrow features. The equispaced samples, many more of them in small systems,
    /// show them.
    fn after(
        &self,
        subject: &Subject<'_>,
        h: f64,
        samples: Samples<'_>,
        initial: &LoopIntegral,
    ) -> Result<Advanced, Error> {
        let (after, coordinates) = (samples.kept(), subject.coordinates());
        let pieces =
            self.integrate_beside(subject.evaluator, subject.phase_loop, h, Some(after))?;
        let mut closed = pieces.closed();
        let samples = pieces.nodes();
        let PiecewiseIntegral {
            continuous: mut integral,
            mut breaks,
            place_error,
            closing,
            ..
        } = pieces;
        breaks.retain(|found| is_substantial(found, after));
        if breaks.is_empty()
            && let Some(found) = substantial_break(subject, h, after)?
        {
            integral.quadrature_error = None;
            breaks.push(found);
        }
        // What the samples add to the error belongs to the closed integral, too; the positions of breaks do not.
        let own_error = integral.quadrature_error;
        let regularity = widen_for_spikes(&mut integral, after, coordinates, !breaks.is_empty())?;
        closed.quadrature_error = match integral.quadrature_error {
            Some(error) if Some(error) == own_error => Some((error - place_error).max(0.0)),
            other => other,
        };
        Ok(Advanced {
            defect: Defect::between(initial, &integral)?,
            regularity,
            closed: Some(Closed {
                breaks: breaks.len(),
                chord: closing.iter().sum(),
                defect: Defect::between(initial, &closed)?,
            }),
            integral,
            breaks,
            samples,
            cells_apart: cells_apart(after, coordinates),
        })
    }
}

/// Returns the regularity that samples show and, where it is that of unresolved spikes, widens the error of the
/// `integral` by pieces to its distance from that of the samples: another spike may lie between two samples where
/// no piece has met it. Of many breaks the coefficients look alike, but those are known.
fn widen_for_spikes(
    integral: &mut LoopIntegral,
    samples: &Ensemble,
    coordinates: &Coordinates,
    broken: bool,
) -> Result<Option<f64>, Error> {
    let of_samples = LoopIntegral::in_coordinates(samples, &Rule::Pseudospectral, coordinates)?;
    if !broken && of_samples.regularity.is_some_and(|s| s < SPIKES) {
        let distance = (of_samples.value - integral.value).abs();
        let errors = integral.quadrature_error.zip(of_samples.quadrature_error);
        integral.quadrature_error = errors.map(|(own, other)| own.max(distance + other));
    }
    Ok(of_samples.regularity)
}

/// Sobolev exponents below this are those of unresolved spikes: half way between a spike, whose Fourier
/// coefficients do not decay (s = −½), and a jump (s = ½), with room for the fit. Calibrated on the truth table.
const SPIKES: f64 = 0.25;

/// The map that leaves every state where it is.
pub(crate) struct Identity<'a>(pub &'a Coordinates);

impl TimeAdvance for Identity<'_> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn advance(&self, _h: f64, _block: &mut Block<'_>) -> Result<(), StepFailure> {
        Ok(())
    }
    fn coordinates(&self) -> Coordinates {
        self.0.clone()
    }
}
