//! The whole diagnosis: sweeps over the step size and the number of samples, and the verdict.

mod departures;
mod doubling;
mod localise;
mod long_time;
mod nested;
mod point;
mod probe;
mod random_loop;
mod resolve;
mod second;
mod streamed;
mod study;

pub use localise::{Localisation, Sector, Stage};
pub use long_time::{Growth, LongTime};
pub use point::{Point, Sweep};
pub(crate) use streamed::{SMALL, fits};

use serde::Serialize;

use crate::breaks::Break;
use crate::error::Error;
use crate::jacobian::JacobianEvidence;
use crate::loops::Loop;
use crate::map::{EvaluationCount, Evaluator, TimeAdvance};
use crate::rules::Piecewise;
use crate::rules::Rule;
use crate::rules::Streaming;
use crate::survey;
use crate::verdict::{Fit, LoopEvidence, Verdict, judge, size};
use probe::Subject;
use random_loop::{random_loop, winding_loop};
use study::Study;

/// Which rule computes the loop integrals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RuleChoice {
    /// Pseudospectral where the advanced loop of the largest step size is smooth enough to reach round-off
    /// that way; piecewise where it is broken, or has kinks; streaming where ensembles would take more than
    /// 512 MiB.
    Auto,
    /// This one, from equispaced samples.
    Fixed(Rule),
    /// The piecewise rule.
    Piecewise,
    /// The streaming rule: no more than a few dozen states in memory.
    Streaming,
}

/// How many samples a loop gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleCount {
    /// Doubled from 4096/d, 64 at least, until the quadrature error of the largest step reaches round-off, stops
    /// falling, or the ensemble reaches its limit (65,536 samples or 512 MiB, before and after the step; by
    /// the streaming rule 2^30 coordinates to be advanced).
    Auto,
    /// This many, 3 or more.
    Fixed(usize),
}

/// A sweep over the number of samples at one step size.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleSweep {
    /// Numbers of samples, each 3 or more.
    pub counts: Vec<usize>,
    /// The step size.
    pub step_size: f64,
}

/// What to measure; [`Diagnostic::run`] measures it.
///
/// ```
/// use symplint::{Circle, Diagnostic, PerSample, VerdictKind};
///
/// // A pendulum by symplectic Euler.
/// let map = PerSample::new(1, |h, q, p| {
///     p[0] -= h * q[0].sin();
///     q[0] += h * p[0];
/// });
/// let circle = Circle::new(vec![0.3], vec![0.5], 1.0)?;
/// let diagnosis = Diagnostic::halving(-1, -6).run(&map, &circle, &|_| {})?;
/// assert_eq!(diagnosis.verdict.kind, VerdictKind::Symplectic);
/// # Ok::<(), symplint::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Diagnostic {
    /// The rule.
    pub rule: RuleChoice,
    /// What the piecewise rule aims at, where it is used.
    pub piecewise: Piecewise,
    /// The stencil of the streaming rule, where it is used.
    pub streaming: Streaming,
    /// The number of samples, for all rules but the piecewise one.
    pub samples: SampleCount,
    /// Step sizes h, not zero. The verdict leans on the largest.
    pub step_sizes: Vec<f64>,
    /// An optional sweep over the number of samples.
    pub sample_sweep: Option<SampleSweep>,
    /// Loops in all: the given one, and random ones of its size round its centre that are tried at
    /// the largest step size; the first of them that shows a defect is tried at all. One
    /// loop is one probe, and a symmetric one hides terms of lower order. If there are two or more, and
    /// a position has a period, another random loop winds round it.
    pub loops: usize,
    /// Seed of the random loops.
    pub seed: u64,
    /// So many steps of the largest size of the given loop, to see whether a defect adds up; 0 for none.
    pub long_time: usize,
    /// Whether a defect is looked for in the substeps of the map, and in the parts of the loop.
    pub stages: bool,
    /// Whether the Jacobian of the largest step is asked for a second opinion.
    pub jacobian: bool,
}

impl Default for Diagnostic {
    /// Step sizes 2^-1 … 2^-10, everything else automatic, eight loops.
    fn default() -> Self {
        Diagnostic {
            rule: RuleChoice::Auto,
            piecewise: Piecewise::default(),
            streaming: Streaming::default(),
            samples: SampleCount::Auto,
            step_sizes: (1..=10).map(|m| 0.5f64.powi(m)).collect(),
            sample_sweep: None,
            loops: 8,
            seed: 1,
            long_time: 0,
            stages: true,
            jacobian: true,
        }
    }
}

