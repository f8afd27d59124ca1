//! Reasons for which the numbers do not decide.

use super::{Case, Decision, change};
use crate::evidence::{
    Check, LoopEvidence, LoopKind, MIN_DEFORMATION, MIN_PHASE_ADVANCE, Motion, OmissionReason,
    StepEvidence, defect_of_order_4,
};
use crate::rules::RuleKind;
use crate::signal::{NEGLIGIBLE, SIGNIFICANT};
use crate::verdict::VerdictKind;
use crate::verdict::advice::Advice;
use crate::verdict::findings::{
    BoundFinding, ChangeFinding, DomainFinding, Finding, MapFinding, RunFinding, SampleFinding,
};
use crate::verdict::jacobian::JacobianVerdict;
use crate::verdict::thresholds::{
    MAX_DEFORMATION, MAX_SOLVER_TOLERANCE, MAX_STEP_FACTOR, MAX_UNCONFIRMED_DEFECT,
    MIN_UNBALANCED_RATIO,
};

/// Evaluations that a check of a smooth map needs, about. Conventional.
const EVALUATIONS_OF_CHECK: usize = 1000;

impl Case<'_> {
    pub(super) fn because(&self, because: Finding, advice: Vec<Advice>) -> Decision {
        let mut decision = Decision::new(VerdictKind::Undecided, because);
        decision.findings = self.bounds();
        decision.advice = advice;
        // If the budget is missing, the rest of the advice follows it.
        let is_of_deformation = |advice: &Advice| {
            matches!(
                advice,
                Advice::SmallerSteps { .. } | Advice::SmallerLoop { .. }
            )
        };
        let is_of_noise = matches!(
            decision.because,
            Finding::Bounds(BoundFinding::WeakBound { roundoff: true, .. })
        );
        if let Some(more) = self.wants_evaluations()
            && !is_of_noise
            && !decision.advice.iter().any(is_of_deformation)
        {
            decision
                .advice
                .insert(0, self.smaller_steps().unwrap_or(more));
        }
        decision
    }

    /// Samples do not resolve a loop that a step spreads out that far, however many they are.
    fn smaller_steps(&self) -> Option<Advice> {
        let (motion, step_size) = self.strongest_motion()?;
        let deformation = motion.deformation;
        (step_size.is_some() && deformation > MAX_DEFORMATION)
            .then_some(Advice::SmallerSteps { deformation })
    }

    /// The map projects onto a manifold, and only what leaves the manifold has a defect.
    pub(super) fn projects(&self) -> Option<Decision> {
        let singular = self.evidence.survey.singular?;
        let given = self.loops.first()?;
        let others = (self.evidence.loops.iter().skip(1)).filter(|found| !found.winds);
        let beside = others
            .filter_map(|found| Some((found.index, largest_defect(found)?)))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let because = Finding::Domain(DomainFinding::Projects {
            smallest: singular.known_smallest(),
            given: bound(given),
            beside,
        });
        Some(self.because(because, vec![Advice::Project]))
    }

    /// All of the change sits at one point of the disc within the loop: it need not be a loop that can be contracted.
    pub(super) fn not_contracted(&self) -> Option<Decision> {
        let contraction = self.evidence.contraction?;
        if contraction.area > NEGLIGIBLE || self.jacobian_refutes() {
            return None;
        }
        let (found, step) = self.worst(StepEvidence::is_significant)?;
        let because = Finding::Domain(DomainFinding::ChangesAtAPoint {
            loop_index: found.index,
            change: change(&step.defect),
            step: self.name(found, step),
            contraction,
        });
        Some(self.because(because, vec![Advice::LoopBesidePoint]))
    }

    /// It is not known whether what shows a defect lies in the domain of the map.
    pub(super) fn outside_its_domain(&self) -> Option<Decision> {
        let omitted = |check| self.evidence.missing(check) > 0;
        let (found, step) = self.worst(StepEvidence::is_significant)?;
        let of_given = (self.loops.first()).is_some_and(LoopEvidence::shows_defect);
        let change = change(&step.defect);
        let step = self.name(found, step);
        if omitted(Check::Constraint) && !of_given {
            let because = Finding::Domain(DomainFinding::ManifoldUnknown {
                loop_index: found.index,
                change,
                step,
            });
            return Some(self.because(because, vec![Advice::Project]));
        }
        let bound = self.jacobian_bound()?;
        let contradicts = change.signed.abs() > SIGNIFICANT * bound;
        if omitted(Check::Contraction) && contradicts {
            let because = Finding::Domain(DomainFinding::ContractionUnknown {
                loop_index: found.index,
                change,
                step,
                bound,
            });
            return Some(self.because(because, vec![Advice::LoopBesidePoint]));
        }
        None
    }

    /// What no defect of the Jacobian exceeds, if it is symplectic.
    pub(super) fn jacobian_bound(&self) -> Option<f64> {
        let jacobian = self.evidence.jacobian.as_ref()?;
        match jacobian.verdict() {
            JacobianVerdict::SymplecticAlmostEverywhere { .. } => jacobian.bound,
            _ => None,
        }
    }

    /// The map projects onto a manifold, and the given loop does not lie on it: on the manifold it is conserved.
    pub(super) fn beside_manifold(&self) -> Option<Decision> {
        let singular = self.evidence.survey.singular?;
        if singular.degenerate.is_some() {
            return None;
        }
        let given = self.loops.first().filter(|given| given.shows_defect())?;
        let image = (self.evidence.loops.iter())
            .find(|found| found.kind == LoopKind::Image)
            .filter(|image| image.is_bounded() && !image.shows_defect())?;
        let because = Finding::Domain(DomainFinding::LoopBesideManifold {
            smallest: singular.known_smallest(),
            first: largest_defect(given)?,
            second: bound(image)?,
        });
        Some(self.because(because, vec![Advice::LoopOnManifold]))
    }

    /// The symplectic form is degenerate on the manifold of the map: a map that is symplectic on every leaf need not conserve
    /// the integrals of loops that leave it, nor the form on tangent vectors that do.
    pub(super) fn beside_leaf(&self) -> Option<Decision> {
        let rank = self.evidence.survey.degenerate_form?;
        let conserved = |found: &&LoopEvidence| !found.shows_defect() && !found.is_broken();
        let given = self.loops.first().filter(conserved);
        if given.is_some() && self.evidence.loops.len() == 1 && self.evidence.jacobian.is_none() {
            // The user gave a loop that keeps to a leaf, and no other one.
            return None;
        }
        let given = given.and_then(bound);
        let because = Finding::Domain(DomainFinding::DegenerateForm { rank, given });
        Some(self.because(because, vec![Advice::KeepToLeaf]))
    }

    /// A step moves states off the manifold of the loops: there it may do anything.
    pub(super) fn leaves_manifold(&self) -> Option<Decision> {
        let distance = self.evidence.survey.off_manifold?;
        let because = Finding::Domain(DomainFinding::LeavesManifold { distance });
        Some(self.because(because, vec![Advice::KeepToManifold]))
    }

    /// The samples are further apart than the cells of the map's grid.
    pub(super) fn misses_grid(&self) -> Option<Decision> {
        let (found, step) = self.worst(StepEvidence::misses_the_grid)?;
        let because = Finding::Bounds(BoundFinding::MissesGrid {
            loop_index: found.index,
            cells_apart: step.cells_apart,
            step: self.name(found, step),
        });
        Some(self.because(because, vec![Advice::SamplesInCells]))
    }

    /// The largest step moves the loops too little to show the defect of an accurate method.
    pub(super) fn hardly_moves(&self) -> Option<Decision> {
        let (motion, step_size) = self.strongest_motion()?;
        if motion.tests(self.bound_of_loops()) {
            return None;
        }
        let advice = self.moves_too_little(motion, step_size)?;
        Some(self.little_motion(motion, None, advice))
    }

    /// A defect that is neither explained nor significant. A small one that is not even significant is part of the bound.
    pub(super) fn unexplained(&self) -> Option<Decision> {
        let counts = |step: &StepEvidence| {
            step.is_unexplained()
                && (step.defect.magnitude() >= MAX_UNCONFIRMED_DEFECT || step.is_significant())
        };
        let (found, step) = self.worst(counts)?;
        let because = Finding::Changes(ChangeFinding::Unexplained {
            defect: step.defect.magnitude(),
            uncertainty: step.defect.uncertainty(),
            step: self.name(found, step),
        });
        Some(self.because(because, vec![Advice::MoreSamplesAndLargerSteps]))
    }

    /// Every loop winds, and changes: a symplectic map may do that.
    pub(super) fn all_wind(&self) -> Option<Decision> {
        let all_wind = self.loops.iter().all(|found| found.winds);
        let changes = |step: &StepEvidence| step.is_unexplained() || step.jump.is_some();
        (all_wind && self.steps().any(|(_, step)| changes(step))).then(|| {
            self.because(
                Finding::Changes(ChangeFinding::AllLoopsWind),
                vec![Advice::ContractibleLoops],
            )
        })
    }

    /// What to do if little motion is a reason to stay undecided: an accurate method that is not symplectic would look the
    /// same. A map without a step size approximates nothing: it is judged itself, and so is a kick or a free flight of which a
    /// larger step shows no more.
    fn moves_too_little(&self, motion: Motion, step_size: Option<f64>) -> Option<Advice> {
        let of_map = !self.has_step_size();
        let kicks = !self.is_sampled() && motion.shear && motion.moves;
        match self.evidence.reach {
            Some(reach) if reach.shows_defect() => Some(match reach.step.step_size {
                Some(_) => Advice::LargerSteps {
                    factor: Some(reach.factor),
                    step_size,
                },
                None => Advice::LargerRadii {
                    factor: reach.factor,
                },
            }),
            // Larger steps of a step that ignores h show no more than its one step.
            _ if self.evidence.survey.ignores_step_size && !kicks && !of_map => {
                Some(Advice::UseStepSize)
            }
            Some(reach) if of_map || reach.settles(motion) => None,
            None if of_map || kicks => None,
            _ => Some(self.advice_on_motion(motion, step_size, self.bound_of_loops())),
        }
    }

    /// The largest step moves loops too little, and `advice` tells what moves them enough.
    pub(super) fn little_motion(
        &self,
        motion: Motion,
        group: Option<usize>,
        mut advice: Advice,
    ) -> Decision {
        let mut decision = self.because(
            Finding::Map(MapFinding::LittleMotion { motion, group }),
            Vec::new(),
        );
        // More evaluations do not move them.
        let of_radii = self.balanced_radii(motion);
        // How much larger depends on the radii.
        if let (Some(_), Advice::LargerSteps { factor, .. }) = (&of_radii, &mut advice) {
            *factor = None;
        }
        decision.advice = of_radii.into_iter().chain([advice]).collect();
        decision
    }

    /// Advice for a loop whose radii have nothing to do with the motion on it.
    fn balanced_radii(&self, motion: Motion) -> Option<Advice> {
        let imbalance = motion.imbalance;
        (!self.is_sampled() && imbalance >= MIN_UNBALANCED_RATIO)
            .then_some(Advice::BalancedRadii { imbalance })
    }

    pub(super) fn advice_on_motion(
        &self,
        motion: Motion,
        step_size: Option<f64>,
        bound: f64,
    ) -> Advice {
        let factor = match motion.shear {
            true => 2.0 * MIN_DEFORMATION / motion.deformation,
            false if motion.phase_advance < MIN_PHASE_ADVANCE => 1.0 / motion.phase_advance,
            // A digit above the bound: the defect goes as θ^6.
            false => (10.0 * bound / defect_of_order_4(motion.phase_advance)).powf(1.0 / 6.0),
        };
        if motion.deformation == 0.0 {
            match self.is_sampled() {
                true => Advice::CheckCopies,
                false => Advice::ReturnStates,
            }
        } else if factor < MAX_STEP_FACTOR && self.larger_steps_fail(step_size) {
            let repeat = factor.ceil() as usize;
            let budget = EVALUATIONS_OF_CHECK.saturating_mul(repeat);
            Advice::StepsAtOnce {
                repeat,
                budget: (budget > self.evidence.evaluations.budget).then_some(budget),
            }
        } else if factor < MAX_STEP_FACTOR {
            let factor = Some(factor);
            Advice::LargerSteps { factor, step_size }
        } else if motion.shear || motion.is_rounding() {
            let factor = None;
            Advice::LargerSteps { factor, step_size }
        } else {
            Advice::LoopWithForces
        }
    }

    /// Whether the map failed at a step size above the largest one that was measured.
    fn larger_steps_fail(&self, measured: Option<f64>) -> bool {
        let failed = (self.evidence.omissions.iter()).filter_map(|omission| match omission.why {
            OmissionReason::Failed { step_size, .. } if omission.check == Check::GivenLoop => {
                step_size
            }
            _ => None,
        });
        measured.is_some_and(|measured| failed.into_iter().any(|h| h.abs() > measured.abs()))
    }

    /// What only loops of another code can lack.
    pub(super) fn undecided_samples(&self) -> Option<Decision> {
        if !self.is_sampled() {
            return None;
        }
        let jumping = (self.steps()).find_map(|(found, step)| Some((found, step, step.jumping?)));
        if let Some((found, step, jumps)) = jumping {
            let name = self.name(found, step);
            return Some(if jumps.largest > 0.0 {
                let because = Finding::Samples(SampleFinding::SmallJumps {
                    size: jumps.largest,
                    step: name,
                });
                self.because(because, vec![Advice::MoreDigits, Advice::TightenSolver])
            } else {
                let because = Finding::Samples(SampleFinding::TooFewForJumps {
                    cells: jumps.cells,
                    step: name,
                    samples: found.samples,
                });
                self.because(because, vec![Advice::MoreSamplesOfFile])
            });
        }
        let unknown = |step: &StepEvidence| step.defect.quadrature_error.is_none();
        let (found, step) = self.steps().find(|(_, step)| unknown(step))?;
        let because = Finding::Samples(SampleFinding::UnknownIntegral {
            samples: found.samples,
            step: self.name(found, step),
            too_few: found.samples < crate::evidence::MIN_SAMPLES_OF_SHAPE,
        });
        Some(self.because(
            because,
            vec![
                Advice::OrderOfSamples,
                Advice::MoreSamplesOfFile,
                Advice::PeriodIfPeriodic,
            ],
        ))
    }

    /// The given loop, or all random loops, bound the defect too weakly.
    pub(super) fn weak_bound(&self) -> Option<Decision> {
        let (given, others) = self.loops.split_first()?;
        let random: Vec<&LoopEvidence> = others.iter().collect();
        let weak = |found: &LoopEvidence, step: &StepEvidence| {
            if self.evidence.survey.one_state {
                let advice = vec![Advice::MoreDigits, Advice::ReturnStates];
                return self.because(Finding::Bounds(BoundFinding::OneState), advice);
            }
            let motion = found.steps.iter().find_map(|step| step.motion);
            let motion = motion.unwrap_or_default();
            let deformation = motion.deformation;
            let is_rounded = self.evidence.survey.is_rounded();
            let uncertainty = step.defect.uncertainty();
            // Of a small loop far from the origin, states have few digits, and the quadrature shows the rounding of each.
            let of_jacobian = self.evidence.jacobian.as_ref();
            let is_noise =
                !is_rounded && of_jacobian.is_some_and(|of| SIGNIFICANT * of.noise >= uncertainty);
            let roundoff = step.defect.roundoff > 0.5 * uncertainty || is_noise;
            let because = Finding::Bounds(BoundFinding::WeakBound {
                loop_index: found.index,
                bound: step.bound(),
                step: self.name(found, step),
                roundoff,
            });
            if found.widest_gap.is_some() && !roundoff {
                let advice = vec![Advice::MoreSamplesOfFile, Advice::OrderOfSamples];
                return self.because(because, advice);
            }
            let advice = match (roundoff, self.is_sampled()) {
                (_, false) if deformation > MAX_DEFORMATION => {
                    match self.balanced_radii(motion) {
                        Some(balanced) => balanced,
                        // A smaller loop has fewer digits.
                        None if is_rounded => Advice::SmallerSteps { deformation },
                        None => Advice::SmallerLoop { deformation },
                    }
                }
                (true, _) if is_rounded => Advice::MoreDigits,
                (true, _) => Advice::LargerLoop,
                (false, true) => Advice::MoreSamplesOfFile,
                (false, false) if found.rule == RuleKind::FiniteDifference => Advice::RuleAuto,
                (false, false) if is_rounded => Advice::LargerLoopOrMoreSamples,
                (false, false) => Advice::MoreSamplesOrSmallerLoop,
            };
            self.because(because, vec![advice])
        };
        // A feature that a sample has met may change the integral, unless pieces resolved another one and found no change.
        let is_resolved = |step: &StepEvidence| {
            step.has_feature && step.rule == RuleKind::Piecewise && step.is_bounded()
        };
        let resolved = self.steps().any(|(_, step)| is_resolved(step));
        let has_feature = |step: &&StepEvidence| step.has_feature && !step.is_bounded();
        let mut featured = random
            .iter()
            .filter_map(|found| Some((*found, found.steps.iter().find(has_feature)?)));
        if let Some((found, step)) = featured.next().filter(|_| !resolved) {
            return Some(weak(found, step));
        }
        // Random loops that the samples do not resolve do not count, but one must.
        if !random.is_empty() && !random.iter().any(|found| found.is_bounded()) {
            let step = (random.iter())
                .filter_map(|found| Some((*found, weakest(found)?)))
                .max_by(|a, b| a.1.bound().total_cmp(&b.1.bound()));
            return Some(match step {
                Some((found, step)) => weak(found, step),
                None => self.because(
                    Finding::Bounds(BoundFinding::RandomLoopsFail),
                    vec![Advice::SmallerLoopInDomain],
                ),
            });
        }
        let judged = !given.winds || random.is_empty();
        let step = weakest(given).filter(|_| judged)?;
        Some(weak(given, step))
    }

    /// The budget was spent before a random loop was tried, and the Jacobian does not bound the defect as well as the given
    /// loop does.
    pub(super) fn no_random_loop(&self) -> Option<Decision> {
        let by_jacobian = self
            .jacobian_bound()
            .is_some_and(|bound| bound <= self.bound_of_loops());
        let spent = self.evidence.missing(Check::RandomLoops) > 0;
        let none = !self.has_random_loops() && !by_jacobian && spent;
        none.then(|| self.because(Finding::Bounds(BoundFinding::NoRandomLoop), Vec::new()))
    }

    /// The loops are conserved, and the Jacobian is not symplectic.
    pub(super) fn refuted(&self) -> Option<Decision> {
        self.jacobian_refutes().then(|| {
            let worst = self
                .evidence
                .jacobian
                .as_ref()
                .and_then(|found| found.worst);
            let small = worst.is_some_and(|worst| worst.magnitude() < MAX_SOLVER_TOLERANCE);
            let mut advice = vec![Advice::OtherLoops];
            if small {
                advice.insert(0, Advice::TightenSolver);
            }
            self.because(Finding::Run(RunFinding::JacobianRefutes), advice)
        })
    }

    /// Whether any random loop was tried that can be contracted.
    pub(super) fn has_random_loops(&self) -> bool {
        self.loops.iter().any(|found| found.kind != LoopKind::Given)
    }
}

/// The step that bounds the defect of a loop worst, if it is too weak to call a map symplectic.
fn weakest(found: &LoopEvidence) -> Option<&StepEvidence> {
    let weak = found.steps.iter().filter(|step| !step.is_bounded());
    // A bound that is not known is larger than any.
    weak.max_by(|a, b| a.bound().total_cmp(&b.bound()))
}

/// The largest defect of a loop.
fn largest_defect(found: &LoopEvidence) -> Option<f64> {
    let defects = found.steps.iter().map(|step| step.defect.magnitude());
    defects.reduce(f64::max)
}

/// What no defect of a loop exceeds.
fn bound(found: &LoopEvidence) -> Option<f64> {
    let bounds = found.steps.iter().map(StepEvidence::bound);
    bounds.reduce(f64::max).filter(|bound| bound.is_finite())
}
