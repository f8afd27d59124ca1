//! From what the samples show to the verdict.

use super::compare::{Broken, Compared, FEWEST, Initial, Wrap};
use crate::verdict::{
    Fit, LEAST_DEFORMATION, LoopEvidence, SMALL, StepEvidence, TREND, Verdict, VerdictKind,
    capitalised, fit_order, short, size,
};

/// Judges the advanced loops.
pub(super) fn conclude(
    initial: &Initial<'_>,
    steps: &[Compared],
    samples: usize,
) -> (Verdict, Vec<Fit>) {
    let mut evidence = LoopEvidence::new(0, samples);
    evidence.steps = steps.iter().map(as_evidence).collect();
    let mut sized = evidence.clone();
    sized.steps.retain(|step| step.step_size.is_finite());
    let fits: Vec<Fit> = fit_order(&sized).into_iter().collect();
    let case = Case {
        initial,
        steps,
        samples,
        evidence: &evidence,
        fit: fits.first(),
    };
    let verdict = (case.no_loop())
        .or_else(|| case.broken())
        .or_else(|| case.not_symplectic())
        .or_else(|| case.undecided())
        .unwrap_or_else(|| case.symplectic());
    (verdict, fits)
}

fn as_evidence(step: &Compared) -> StepEvidence {
    StepEvidence {
        step_size: step.step_size.unwrap_or(f64::NAN),
        defect: step.defect,
        found: None,
        closing: None,
        cells_apart: 0.0,
    }
}

struct Case<'a> {
    initial: &'a Initial<'a>,
    steps: &'a [Compared],
    samples: usize,
    evidence: &'a LoopEvidence,
    fit: Option<&'a Fit>,
}

/// Jumps of this part of a coordinate's range may be the grain of single precision inside a step, or of a
/// solver that stops at a tolerance.
const GRAIN: f64 = 1e-6;

const MORE_SAMPLES: &str =
    "Take more samples, four times as many or more: symplint loop --samples N.";