/// What happens while a diagnosis runs.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// So many more points will be measured.
    Planned(usize),
    /// A point was measured.
    Measured(&'a Point),
}

/// A break, and the advanced loop that has it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BreakAt {
    /// Which loop: 0 is the given one, the others are random.
    #[serde(rename = "loop")]
    pub loop_index: usize,
    /// Step size h.
    pub step_size: f64,
    /// Where it is and how far the coordinates jump.
    #[serde(flatten)]
    pub found: Break,
}

/// The outcome of a [`Diagnostic`].
#[derive(Clone, Debug, Serialize)]
pub struct Diagnosis {
    /// The verdict with its reasons.
    pub verdict: Verdict,
    /// Everything measured.
    pub points: Vec<Point>,
    /// Power laws fitted to the points.
    pub fits: Vec<Fit>,
    /// The breaks that were found: all of the given loop at the largest step size, by the piecewise
    /// rule; else the largest one of each advanced loop.
    pub breaks: Vec<BreakAt>,
    /// What became of the defect in many steps, where that was asked for.
    pub long_time: Option<LongTime>,
    /// Which substep and which part of the loop the defect comes from, if there is one.
    pub localisation: Option<Localisation>,
    /// What the Jacobian of the largest step says at points of the given loop, where it was asked.
    pub jacobian: Option<JacobianEvidence>,
}

impl Diagnostic {
    /// Step sizes 2^`from`, 2^(`from` − 1), …, 2^`to`; everything else as by default.
    pub fn halving(from: i32, to: i32) -> Self {
        Diagnostic {
            step_sizes: (to..=from).rev().map(|m| 2f64.powi(m)).collect(),
            ..Diagnostic::default()
        }
    }

