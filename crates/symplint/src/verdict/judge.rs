//! From the evidence to the answer.

use super::fit::{Fit, fit_order};
use super::words::{capitalised, jump, name, short, size};
use super::{BEYOND_DOUBT, LoopEvidence, StepEvidence, Verdict, VerdictKind, WEAKEST_BOUND};

/// A step that deforms the loop by less than this part of its size tests nothing: even a method
/// that is far from symplectic has a defect below round-off there.
pub(crate) const LEAST_DEFORMATION: f64 = 0.2;

/// A defect below this needs a trend in h to count: a constant one can be noise of the map itself.
pub(crate) const SMALL: f64 = 1e-10;

/// Slopes below this are no trend.
pub(crate) const TREND: f64 = 0.5;

/// Judges what the loops showed.
///
/// `loops` holds the given loop first, and without one nothing is decided; `deformation` is how much the largest step deforms
/// it, relative to its size.
pub fn judge(loops: &[LoopEvidence], deformation: f64) -> (Verdict, Vec<Fit>) {
    if loops.is_empty() {
        return (nothing_measured(), Vec::new());
    }
    let fits: Vec<Fit> = loops.iter().filter_map(fit_order).collect();
    let case = Case {
        loops,
        deformation,
        fits: &fits,
    };
    let verdict = (case.broken())
        .or_else(|| case.not_symplectic())
        .or_else(|| case.undecided())
        .unwrap_or_else(|| case.symplectic());
    (verdict, fits)
}

fn nothing_measured() -> Verdict {
    Verdict {
        kind: VerdictKind::Undecided,
        digits: None,
        order: None,
        summary: "No loop was measured.".into(),
        evidence: Vec::new(),
        advice: vec!["Measure one loop or more.".into()],
    }
}

struct Case<'a> {
    loops: &'a [LoopEvidence],
    deformation: f64,
    fits: &'a [Fit],
}

