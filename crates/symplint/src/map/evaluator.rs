//! The one place where maps are called.

use std::sync::Arc;

use super::count::EvaluationCount;
use super::notes::Notes;
use super::witnesses::Recorder;
use super::{
    Capabilities, Constraint, Difference, Energy, Parts, ProjectedLoop, Reversal, StepFailure,
    TimeAdvance, Witnesses,
};
use crate::error::{Error, StateLocation};
use crate::loops::Loop;
use crate::state::{Block, Coordinates, Ensemble, each_in_parallel, first_error, first_not_finite};

/// Calls a map for the diagnostic: spreads samples over threads, checks that states are finite, names the
/// sample and the step size of a failure, and counts evaluations.
///
/// One evaluation is one state advanced by one step, or by the last substeps of one.
pub(crate) struct Evaluator<'a> {
    map: &'a dyn TimeAdvance,
    capabilities: Arc<Capabilities<'a>>,
    parts: Parts<'a, dyn TimeAdvance + 'a>,
    constraint: Option<&'a dyn Constraint>,
    /// Substeps that make up the step; fewer than the map has for [`prefix`](Self::prefix).
    substeps: usize,
    count: &'a EvaluationCount,
    /// States that are advanced again later.
    recorder: Recorder,
    /// Knowledge that checks leave to later ones.
    pub(super) notes: Notes,
    has_step_size: bool,
}

impl<'a> Evaluator<'a> {
    /// Calls `map`, and adds to `count`.
    ///
    /// # Errors
    /// If the coordinates of the map have other degrees of freedom than the map.
    pub fn new(map: &'a dyn TimeAdvance, count: &'a EvaluationCount) -> Result<Self, Error> {
        let (capabilities, parts) = (Arc::new(map.capabilities()), Parts::of(map));
        let of_coordinates = capabilities.coordinates.dof();
        Error::check_length("coordinates of the map", map.dof(), of_coordinates)?;
        Ok(Evaluator {
            map,
            constraint: capabilities.constraint,
            substeps: parts.count(),
            parts,
            capabilities,
            count,
            recorder: Recorder::default(),
            notes: Notes::default(),
            has_step_size: true,
        })
    }

