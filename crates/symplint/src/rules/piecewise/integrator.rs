//! The piecewise rule in a diagnosis: pieces in addition to equispaced samples, which show what pieces may miss.

use super::{Closure, Piecewise, PiecewiseIntegral};
use crate::breaks::{SearchResult, little_jumps, rows_that_may_jump};
use crate::error::Error;
use crate::map::{Capabilities, EvaluationCount, Evaluator, StepFailure, TimeAdvance};
use crate::rules::sampled::{cells_apart, jumps, ranges_of};
use crate::rules::{
    BreakClosure, Defect, LoopAfterStep, LoopIntegral, LoopIntegrator, RuleKind, Samples, Subject,
};
use crate::state::{Block, Coordinates};

impl LoopIntegrator for Piecewise {
    fn kind(&self) -> RuleKind {
        RuleKind::Piecewise
    }

    fn before(&self, subject: &Subject<'_>, samples: Samples<'_>) -> Result<LoopIntegral, Error> {
        let count = EvaluationCount::unlimited();
        let rest = Identity(subject.coordinates());
        let rest = Evaluator::new(&rest, &count)?;
        let samples = Some(samples.kept());
        let pieces = self.unlimited();
        let pieces = pieces.integrate_beside(&rest, subject.phase_loop, 1.0, samples)?;
        Ok(pieces.continuous)
    }

    /// A few pieces can miss narrow features. The equispaced samples, many more of them in small systems,
    /// show them.
    fn after(
        &self,
        subject: &Subject<'_>,
        h: f64,
        samples: Samples<'_>,
        initial: &LoopIntegral,
    ) -> Result<LoopAfterStep, Error> {
        let after = samples.kept();
        let pieces =
            self.integrate_beside(subject.evaluator, subject.phase_loop, h, Some(after))?;
        let mut closed = pieces.closed();
        let samples = pieces.nodes();
        let PiecewiseIntegral {
            continuous: mut integral,
            mut breaks,
            closing,
            flickering,
            insubstantial,
            bend,
            ..
        } = pieces;
        let mut little = 0.0;
        let rows = rows_that_may_jump(after, subject.coordinates());
        if !breaks.is_empty() {
            let known: Vec<f64> = breaks.iter().map(|found| found.s).collect();
            little = little_jumps(after, subject.coordinates(), &known, &rows);
        }
        let mut ranges = vec![None; after.dof()];
        let broken = breaks.iter().any(|found| {
            let ranges = ranges[found.dof].get_or_insert_with(|| ranges_of(after, found.dof));
            found.is_substantial(*ranges)
        });
        // Small jumps alone break no loop.
        if !broken {
            breaks.clear();
            little += insubstantial;
        }
        if breaks.is_empty() {
            let search = jumps(subject, h, after, &rows)?;
            little = little.max(search.little);
            if search.found != SearchResult::Clean {
                (integral.quadrature_error, closed.quadrature_error) = (None, None);
            }
            if let SearchResult::Found(found) = search.found {
                breaks.push(found);
            }
        }
        integral.quadrature_error = integral.quadrature_error.map(|error| error + little);
        Ok(LoopAfterStep {
            defect: Defect::between(initial, &integral)?,
            regularity: integral.regularity,
            closed: Some(BreakClosure {
                breaks: breaks.len(),
                flickering,
                chord: closing.iter().sum(),
                defect: Defect::between(initial, &closed)?,
                bend: bend / initial.value.abs(),
                straight: self.closure == Closure::Chords || subject.evaluator.substeps() == 1,
            }),
            integral,
            breaks,
            samples,
            cells_apart: cells_apart(after, subject.coordinates()),
        })
    }
}

/// The map that leaves every state where it is.
pub(crate) struct Identity<'a>(pub &'a Coordinates);

impl TimeAdvance for Identity<'_> {
    fn dof(&self) -> usize {
        self.0.dof()
    }
    fn advance(&self, _h: f64, _block: &mut Block<'_>) -> Result<(), StepFailure> {
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities::of_coordinates(self.0.clone())
    }
}
