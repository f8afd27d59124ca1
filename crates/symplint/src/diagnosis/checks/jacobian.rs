//! The Jacobian of a step.

use super::{GivenLoop, Runner, failed};
use crate::diagnosis::limits::{
    DIVISOR_OF_BLOCKS, DIVISOR_OF_DECAY, DIVISOR_OF_LARGE_JACOBIAN, MAX_DOF_OF_BLOCKS,
};
use crate::error::Error;
use crate::evidence::{
    Check, LoopEvidence, MIN_RANGE_OF_LAW, MIN_STEP_SIZES_OF_LAW, OmissionReason,
};
use crate::jacobian::{DefectBlocks, JacobianDecay, JacobianEvidence, JacobianTest};
use crate::loops::FEW_SAMPLES;
use crate::map::LoopSize;
use crate::rules::Subject;
use crate::signal::{CERTAIN, parameters};

impl Runner<'_> {
    /// The Jacobian of the largest step, on the given loop.
    pub(super) fn jacobian(
        &mut self,
        subject: Subject<'_>,
        given: &GivenLoop<'_>,
    ) -> Result<(), Error> {
        if !self.diagnostic.jacobian {
            return Ok(());
        }
        if given.probe.is_beyond_memory() {
            self.omit(
                Check::Jacobian,
                OmissionReason::Memory {
                    samples: FEW_SAMPLES,
                },
            );
            return Ok(());
        }
        let Subject {
            evaluator,
            phase_loop,
        } = subject;
        let left = self.count.left().saturating_sub(self.plan.domain);
        let planned = self.plan.jacobian;
        match JacobianTest::within(left.min(planned), evaluator.dof(), evaluator.has_tangent()) {
            None => self.omit(Check::Jacobian, OmissionReason::BUDGET),
            Some(test) => {
                // Further groups of degrees of freedom, and tracing a defect, take as much again.
                let further = planned.saturating_mul(1 + given.size.groups.len().max(1));
                let test = JacobianTest {
                    budget: left.min(further),
                    ..test
                };
                let s = parameters(test.points);
                match test.run_keeping(evaluator, phase_loop, &given.size, self.largest, s) {
                    Ok((mut found, images)) => {
                        self.images = images;
                        if found.blocks.is_none() {
                            found.blocks = self.blocks(&test, subject, &given.size, &found);
                        }
                        self.evidence.jacobian_decay =
                            self.jacobian_decay(&test, subject, &given.size, &found);
                        self.evidence.jacobian = Some(found);
                    }
                    // It displaces states off the loop, where the map need not be defined.
                    Err(error) => self.omit(Check::Jacobian, failed(&error)),
                }
            }
        }
        Ok(())
    }

    /// The blocks of the defect at the worst point, if random tangent vectors showed it and all unit vectors are within the evaluations
    /// that a witness may take.
    fn blocks(
        &self,
        test: &JacobianTest,
        subject: Subject<'_>,
        size: &LoopSize,
        found: &JacobianEvidence,
    ) -> Option<DefectBlocks> {
        let (_, worst) = found.worst_point().filter(|_| found.shows_defect())?;
        let (dof, has_tangent) = (subject.dof(), subject.evaluator.has_tangent());
        let mut one = JacobianTest {
            points: 1,
            full_up_to: dof,
            ..*test
        };
        one.budget = one.evaluations(dof, has_tangent) + JacobianTest::STATES_ALONG_TIME;
        let planned = self.evidence.evaluations.budget / DIVISOR_OF_LARGE_JACOBIAN;
        let most = (self.count.made() / DIVISOR_OF_BLOCKS).max(planned);
        let is_affordable = one.budget <= most.min(self.left_for_features(dof));
        if found.full || found.projected || dof > MAX_DOF_OF_BLOCKS || !is_affordable {
            return None;
        }
        // A witness that fails is not missed.
        let at = vec![worst.s];
        let full = one.run_at(
            subject.evaluator,
            subject.phase_loop,
            size,
            self.largest,
            at,
        );
        full.ok()?.blocks
    }

    /// The defect of the Jacobian at a second step size. If the loops may have an order, at the smallest step size at which
    /// the defect is expected to be well above what its method resolves. If their defects are significant at too few step sizes, at
    /// the largest one that shows how the defect depends on h.
    pub(super) fn jacobian_decay(
        &self,
        test: &JacobianTest,
        subject: Subject<'_>,
        size: &LoopSize,
        found: &JacobianEvidence,
    ) -> Option<JacobianDecay> {
        let (_, worst) = found.worst_point().filter(|_| found.shows_defect())?;
        let largest_step = found.step_size?;
        let significant = |of: &LoopEvidence| -> Vec<(f64, f64)> {
            (of.steps.iter().filter(|step| step.is_significant()))
                .filter_map(|step| Some((step.step_size?, step.defect.magnitude())))
                .collect()
        };
        let loops = self.evidence.loops.iter().filter(|of| !of.winds);
        let of_loops: Vec<_> = loops
            .map(significant)
            .filter(|steps| steps.len() >= MIN_STEP_SIZES_OF_LAW)
            .collect();
        let has_order = !of_loops.is_empty();
        let expected = of_loops.into_iter().flat_map(|steps| {
            let largest = steps.iter().find(|(h, _)| *h == largest_step);
            let at_largest = largest.map_or(f64::INFINITY, |(_, defect)| *defect);
            let fallen = move |(h, defect)| (h, worst.magnitude() * defect / at_largest);
            steps.into_iter().map(fallen)
        });
        let least = CERTAIN * found.method.least_defect();
        let size_of = |a: &f64, b: &f64| a.abs().total_cmp(&b.abs());
        let h = match has_order {
            true => expected
                .filter(|&(h, defect)| h.abs() < largest_step.abs() && defect >= least)
                .map(|(h, _)| h)
                .min_by(size_of),
            // No cause of a break depends on it.
            false if self.evidence.loops.iter().any(LoopEvidence::is_broken) => None,
            false => (self.sizes())
                .filter(|h| MIN_RANGE_OF_LAW * h.abs() <= largest_step.abs())
                .max_by(size_of)
                .filter(|_| worst.magnitude() >= least),
        }?;
        let evaluator = subject.evaluator;
        let one = JacobianTest { points: 1, ..*test };
        let groups = if found.full {
            1
        } else {
            size.groups.len().max(1)
        };
        let cost = groups * one.evaluations(evaluator.dof(), evaluator.has_tangent());
        // A witness of an order may cost nothing that the domain of the map needs. A loop need not be contracted if the Jacobian shows
        // the defect.
        let left = match has_order {
            true => self.count.left().saturating_sub(self.plan.domain),
            false => self.left_for_features(evaluator.dof()),
        };
        if cost > left.min(self.count.made() / DIVISOR_OF_DECAY) {
            return None;
        }
        // A witness that fails is not missed: the loops are measured.
        (one.decay(evaluator, subject.phase_loop, size, found, h)).ok()?
    }
}