impl Case<'_> {
    fn steps(&self) -> impl Iterator<Item = (&LoopEvidence, &StepEvidence)> {
        (self.loops.iter()).flat_map(|evidence| evidence.steps.iter().map(move |s| (evidence, s)))
    }

    /// The step with the largest defect among those that `wanted` picks.
    fn worst(
        &self,
        wanted: impl Fn(&StepEvidence) -> bool,
    ) -> Option<(&LoopEvidence, &StepEvidence)> {
        // What winds round a period proves nothing: a symplectic map need not be exact.
        (self
            .steps()
            .filter(|(evidence, step)| !evidence.winds && wanted(step)))
        .max_by(|a, b| a.1.defect.magnitude().total_cmp(&b.1.defect.magnitude()))
    }

    fn broken(&self) -> Option<Verdict> {
        let (evidence, step, found) =
            (self.steps()).find_map(|(e, step)| step.found.map(|found| (e, step, found)))?;
        let of_all = self.steps().count();
        let broken = self
            .steps()
            .filter(|(_, step)| step.found.is_some())
            .count();
        let times = step.closing.map_or(String::new(), |closing| {
            let plural = if closing.breaks == 1 { "" } else { "s" };
            format!(" in {} place{plural}", closing.breaks)
        });
        let mut lines = vec![
            format!(
                "At h = {} {} breaks{times}; the largest jump, {:.3e} in q and {:.3e} in p of degree \
                 of freedom {}, is at s = {:.15}.",
                size(step.step_size),
                name(evidence.index),
                found.jump_q,
                found.jump_p,
                found.dof,
                found.s
            ),
            format!("{broken} of {of_all} advanced loops are broken."),
        ];
        lines.extend(
            found
                .substep
                .map(|substep| format!("Substep {} of the map makes that jump.", substep + 1)),
        );
        let fit = self.fits.iter().find(|fit| fit.loop_index == 0);
        lines.extend(fit.map(|fit| {
            format!(
                "The defect of what is left between the breaks goes as h^({:.2} ± {:.2}) between h = {} \
                 and h = {}.",
                fit.slope,
                fit.uncertainty,
                size(fit.from),
                size(fit.to)
            )
        }));
        let closed = self.closed();
        lines.extend(closed.as_ref().map(|(line, _)| line.clone()));
        let then = match &closed {
            Some((_, true)) => " With the breaks closed its loop integrals are conserved.",
            Some((_, false)) => " Its loop integrals change even with the breaks closed.",
            None => "",
        };
        Some(Verdict {
            kind: VerdictKind::BrokenLoops,
            digits: None,
            order: fit.filter(|fit| fit.slope > TREND).and_then(Fit::whole),
            summary: format!(
                "The map is discontinuous, as far as double precision can tell: {} of degree of freedom {} jumps at s = {:.12}.{then}",
                jump(found.jump_q, found.jump_p),
                found.dof,
                found.s
            ),
            evidence: lines,
            advice: vec![
                "Use a smoother interpolation: a force that is continuous where particles cross cells."
                    .into(),
                "If q is an angle or a position in a periodic box, keep it unwrapped or state its period."
                    .into(),
                "If a solver inside the map stops at a tolerance, tighten it.".into(),
            ],
        })
    }

    /// What the loops do whose breaks are closed: a line, and whether they are conserved. `None` where
    /// that is not known.
    fn closed(&self) -> Option<(String, bool)> {
        let closed = self.steps().filter_map(|(evidence, step)| {
            let defect = step.closing.filter(|_| !evidence.winds)?.closed;
            Some((evidence, step, defect))
        });
        let (evidence, step, defect) =
            closed.max_by(|a, b| a.2.magnitude().total_cmp(&b.2.magnitude()))?;
        let (change, doubt) = (defect.magnitude(), defect.uncertainty());
        let at = format!("at h = {} ({})", size(step.step_size), name(evidence.index));
        if change > BEYOND_DOUBT * doubt {
            let line = format!(
                "With its breaks closed the loop integral still changes, by {:+.3e} ± {doubt:.1e} {at}.",
                defect.signed
            );
            return Some((line, false));
        }
        (change + doubt <= WEAKEST_BOUND).then(|| {
            let line = format!(
                "With their breaks closed all loop integrals are conserved to {:.1e}, the worst {at}.",
                change + doubt
            );
            (line, true)
        })
    }

    fn not_symplectic(&self) -> Option<Verdict> {
        let (evidence, step) = self.worst(StepEvidence::is_beyond_doubt)?;
        let defect = step.defect.magnitude();
        // The lowest order is the map's: a symmetric loop can hide it.
        let contractible = |fit: &&Fit| {
            let of_fit = self.loops.iter().find(|e| e.index == fit.loop_index);
            of_fit.is_none_or(|evidence| !evidence.winds)
        };
        let trend = (self
            .fits
            .iter()
            .filter(contractible)
            .filter(|fit| fit.slope > TREND))
        .min_by(|a, b| a.slope.total_cmp(&b.slope));
        if defect < SMALL && trend.is_none() {
            return None;
        }
        let law = trend.map_or(String::new(), |fit| format!(", {}", fit.law()));
        let mut lines = vec![format!(
            "At h = {} the loop integral of {} changes by {:+.3e} of itself; quadrature error and \
             round-off are below {:.1e}.",
            size(step.step_size),
            name(evidence.index),
            step.defect.signed,
            step.defect.uncertainty()
        )];
        lines.extend(self.fits.iter().map(|fit| {
            format!(
                "The defect of {} goes as h^({:.3} ± {:.3}) between h = {} and h = {}.",
                name(fit.loop_index),
                fit.slope,
                fit.uncertainty,
                size(fit.from),
                size(fit.to)
            )
        }));
        let mut advice = Vec::new();
        if self.fits.is_empty() {
            advice.push("Give four or more step sizes, halving, to learn the order.".into());
        } else if trend.is_none() {
            advice.push(
                "The defect does not fall with h: look for a wrong sign, momenta that are not \
                 canonical, or a weight that is missing."
                    .into(),
            );
        }
        Some(Verdict {
            kind: VerdictKind::NotSymplectic,
            digits: None,
            order: trend.and_then(Fit::whole),
            summary: format!(
                "The map changes a loop integral by {defect:.1e} at h = {}{law}.",
                size(step.step_size)
            ),
            evidence: lines,
            advice,
        })
    }

    fn undecided(&self) -> Option<Verdict> {
        let because = |summary: String, advice: &str| Verdict {
            kind: VerdictKind::Undecided,
            digits: None,
            order: None,
            summary,
            evidence: self.bounds(),
            advice: vec![advice.into()],
        };
        if self.deformation < LEAST_DEFORMATION {
            return Some(because(
                format!(
                    "The largest step deforms the loop by only {:.1e} of its size, too little \
                     to show a defect.",
                    self.deformation
                ),
                "Take larger step sizes, up to where one step deforms the loop by about its size.",
            ));
        }
        if let Some((evidence, step)) = self.worst(StepEvidence::misses_the_grid) {
            return Some(because(
                format!(
                    "The samples of {} lie {} cells of the map's grid, or half periods, apart at h = {}: \
                     they do not see the grid.",
                    name(evidence.index),
                    short(step.cells_apart),
                    size(step.step_size)
                ),
                "Take more samples or a smaller loop: two samples or more in each cell it crosses.",
            ));
        }
        if let Some((_, step)) = self.worst(StepEvidence::is_unexplained) {
            return Some(because(
                format!(
                    "A defect of {:.1e} at h = {} is more than quadrature error and round-off \
                     explain ({:.1e}) and too little to be sure.",
                    step.defect.magnitude(),
                    size(step.step_size),
                    step.defect.uncertainty()
                ),
                "Take more samples and larger step sizes: a true defect grows with h, an error does not.",
            ));
        }
        let all_wind = self.loops.iter().all(|evidence| evidence.winds);
        if all_wind && self.steps().any(|(_, step)| step.is_unexplained()) {
            return Some(because(
                "Every loop winds round a period: even a symplectic map may change such an integral."
                    .into(),
                "Add loops that can be contracted: set loops to 8.",
            ));
        }
        // Random loops that the samples do not resolve cannot testify, but one must.
        let (given, random) = self.loops.split_first()?;
        if !random.is_empty() && !random.iter().any(LoopEvidence::testifies) {
            let Some(step) = random.iter().find_map(LoopEvidence::weak_step) else {
                return Some(because(
                    "The map fails on every random loop of the given one's size.".into(),
                    "Take a smaller loop, well inside the domain of the map, or set loops to 1.",
                ));
            };
            return Some(self.unresolved(step));
        }
        let judged = !given.winds || random.is_empty();
        (given.weak_step().filter(|_| judged)).map(|step| self.unresolved(step))
    }

    fn unresolved(&self, step: &StepEvidence) -> Verdict {
        Verdict {
            kind: VerdictKind::Undecided,
            digits: None,
            order: None,
            summary: format!(
                "At h = {} the quadrature only bounds the defect by {:.1e}.",
                size(step.step_size),
                step.bound()
            ),
            evidence: self.bounds(),
            advice: vec![
                "Take more samples or a smaller loop; finite differences are only good to a few digits."
                    .into(),
            ],
        }
    }

    fn symplectic(&self) -> Verdict {
        // A random loop that winds says whether the map is exact, no more.
        let random_ones = self.loops[1..].iter().filter(|evidence| !evidence.winds);
        let resolved = |evidence: &&LoopEvidence| evidence.testifies();
        let bound = (self.loops[..1]
            .iter()
            .chain(random_ones.clone())
            .filter(resolved))
        .flat_map(|evidence| &evidence.steps)
        .map(StepEvidence::bound)
        .fold(f64::EPSILON, f64::max);
        let digits = (-bound.log10() * 10.0).floor() / 10.0;
        let sizes = self.loops[0].steps.iter().map(|step| step.step_size.abs());
        let (low, high) = sizes.fold((f64::INFINITY, 0.0), |(l, h): (f64, f64), size| {
            (l.min(size), h.max(size))
        });
        let testifying = random_ones.filter(resolved).count();
        let random = match testifying {
            0 => String::new(),
            1 => format!(", nor on a random one at {}", size(high)),
            others => format!(", nor on {others} random ones at {}", size(high)),
        };
        Verdict {
            kind: VerdictKind::Symplectic,
            digits: Some(digits),
            order: None,
            summary: match self.loops[0].testifies() {
                true => {
                    let range = match low == high {
                        true => format!("at h = {}", size(high)),
                        false => format!("for h from {} to {}", size(low), size(high)),
                    };
                    format!("No defect above {bound:.1e} on the given loop {range}{random}.")
                }
                false => format!(
                    "No defect above {bound:.1e} on {testifying} random loops at h = {}; the given one winds \
                     round a period.",
                    size(high)
                ),
            },
            evidence: self.bounds(),
            advice: match self.loops.len() {
                1 => vec!["One loop is one probe: set loops to 8 to be surer.".into()],
                _ => Vec::new(),
            },
        }
    }

    /// How large the defects may be: a line for the given loop, and one for the worst of the others.
    fn bounds(&self) -> Vec<String> {
        let line = |evidence: &LoopEvidence| {
            if let Some(failure) = &evidence.failure {
                let who = capitalised(&name(evidence.index));
                return Some(format!(
                    "{who} says nothing, for the map fails on it: {failure}."
                ));
            }
            let step = (evidence.steps.iter()).max_by(|a, b| a.bound().total_cmp(&b.bound()))?;
            Some(format!(
                "{} ({}): |E| ≤ {:.1e}; measured {} ± {:.1e} at the worst, h = {}.",
                capitalised(&name(evidence.index)),
                match evidence.piecewise {
                    true => "piecewise".into(),
                    false => format!("{} samples", evidence.samples),
                },
                step.bound(),
                short(step.defect.magnitude()),
                step.defect.uncertainty(),
                size(step.step_size)
            ))
        };
        let (given, random) = self.loops.split_at(1);
        let bound = |evidence: &LoopEvidence| {
            let bounds = evidence.steps.iter().map(StepEvidence::bound);
            bounds.fold(0.0, f64::max)
        };
        let worst = (random.iter().filter(|evidence| !evidence.steps.is_empty()))
            .max_by(|a, b| bound(a).total_cmp(&bound(b)));
        let failed = random.iter().find(|evidence| evidence.failure.is_some());
        let shown = given.iter().chain(worst).chain(failed);
        let mut lines: Vec<String> = shown.filter_map(line).collect();
        let flux = (self.steps()).find(|(evidence, step)| evidence.winds && step.is_beyond_doubt());
        lines.extend(flux.map(|(evidence, step)| {
            format!(
                "{} winds round a period and changes by {:+.3e} of itself at h = {}: the map is not exact; \
                 no Hamiltonian of that period makes it.",
                capitalised(&name(evidence.index)),
                step.defect.signed,
                size(step.step_size)
            )
        }));
        let conserved =
            |found: &&LoopEvidence| !found.steps.iter().any(StepEvidence::is_unexplained);
        let exact = (random.iter())
            .filter(|found| found.winds && found.testifies())
            .find(conserved);
        lines.extend(exact.map(|found| {
            format!(
                "{} winds round a period, cannot be contracted, and is conserved, too: the map is exact.",
                capitalised(&name(found.index))
            )
        }));
        lines.push(format!(
            "What is narrower than 1/{} of the loop is not seen.",
            self.loops[0].samples
        ));
        lines.push(format!(
            "The largest step deforms the loop by {} of its size.",
            short(self.deformation)
        ));
        lines
    }
}