    /// Measures and judges, on the threads of the current Rayon pool.
    ///
    /// `watch` is told of each point as it is measured. Where the number of samples is looked for, or
    /// swept over, samples before and after a step are kept and doubled. In a sweep over step sizes one ensemble is
    /// in memory, and the samples before the step besides where they take 64 MiB at most; larger ones are made
    /// anew for each step size, block by block. By the streaming rule it is a few dozen states; what needs larger ensembles (the Jacobian test, many steps) is then left out where
    /// they take more than 512 MiB.
    ///
    /// # Errors
    /// If map and loop do not fit, a step size is zero or not finite, the map gives different states
    /// for the same one, the loop encloses no area, or the map fails or returns states that are not finite.
    pub fn run(
        &self,
        map: &dyn TimeAdvance,
        phase_loop: &dyn Loop,
        watch: &dyn Fn(Event<'_>),
    ) -> Result<Diagnosis, Error> {
        let largest = self.largest_step()?;
        let count = EvaluationCount::unlimited();
        let evaluator = Evaluator::new(map, &count)?;
        evaluator.check_dof(phase_loop.dof())?;
        survey::check(&evaluator, phase_loop, largest)?;
        let mut study = Study {
            watch,
            points: Vec::new(),
            breaks: Vec::new(),
            regularity: None,
            largest,
        };
        let subject = Subject {
            evaluator: &evaluator,
            phase_loop,
            coordinates: evaluator.coordinates(),
        };
        let configured = self.resolve(0, subject, largest)?;
        let mut loops = vec![study.sweep_steps(&configured, &self.step_sizes)?];
        if let Some(sweep) = &self.sample_sweep {
            study.sweep_samples(&configured, sweep)?;
        }
        for index in 1..self.loops {
            let random = random_loop(phase_loop, self.seed.wrapping_add(index as u64))?;
            let subject = Subject {
                phase_loop: &random,
                ..subject
            };
            // The order is that of a full sweep, and a symmetric loop hides terms of lower
            // order: the given loop and one random one are worth it.
            let known = loops[1..].iter().any(LoopEvidence::shows_defect);
            loops.push(match self.try_random(&mut study, index, subject, known) {
                Ok(evidence) => evidence,
                // A loop that nobody asked for may leave the map's domain.
                Err(
                    error @ (Error::NotFinite { .. }
                    | Error::StepFailed { .. }
                    | Error::OnTheWay { .. }),
                ) => LoopEvidence::failed(index, error),
                Err(error) => return Err(error),
            });
        }
        if self.loops > 1 && !loops[0].winds {
            loops.extend(self.try_winding(&mut study, subject)?);
        }
        let deformation = survey::deformation(&evaluator, phase_loop, largest)?;
        let (mut verdict, fits) = judge(&loops, deformation);
        verdict
            .evidence
            .extend(study.regularity.and_then(|s| roughness(s, largest)));
        survey::own_up(&evaluator, phase_loop, largest, &mut verdict);
        let long_time = match self.long_time {
            0 => None,
            steps => long_time::follow(&configured, largest, steps, &mut verdict)?,
        };
        let localisation = match configured.is_beyond_memory() {
            true => None,
            false => self.localise(subject, &loops, &mut verdict, largest),
        };
        let jacobian = match self.jacobian {
            true if configured.is_beyond_memory() => {
                let line = "The Jacobian test was left out: its states would not fit into memory.";
                verdict.evidence.push(line.into());
                None
            }
            true => second::opinion(&subject, largest, &mut verdict),
            false => None,
        };
        Ok(Diagnosis {
            long_time,
            localisation,
            jacobian,
            verdict,
            points: study.points,
            fits,
            breaks: study.breaks,
        })
    }

    /// A random loop round the period of a position, where there is one, at the largest step size.
    fn try_winding(
        &self,
        study: &mut Study<'_>,
        subject: Subject<'_>,
    ) -> Result<Option<LoopEvidence>, Error> {
        let (index, seed) = (self.loops, self.seed.wrapping_add(self.loops as u64));
        let found = winding_loop(subject.phase_loop, subject.coordinates, seed)?;
        let Some(winding) = found else {
            return Ok(None);
        };
        let subject = Subject {
            phase_loop: &winding,
            ..subject
        };
        match self.try_random(study, index, subject, true) {
            Ok(evidence) => Ok(Some(evidence)),
            // Nobody asked for it.
            Err(
                Error::NotFinite { .. }
                | Error::StepFailed { .. }
                | Error::OnTheWay { .. }
                | Error::NoArea { .. }
                | Error::LostInRounding { .. },
            ) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// A random loop at the largest step size; at all if it shows a defect and none did before.
    fn try_random(
        &self,
        study: &mut Study<'_>,
        index: usize,
        subject: Subject<'_>,
        known: bool,
    ) -> Result<LoopEvidence, Error> {
        let largest = self.largest_step()?;
        let probe = self.resolve(index, subject, largest)?;
        let mut evidence = study.sweep_steps(&probe, &[largest])?;
        if evidence.shows_defect() && !known {
            let others: Vec<f64> = (self.step_sizes.iter().copied())
                .filter(|&h| h != largest)
                .collect();
            let rest = study.sweep_steps(&probe, &others)?;
            evidence.steps.extend(rest.steps);
        }
        Ok(evidence)
    }

    /// The step size of the largest size, after checking them all.
    fn largest_step(&self) -> Result<f64, Error> {
        let of_samples = self.sample_sweep.as_ref().map(|sweep| sweep.step_size);
        for &h in self.step_sizes.iter().chain(&of_samples) {
            if !h.is_finite() || h == 0.0 {
                return Err(Error::OutOfRange {
                    what: "step size",
                    value: h,
                    remedy: "give finite step sizes that are not zero",
                });
            }
        }
        let largest = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
        (self.step_sizes.iter().copied().reduce(largest)).ok_or(Error::OutOfRange {
            what: "number of step sizes",
            value: 0.0,
            remedy: "give one or more",
        })
    }
}

/// What a Sobolev exponent says of a loop that is not smooth.
fn roughness(exponent: f64, h: f64) -> Option<String> {
    let what = match exponent {
        0.25..1.0 => "as at jumps",
        1.0..2.0 => "as at kinks",
        2.0..4.5 => "as where a higher derivative jumps",
        _ => return None,
    };
    let h = size(h);
    Some(format!(
        "After the step of h = {h} the Fourier coefficients of the given loop fall as those of a function in \
         H^{exponent:.1}: {what}, or on flanks that the samples do not resolve."
    ))
}