impl Case<'_> {
    fn pairs(&self) -> impl Iterator<Item = (&Compared, &StepEvidence)> {
        self.steps.iter().zip(&self.evidence.steps)
    }

    fn worst(&self, wanted: impl Fn(&StepEvidence) -> bool) -> Option<(&Compared, &StepEvidence)> {
        (self.pairs().filter(|(_, step)| wanted(step)))
            .max_by(|a, b| a.1.defect.magnitude().total_cmp(&b.1.defect.magnitude()))
    }

    /// The step by its size, or by its place where that is not known.
    fn at(&self, step: &Compared) -> String {
        match step.step_size {
            Some(h) => format!("at h = {}", size(h)),
            None if self.steps.len() == 1 => "after the step".into(),
            None => {
                let place = self
                    .steps
                    .iter()
                    .position(|other| std::ptr::eq(other, step));
                format!("in loop {} after the step", place.unwrap_or(0) + 1)
            }
        }
    }

    fn undecided_because(&self, summary: String, advice: &[&str]) -> Verdict {
        Verdict {
            kind: VerdictKind::Undecided,
            digits: None,
            order: None,
            summary,
            evidence: self.bounds(),
            advice: advice.iter().map(|&line| line.to_owned()).collect(),
        }
    }

    /// The loop before the step is none, or a loop is cut where a periodic box ends.
    fn no_loop(&self) -> Option<Verdict> {
        let wrapped = |wrap: Wrap, when: &str| {
            self.undecided_because(
                format!(
                    "q of degree of freedom {} jumps by its whole range of {} {when}, as a position in a \
                     periodic box does.",
                    wrap.dof,
                    short(wrap.period)
                ),
                &["State the period: --period, or an array `period` in the file."],
            )
        };
        if let Some(wrap) = self.initial.wrapped {
            return Some(wrapped(wrap, "before the step"));
        }
        if let Some(found) = self.initial.broken {
            return Some(self.undecided_because(
                format!(
                    "Degree of freedom {} already jumps before the step, by {} in q and {} in p near \
                     s = {:.6}: that is no closed loop.",
                    found.dof,
                    short(found.jump_q),
                    short(found.jump_p),
                    found.s
                ),
                &[
                    "Give all samples, in their order along a closed loop; state the period of wrapped \
                     positions.",
                    MORE_SAMPLES,
                ],
            ));
        }
        let wrap = self
            .steps
            .iter()
            .find_map(|step| step.wrapped.map(|w| (w, step)));
        wrap.map(|(wrap, step)| wrapped(wrap, &self.at(step)))
    }

    fn broken(&self) -> Option<Verdict> {
        let jumping = || self.steps.iter().filter(|step| step.largest_jump > GRAIN);
        let step = jumping().max_by_key(|step| step.breaks.len())?;
        let size_of = |found: &crate::breaks::Break| found.jump_q.abs() + found.jump_p.abs();
        let found = (step.breaks.iter()).max_by(|a, b| size_of(a).total_cmp(&size_of(b)))?;
        let mut evidence = vec![format!(
            "The largest jump {}, in degree of freedom {} near s = {:.6}, is {:.3e} in q and {:.3e} in p, \
             with every sample as with every second and every fourth.",
            self.at(step),
            found.dof,
            found.s,
            found.jump_q,
            found.jump_p
        )];
        evidence.extend(
            jumping().filter_map(|step| step.broken.as_ref().map(|b| self.of_breaks(step, b))),
        );
        evidence.extend(self.law());
        evidence.push(format!(
            "Samples are no proof: a flank steeper than 1/{} of the loop looks the same.",
            self.samples
        ));
        Some(Verdict {
            kind: VerdictKind::BrokenLoops,
            digits: None,
            order: None,
            summary: format!(
                "{} of {} advanced loops jump between neighbouring samples, {} times {}: the map is \
                 discontinuous as far as {} samples can tell.",
                jumping().count(),
                self.steps.len(),
                step.breaks.len(),
                self.at(step),
                self.samples
            ),
            evidence,
            advice: vec![
                "If a position lives in a periodic box, state its period (--period).".into(),
                "Take more samples: a jump keeps its size, a steep flank fades.".into(),
                "Use a smoother interpolation: a force that is continuous where particles cross cells."
                    .into(),
                "If a solver inside the step stops at a tolerance, tighten it.".into(),
            ],
        })
    }

    /// What the loop integral does with and without the chords across the breaks.
    fn of_breaks(&self, step: &Compared, broken: &Broken) -> String {
        let closed = &broken.closed_defect;
        format!(
            "{}: {} cells jump, {} beyond doubt. The loop integral without them changes by {:+.3e} ± {:.1e} \
             of itself, with chords across them by {:+.3e} ± {:.1e}.",
            capitalised(&self.at(step)),
            broken.cells,
            broken.confirmed,
            step.defect.signed,
            step.defect.uncertainty(),
            closed.signed,
            closed.uncertainty()
        )
    }

    fn law(&self) -> Option<String> {
        self.fit.map(|fit| {
            format!(
                "The defect goes as h^({:.3} ± {:.3}) between h = {} and h = {}.",
                fit.slope,
                fit.uncertainty,
                size(fit.from),
                size(fit.to)
            )
        })
    }

    fn not_symplectic(&self) -> Option<Verdict> {
        let (compared, step) = self.worst(StepEvidence::is_beyond_doubt)?;
        let defect = step.defect.magnitude();
        let trend = self.fit.filter(|fit| fit.slope > TREND);
        if defect < SMALL && trend.is_none() {
            return None;
        }
        let law = trend.map_or(String::new(), |fit| format!(", {}", fit.law()));
        let mut evidence = vec![format!(
            "{} the loop integral changes by {:+.3e} of itself; quadrature error and round-off are below \
             {:.1e}.",
            capitalised(&self.at(compared)),
            step.defect.signed,
            step.defect.uncertainty()
        )];
        evidence.extend(self.law());
        let mut advice = Vec::new();
        let sized = self
            .steps
            .iter()
            .filter(|step| step.step_size.is_some())
            .count();
        if sized < self.steps.len() {
            advice
                .push("State the step sizes (--h, or `h` in the file) to learn the order.".into());
        } else if self.fit.is_none() {
            advice.push(
                "Give loops after four or more step sizes, halving, to learn the order.".into(),
            );
        } else if trend.is_none() {
            advice.push(
                "The defect does not fall with h: look for a wrong sign, momenta that are not canonical, \
                 or a weight that is missing."
                    .into(),
            );
        }
        Some(Verdict {
            kind: VerdictKind::NotSymplectic,
            digits: None,
            order: trend.and_then(Fit::whole),
            summary: format!(
                "The step changes the loop integral by {defect:.1e} {}{law}.",
                self.at(compared)
            ),
            evidence,
            advice,
        })
    }

    fn undecided(&self) -> Option<Verdict> {
        let deformation = self.deformation();
        if deformation == 0.0 {
            return Some(self.undecided_because(
                "The step did not move the loop, or only as a whole.".into(),
                &["Check that the files after the step are not copies of the one before it."],
            ));
        }
        if deformation < LEAST_DEFORMATION {
            return Some(self.undecided_because(
                format!(
                    "The step deforms the loop by only {deformation:.1e} of its size, too little to show \
                     a defect."
                ),
                &["Take larger step sizes, up to where one step deforms the loop by about its size."],
            ));
        }
        if let Some(step) = self.steps.iter().find(|step| step.largest_jump > 0.0) {
            return Some(self.undecided_because(
                format!(
                    "Jumps of {} of a coordinate's range {} may be breaks, or the grain of single \
                     precision or of a solver inside the step.",
                    short(step.largest_jump),
                    self.at(step)
                ),
                &["Run the step in double precision, with solvers inside it at a tight tolerance."],
            ));
        }
        if let Some(step) = self.steps.iter().find(|step| step.broken.is_some()) {
            let cells = step.broken.map_or(0, |broken| broken.cells);
            return Some(self.undecided_because(
                format!(
                    "{} cells look like jumps {}, but {} samples are too few to tell a jump from a steep \
                     flank.",
                    cells,
                    self.at(step),
                    self.samples
                ),
                &[MORE_SAMPLES],
            ));
        }
        let unknown = |step: &&Compared| step.defect.quadrature_error.is_none();
        if let Some(step) = self.steps.iter().find(unknown) {
            let samples = self.samples;
            let why = if samples < FEWEST {
                format!("{samples} samples do not show whether a loop is smooth; 32 can")
            } else {
                format!(
                    "{samples} samples do not resolve the loop {}",
                    self.at(step)
                )
            };
            return Some(self.undecided_because(
                format!("{why}: its integral is not known."),
                &[
                    MORE_SAMPLES,
                    "If positions are wrapped, state their period.",
                ],
            ));
        }
        if let Some((compared, step)) = self.worst(StepEvidence::is_unexplained) {
            return Some(self.undecided_because(
                format!(
                    "A defect of {:.1e} {} is more than quadrature error and round-off explain ({:.1e}) and \
                     too little to be sure.",
                    step.defect.magnitude(),
                    self.at(compared),
                    step.defect.uncertainty()
                ),
                &["Take more samples and larger step sizes: a true defect grows with h, an error does not."],
            ));
        }
        let weak = self.evidence.weak_step()?;
        let of_roundoff = weak.defect.roundoff > 0.5 * weak.defect.uncertainty();
        Some(self.undecided_because(
            format!("The numbers only bound the defect by {:.1e}.", weak.bound()),
            if of_roundoff {
                &["Store more digits, in double precision, or take a larger loop nearer to the origin."]
            } else {
                &[MORE_SAMPLES]
            },
        ))
    }

    fn symplectic(&self) -> Verdict {
        let bound = (self.evidence.steps.iter())
            .map(StepEvidence::bound)
            .fold(f64::EPSILON, f64::max);
        let sizes = self.steps.iter().filter_map(|step| step.step_size);
        let (low, high) = sizes.fold((f64::INFINITY, 0.0), |(l, h): (f64, f64), size| {
            (l.min(size.abs()), h.max(size.abs()))
        });
        let range = if high == 0.0 {
            "; the step size is not stated".to_owned()
        } else if low == high {
            format!(" at h = {}", size(high))
        } else {
            format!(" for h from {} to {}", size(low), size(high))
        };
        Verdict {
            kind: VerdictKind::Symplectic,
            digits: Some((-bound.log10() * 10.0).floor() / 10.0),
            order: None,
            summary: format!("No defect above {bound:.1e} on the given loop{range}."),
            evidence: self.bounds(),
            advice: vec![
                "One loop is one probe: measure others, too (loop.shape = \"fourier\", another loop.seed)."
                    .into(),
            ],
        }
    }

    fn deformation(&self) -> f64 {
        (self.steps.iter()).fold(0.0, |m: f64, step| m.max(step.deformation))
    }

    fn bounds(&self) -> Vec<String> {
        let mut lines: Vec<String> = (self.pairs())
            .map(|(compared, step)| match step.defect.quadrature_error {
                Some(_) => format!(
                    "{}: |E| ≤ {:.1e}; measured {} ± {:.1e}.",
                    capitalised(&self.at(compared)),
                    step.bound(),
                    short(step.defect.magnitude()),
                    step.defect.uncertainty()
                ),
                None => format!(
                    "{}: nothing is known of E.",
                    capitalised(&self.at(compared))
                ),
            })
            .collect();
        lines.push(format!(
            "{} samples: what is narrower than 1/{} of the loop is not seen.",
            self.samples, self.samples
        ));
        lines.push(format!(
            "The step deforms the loop by {} of its size.",
            short(self.deformation())
        ));
        lines
    }
}