    /// The first `substeps` substeps as a separate map.
    pub fn prefix(&self, substeps: usize) -> Evaluator<'a> {
        Evaluator {
            map: self.map,
            capabilities: Arc::clone(&self.capabilities),
            parts: self.parts,
            constraint: self.constraint,
            substeps,
            count: self.count,
            recorder: Recorder::default(),
            notes: self.notes.of_map(),
            has_step_size: self.has_step_size,
        }
    }

    /// Degrees of freedom.
    pub fn dof(&self) -> usize {
        self.map.dof()
    }

    /// Periods, weights and grid of the map.
    pub fn coordinates(&self) -> &Coordinates {
        &self.capabilities.coordinates
    }

    /// Number of substeps.
    pub fn substeps(&self) -> usize {
        self.substeps
    }

    /// Name of a substep.
    pub fn substep_name(&self, substep: usize) -> String {
        self.parts.name(substep)
    }

    /// The tangent map, if the map has one. It is called by [`advance_tangents`](Self::advance_tangents).
    pub fn has_tangent(&self) -> bool {
        self.capabilities.tangent.is_some()
    }

    /// The manifold on which the map acts, if it names one.
    pub fn constraint(&self) -> Option<&'a dyn Constraint> {
        self.constraint
    }

    /// The energy of states, if the map has it.
    pub fn energy(&self) -> Option<&Energy<'a>> {
        self.capabilities.energy.as_ref()
    }

    /// What reverses time, if the map has it.
    pub fn reversal(&self) -> Option<&Reversal<'a>> {
        self.capabilities.reversal.as_ref()
    }

    /// A loop on that manifold.
    pub fn on_manifold<L: Loop>(&self, phase_loop: L) -> ProjectedLoop<'a, L> {
        ProjectedLoop::on(phase_loop, self.constraint)
    }

    /// The same without the manifold that the map names.
    pub fn without_constraint(self) -> Self {
        Evaluator {
            constraint: None,
            ..self
        }
    }

    /// The same for a map without a step size: errors and evidence name none.
    pub fn without_step_size(self) -> Self {
        Evaluator {
            has_step_size: false,
            ..self
        }
    }

    /// A step size as errors and evidence state it: `None` for a map without one.
    pub fn stated(&self, h: f64) -> Option<f64> {
        self.has_step_size.then_some(h)
    }

    /// The count that evaluations are added to.
    pub fn count(&self) -> &'a EvaluationCount {
        self.count
    }

    /// Counts evaluations that are about to be made, if the map wants any more.
    ///
    /// # Errors
    /// If it does not, or the budget does not allow them.
    fn take(&self, evaluations: usize) -> Result<(), Error> {
        self.check_not_stopped()?;
        self.count.take(evaluations)
    }

    /// Checks that the map does not ask to end the diagnosis.
    ///
    /// # Errors
    /// If it does.
    pub fn check_not_stopped(&self) -> Result<(), Error> {
        match &self.capabilities.is_stopped {
            Some(is_stopped) if is_stopped() => Err(Error::Stopped),
            _ => Ok(()),
        }
    }

    /// Checks that map and loop live in one phase space.
    ///
    /// # Errors
    /// If they do not.
    pub fn check_dof(&self, dof: usize) -> Result<(), Error> {
        if self.dof() == dof {
            Ok(())
        } else {
            Err(Error::DofMismatch {
                map: self.dof(),
                phase_loop: dof,
            })
        }
    }

    /// Advances every sample by one step of size `h`, in place.
    ///
    /// # Errors
    /// If map and ensemble differ in their degrees of freedom, the budget does not allow it, the map fails, or it
    /// returns a state that is not finite. The error is that of the first block of samples that has one, on any number of threads;
    /// the ensemble is then half advanced and of no use.
    pub fn advance(&self, states: &mut Ensemble, h: f64) -> Result<(), Error> {
        self.check_dof(states.dof())?;
        let width = self.block_width();
        self.take(states.samples())?;
        let each = |(b, mut block): (usize, Block<'_>)| {
            self.advance_block(&mut block, b == 0, b * width, h)
        };
        let blocks = states.blocks_of(width).into_iter().enumerate();
        first_error(each_in_parallel(blocks, each))
    }

    /// Whether a step of this evaluator is a step of the map, not the first part of one.
    fn is_whole(&self) -> bool {
        self.substeps == self.parts.count()
    }

    /// Samples that the map is given at once, at most.
    fn block_width(&self) -> usize {
        self.capabilities.block_width.max(1)
    }

    /// The largest difference between results for one state that the map knows.
    pub fn difference(&self) -> Option<Difference> {
        self.capabilities.difference.as_ref()?()
    }

    /// Whether [`prefetch`](Self::prefetch) does anything.
    pub fn has_prefetch(&self) -> bool {
        self.is_whole() && self.capabilities.prefetch.is_some()
    }

    /// Tells the map of states that are sure to be advanced by a step of size `h`. They are counted when they are.
    pub fn prefetch(&self, states: &mut Ensemble, h: f64) {
        if self.has_prefetch()
            && let Some(prefetch) = self.capabilities.prefetch
        {
            for block in states.blocks_of(self.block_width()) {
                prefetch.begin(h, &block);
            }
        }
    }

    /// The same from the states that `fill` writes into each block, which begins with the sample named: they
    /// are advanced while they are in the cache, [side by side](Block::gathered).
    ///
    /// # Errors
    /// Those of `fill` and of [`advance`](Self::advance).
    pub fn advance_from(
        &self,
        states: &mut Ensemble,
        h: f64,
        fill: impl Fn(usize, &mut Block<'_>) -> Result<(), Error> + Sync,
    ) -> Result<(), Error> {
        self.check_dof(states.dof())?;
        let width = self.block_width();
        self.advance_blocks(states.blocks_of(width), width, 0, h, fill)
    }

    /// Keeps this number of states of the first call and of the largest batch of each loop.
    pub fn keep_witnesses(&self, states: usize) {
        self.recorder.begin(states);
    }

    /// The states that were kept, in the order of the calls.
    pub fn witnesses(&self) -> Vec<Witnesses> {
        self.recorder.witnesses()
    }

    /// Another loop is advanced from now on: its grain is not known, nor its features.
    pub fn begin_loop(&self) {
        self.recorder.begin_loop();
        self.notes.begin_loop();
    }

    /// The same for blocks of `width` samples each, of which the first begins with sample `first`.
    ///
    /// # Errors
    /// Those of `fill` and of [`advance`](Self::advance).
    pub fn advance_blocks(
        &self,
        blocks: Vec<Block<'_>>,
        width: usize,
        first: usize,
        h: f64,
        fill: impl Fn(usize, &mut Block<'_>) -> Result<(), Error> + Sync,
    ) -> Result<(), Error> {
        self.take(blocks.iter().map(Block::len).sum())?;
        let each = |(b, mut block): (usize, Block<'_>)| {
            let is_first = b == 0;
            let first = first + b * width;
            block.gathered(|block| {
                fill(first, block)?;
                self.advance_block(block, is_first, first, h)
            })
        };
        first_error(each_in_parallel(blocks.into_iter().enumerate(), each))
    }

    /// Advances a block that begins with sample `first`, the first of a call or not.
    fn advance_block(
        &self,
        block: &mut Block<'_>,
        is_first: bool,
        first: usize,
        h: f64,
    ) -> Result<(), Error> {
        let taken = is_first.then(|| self.recorder.take(block)).flatten();
        let advanced = match self.is_whole() {
            true => self.map.advance(h, block),
            false => (0..self.substeps).try_for_each(|k| self.parts.advance(k, h, block)),
        };
        self.count.finish(block.len());
        checked(advanced, self.stated(h), first, block)?;
        if let Some(taken) = taken {
            self.recorder.keep(taken, h, block);
        }
        Ok(())
    }

    /// Advances every sample by one substep of a step of size `h`. The last substep counts as an evaluation.
    ///
    /// # Errors
    /// Those of [`advance`](Self::advance).
    pub fn advance_substep(
        &self,
        states: &mut Ensemble,
        substep: usize,
        h: f64,
    ) -> Result<(), Error> {
        self.check_dof(states.dof())?;
        if substep + 1 == self.substeps {
            self.take(states.samples())?;
        }
        let width = self.block_width();
        let each = |(b, mut block): (usize, Block<'_>)| {
            let advanced = self.parts.advance(substep, h, &mut block);
            if substep + 1 == self.substeps {
                self.count.finish(block.len());
            }
            checked(advanced, self.stated(h), b * width, &block)
        };
        let blocks = states.blocks_of(width).into_iter().enumerate();
        first_error(each_in_parallel(blocks, each))
    }

    /// Advances every sample by the substeps of a step of size `h` from `first` on, one block after the other, each while it is in the
    /// cache. `begin` gets the number of a block's first sample, and of its samples. `visit` gets what it returned, with the block before
    /// each substep, and after the last.
    ///
    /// # Errors
    /// Those of [`advance`](Self::advance).
    pub fn advance_substeps<T: Send>(
        &self,
        states: &mut Ensemble,
        first: usize,
        h: f64,
        begin: impl Fn(usize, usize) -> T + Sync,
        visit: impl Fn(&mut T, usize, &mut Block<'_>) + Sync,
    ) -> Result<Vec<T>, Error> {
        self.check_dof(states.dof())?;
        if first < self.substeps {
            self.take(states.samples())?;
        }
        let width = self.block_width();
        let each = |(b, mut block): (usize, Block<'_>)| {
            let mut visits = begin(b * width, block.len());
            let advanced = (first..self.substeps).try_for_each(|substep| {
                visit(&mut visits, substep, &mut block);
                let advanced = self.parts.advance(substep, h, &mut block);
                checked(advanced, self.stated(h), b * width, &block)
            });
            if first < self.substeps {
                self.count.finish(block.len());
            }
            advanced?;
            visit(&mut visits, self.substeps, &mut block);
            Ok(visits)
        };
        let blocks = states.blocks_of(width).into_iter().enumerate();
        each_in_parallel(blocks, each).into_iter().collect()
    }

    /// Advances states and, with each, a tangent vector, as the tangent map of the map does; `fill` writes both
    /// blocks, which begin with the sample named.
    ///
    /// # Errors
    /// Those of [`advance`](Self::advance).
    ///
    /// # Panics
    /// If the map has no tangent map, or the ensembles differ in shape.
    pub fn advance_tangents(
        &self,
        states: &mut Ensemble,
        tangents: &mut Ensemble,
        h: f64,
        fill: impl Fn(usize, &mut Block<'_>, &mut Block<'_>) + Sync,
    ) -> Result<(), Error> {
        let tangent = (self.capabilities.tangent).expect("the map has a tangent map");
        assert_eq!(states.samples(), tangents.samples());
        self.check_dof(states.dof())?;
        self.take(states.samples())?;
        let width = Ensemble::block_width(states.dof());
        let pairs = states.blocks().into_iter().zip(tangents.blocks());
        let each = |(b, (mut states, mut tangents)): (usize, (Block<'_>, Block<'_>))| {
            let first = b * width;
            fill(first, &mut states, &mut tangents);
            let advanced = tangent.advance_tangents(h, &mut states, &mut tangents);
            self.count.finish(states.len());
            checked(advanced, self.stated(h), first, &states)
        };
        first_error(each_in_parallel(pairs.enumerate(), each))
    }

    /// What one step makes of the loop at the parameters `s`, as many or few as wanted.
    ///
    /// # Errors
    /// Those of [`advance`](Self::advance).
    pub fn image(&self, phase_loop: &dyn Loop, h: f64, s: &[f64]) -> Result<Ensemble, Error> {
        let mut states = states_at(phase_loop, s);
        (self.advance(&mut states, h))
            .map_err(|error| error.at(|sample| StateLocation::Loop(s[sample])))?;
        Ok(states)
    }
}

/// The states of the loop at the parameters `s`.
pub(crate) fn states_at(phase_loop: &dyn Loop, s: &[f64]) -> Ensemble {
    let mut states = Ensemble::zeros(phase_loop.dof(), s.len());
    phase_loop.sample(s, &mut states.block());
    states
}

/// What came of advancing a block that begins with sample `first`.
fn checked(
    advanced: Result<(), StepFailure>,
    h: Option<f64>,
    first: usize,
    block: &Block<'_>,
) -> Result<(), Error> {
    advanced.map_err(|failure| Error::StepFailed {
        // A map may name a sample that the block does not have.
        at: StateLocation::Sample(first + failure.sample.min(block.len().saturating_sub(1))),
        step_size: h,
        reason: failure.reason,
    })?;
    match first_not_finite(block.q.as_rows(), block.p.as_rows()) {
        None => Ok(()),
        Some(found) => Err(match h {
            Some(_) => found.into_error(first, h),
            None => found.of_map(first),
        }),
    }
}

impl Ensemble {
    /// Advances every sample by one step of size `h`, in place, over the threads of the
    /// current Rayon pool.
    ///
    /// # Errors
    /// If map and ensemble differ in their degrees of freedom, the map fails, or it returns a state
    /// that is not finite. The error is that of the first block of samples that has one,
    /// on any number of threads; the ensemble is then half advanced and of no use.
    pub fn advance(&mut self, map: &dyn TimeAdvance, h: f64) -> Result<(), Error> {
        Evaluator::new(map, &EvaluationCount::unlimited())?.advance(self, h)
    }

    /// Advances every sample by one substep of a step of size `h`, as [`advance`](Self::advance)
    /// does by the whole step.
    ///
    /// # Errors
    /// The same.
    pub fn advance_substep(
        &mut self,
        map: &dyn TimeAdvance,
        substep: usize,
        h: f64,
    ) -> Result<(), Error> {
        Evaluator::new(map, &EvaluationCount::unlimited())?.advance_substep(self, substep, h)
    }
}
