//! What every rule does: integrate a loop before and after a step.

use super::{Defect, LoopIntegral, RuleKind};
use crate::breaks::Break;
use crate::error::Error;
use crate::loops::Loop;
use crate::map::{Evaluator, Grain};
use crate::state::{Coordinates, Ensemble, coordinate};

/// The subject of a test: a map and a loop to send through it.
#[derive(Clone, Copy)]
pub(crate) struct Subject<'a> {
    pub evaluator: &'a Evaluator<'a>,
    pub phase_loop: &'a dyn Loop,
}

impl<'a> Subject<'a> {
    /// Degrees of freedom of the loop.
    pub fn dof(&self) -> usize {
        self.phase_loop.dof()
    }

    /// The same map on another loop, if there is one.
    pub fn on<'b>(self, other: Option<&'b impl Loop>) -> Subject<'b>
    where
        'a: 'b,
    {
        Subject {
            phase_loop: other.map_or(self.phase_loop, |other| other),
            ..self
        }
    }

    /// Periods, weights and grid of the map.
    pub fn coordinates(&self) -> &'a Coordinates {
        self.evaluator.coordinates()
    }

    /// Samples that are advanced to learn the grain of the map, if no others stay in memory.
    pub const SAMPLES_OF_GRAIN: usize = 32;

    /// Learns the grain of the map on this loop from a few samples, if it is not known and the budget allows it.
    ///
    /// # Errors
    /// Those of the map.
    pub fn learn_grain(&self, h: f64) -> Result<(), Error> {
        let samples = Self::SAMPLES_OF_GRAIN;
        let evaluator = self.evaluator;
        let affordable = Grain::is_affordable(self.dof()) && evaluator.count().left() >= samples;
        if evaluator.grain().is_none() && affordable {
            let mut after = Ensemble::sample(self.phase_loop, samples)?;
            evaluator.advance(&mut after, h)?;
            evaluator.learn_grain(self.phase_loop, samples, |c, k| coordinate(&after, c)[k]);
        }
        Ok(())
    }
}

/// Equispaced samples of a loop.
#[derive(Clone, Copy)]
pub(crate) enum Samples<'a> {
    /// In memory.
    Kept(&'a Ensemble),
    /// Only their number: a rule that does not keep samples makes them.
    Count(usize),
}

impl<'a> Samples<'a> {
    /// How many they are.
    pub fn count(self) -> usize {
        match self {
            Samples::Kept(ensemble) => ensemble.samples(),
            Samples::Count(count) => count,
        }
    }

    /// The states.
    ///
    /// # Panics
    /// If they are not in memory, which rules that keep samples ask for.
    pub fn kept(self) -> &'a Ensemble {
        match self {
            Samples::Kept(ensemble) => ensemble,
            Samples::Count(_) => panic!("a rule that keeps samples is given samples"),
        }
    }
}

/// One rule at work.
pub(crate) trait LoopIntegrator {
    /// Which rule it is.
    fn kind(&self) -> RuleKind;

    /// Whether it is given samples in memory.
    fn keeps_samples(&self) -> bool {
        true
    }

    /// The loop integral before the step.
    ///
    /// # Errors
    /// Those of the rule.
    fn before(&self, subject: &Subject<'_>, samples: Samples<'_>) -> Result<LoopIntegral, Error>;

    /// The loop integral after a step of size `h`, from these samples after it.
    ///
    /// # Errors
    /// Those of the rule and of the map.
    fn after(
        &self,
        subject: &Subject<'_>,
        h: f64,
        samples: Samples<'_>,
        initial: &LoopIntegral,
    ) -> Result<LoopAfterStep, Error>;
}

/// What one step did to a loop.
#[derive(Clone)]
pub(crate) struct LoopAfterStep {
    pub integral: LoopIntegral,
    pub defect: Defect,
    /// All that the rule finds, or the one that samples led to.
    pub breaks: Vec<Break>,
    /// What closing all breaks gives, if all are known.
    pub closed: Option<BreakClosure>,
    /// States that make up the integral.
    pub samples: usize,
    /// Sobolev exponent of the advanced loop, where samples tell.
    pub regularity: Option<f64>,
    /// Grid cells, or half periods, from one sample to the next at most.
    pub cells_apart: f64,
}

/// A loop whose breaks are closed.
#[derive(Clone, Copy)]
pub(crate) struct BreakClosure {
    pub breaks: usize,
    /// Those at which rounding decides on which side of them a state is.
    pub flickering: usize,
    /// The contribution of the closing segments to the loop integral.
    pub chord: f64,
    pub defect: Defect,
    /// What other curves could contribute, relative as the defect is.
    pub bend: f64,
    /// Whether the segments are straight after the whole step, and not in the substep that breaks the loop.
    pub straight: bool,
}

impl LoopAfterStep {
    /// The largest break, by the size of its jump.
    pub fn largest_break(&self) -> Option<Break> {
        let size = |found: &Break| found.jump_q.hypot(found.jump_p);
        let breaks = self.breaks.iter().copied();
        breaks.reduce(|a, b| if size(&b) > size(&a) { b } else { a })
    }
}
