//! Beyond the loops and step sizes of a diagnosis, if they move too little to test an accurate method.

use super::loop_of_kind;
use crate::diagnosis::checks::{GivenLoop, Runner, if_possible};
use crate::diagnosis::limits::{
    FACTOR_OF_LARGER_LOOPS, MAX_HALVINGS, MAX_LARGER_LOOPS, SAMPLES_PER_STEP_SIZE,
};
use crate::diagnosis::resolve::initial_samples::InitialSamples;
use crate::diagnosis::step_sizes::step_sizes;
use crate::error::Error;
use crate::evidence::{LoopEvidence, LoopKind, Motion, Reach};
use crate::map::LoopSize;
use crate::rules::Subject;
use crate::signal::MAX_RELATIVE_ROUNDING_INSIDE;

impl Runner<'_> {
    /// A random loop after a larger step, or a larger loop for a map without a step size, if no loop shows a defect or moves
    /// enough to show one: an accurate method that is not symplectic shows it there.
    pub(in crate::diagnosis::checks) fn reach(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        let diagnostic = self.diagnostic;
        let loops = &self.evidence.loops;
        let bound = LoopEvidence::bound_of(loops);
        let shown = (loops.iter()).any(|found| !found.winds && found.shows_defect());
        let little = Motion::strongest(loops).filter(|(motion, _)| !motion.tests(bound));
        if !diagnostic.has_step_size || little.is_some() {
            let largest = |radii: &Vec<f64>| radii.iter().copied().fold(0.0, f64::max);
            self.evidence.radii = Some(given.size.radius.each_ref().map(largest));
        }
        let Some((motion, _)) = little.filter(|_| !shown) else {
            return Ok(());
        };
        // Evaluations for the search alone would be lost to the Jacobian.
        if self.left() < given.cost + SAMPLES_PER_STEP_SIZE {
            return Ok(());
        }
        let found = match diagnostic.has_step_size {
            true => self.larger_step(subject, given, motion),
            false => self.larger_loop(subject, given),
        };
        self.evidence.reach = if_possible(found)?;
        Ok(())
    }

    /// The largest step that advances the motions by about a radian or less, or shorter ones if it breaks the loop. What
    /// looks like a kick or a free flight alone is first taken to deform the loop by about its size.
    fn larger_step(
        &self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
        motion: Motion,
    ) -> Result<Option<Reach>, Error> {
        let octaves = match motion.shear {
            true if motion.deformation < MAX_RELATIVE_ROUNDING_INSIDE => return Ok(None),
            true => -motion.deformation.log2().ceil(),
            false => 0.0,
        };
        let start = self.largest * octaves.max(0.0).exp2();
        let largest = step_sizes(subject, start)?.first().copied();
        let mut h = largest.unwrap_or(self.largest);
        for _ in 0..MAX_HALVINGS {
            if h.abs() <= self.largest.abs() {
                break;
            }
            let found = self.beyond(subject, &given.size, h, h / self.largest)?;
            if found.is_some() {
                return Ok(found);
            }
            h /= 2.0;
        }
        Ok(None)
    }

    /// Larger and larger loops, up to one that moves enough or shows a defect, or the last one on which the map works.
    fn larger_loop(
        &self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<Option<Reach>, Error> {
        let mut last = None;
        for k in 1..=MAX_LARGER_LOOPS {
            let factor = FACTOR_OF_LARGER_LOOPS.powi(k as i32);
            let mut size = given.size.clone();
            size.radius
                .iter_mut()
                .flatten()
                .for_each(|radius| *radius *= factor);
            let Some(found) = self.beyond(subject, &size, self.largest, factor)? else {
                break;
            };
            last = Some(found);
            let tests = |motion: Motion| motion.tests(found.step.bound());
            if found.shows_defect() || found.step.motion.is_some_and(tests) {
                break;
            }
        }
        Ok(last)
    }

    /// A random loop of this size after a step of size `h`, if the map works there and the loop is resolved.
    fn beyond(
        &self,
        subject: Subject<'_>,
        size: &LoopSize,
        h: f64,
        factor: f64,
    ) -> Result<Option<Reach>, Error> {
        let seed = self.diagnostic.seed.wrapping_add(1);
        let kind = LoopKind::Random;
        let Some(random) = loop_of_kind(kind, None, size, subject.coordinates(), seed)? else {
            return Ok(None);
        };
        let subject = Subject {
            phase_loop: &subject.evaluator.on_manifold(random),
            ..subject
        };
        match self.resolved(&mut InitialSamples::new(subject), h) {
            Ok((probe, known, motion)) => {
                let mut step = probe.evidence(&known);
                step.motion = motion;
                Ok(Reach::of(factor, step))
            }
            Err(Error::NoArea { .. } | Error::LostInRounding { .. }) => Ok(None),
            Err(error) if error.is_of_map() => Ok(None),
            Err(error) => Err(error),
        }
    }
}
