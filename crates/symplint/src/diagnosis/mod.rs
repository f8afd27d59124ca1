//! Measuring: sweeps over the step size and the number of samples, random loops, the Jacobian, many steps.

mod checks;
mod limits;
mod measure;
mod missing;
mod plan;
mod progress;
mod resolve;
mod step_sizes;

pub use limits::MAX_LOOPS;
pub(crate) use limits::MIN_BUDGET;
pub use progress::Progress;

use std::sync::Arc;

use crate::error::Error;
use crate::evidence::Point;
use crate::rules::{Piecewise, Rule, Streaming};

/// How many samples a loop gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleCount {
    /// Doubled from 2048/d, at least 64, until the quadrature error of the largest step reaches round-off, stops
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

/// The settings of a diagnosis: [`Diagnostic::run`] measures, and computes the verdict.
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
/// let diagnosis = Diagnostic::halving(-1, -6).run(&map, &circle)?;
/// assert_eq!(diagnosis.verdict.kind, VerdictKind::Symplectic);
/// # Ok::<(), symplint::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Diagnostic {
    /// The rule.
    pub rule: Rule,
    /// The piecewise rule that [`Rule::Auto`] uses.
    pub piecewise: Piecewise,
    /// The streaming rule that [`Rule::Auto`] uses.
    pub streaming: Streaming,
    /// The number of samples, for all rules but the piecewise one.
    pub samples: SampleCount,
    /// Step sizes h, not zero. The verdict leans on the largest.
    pub step_sizes: Vec<f64>,
    /// Whether the map has a step size. A map without one (a kicker, one turn of a ring) is tested itself: it is called with
    /// h = 1, `step_sizes` and `typical_step` are not used, and no order is determined.
    pub has_step_size: bool,
    /// The map is composed with itself this number of times, 1 or more. Each state then takes this number of evaluations.
    pub repeat: usize,
    /// A typical step size, if there are no `step_sizes`: those tried are the largest that advances the motions on
    /// the loop by about a radian and that the map can take, and seven halvings of it; all of them are this one times
    /// a power of two.
    pub typical_step: Option<f64>,
    /// An optional sweep over the number of samples.
    pub sample_sweep: Option<SampleSweep>,
    /// Loops in all, [`MAX_LOOPS`] at most: the given one, and random ones of its size round its centre that are tried at
    /// the largest step size; the first of them that shows a defect is tried at all. One
    /// loop is one probe, and a symmetric one hides terms of lower order. If there are two or more, and
    /// a position has a period, another random loop winds round it.
    pub loops: usize,
    /// Seed of the random loops.
    pub seed: u64,
    /// Whether loops, the given one included, and the states of the Jacobian are put on the
    /// [manifold](crate::map::Constraint) that a map acts on, if it names one.
    pub project: bool,
    /// So many steps of the largest size of the given loop, to see whether a defect adds up; 0 for none.
    pub long_time: usize,
    /// The order of the method, if the user knows it: a defect at a lower power of h than this order allows then has a cause outside
    /// the method.
    pub order: Option<usize>,
    /// Whether a defect is traced to substeps of the map, and to parts of the loop.
    pub localise: bool,
    /// Whether the Jacobian of the largest step is measured, too. If not, it is measured at one point, and only if a loop integral changes.
    pub jacobian: bool,
    /// Whether other properties of the map are tested: see [`Verdict::properties`](crate::Verdict::properties).
    pub properties: bool,
    /// Signs ±1 of all coordinates, positions first, that reverse time: a map is time-reversible if it returns states whose
    /// signs are changed after one step to themselves by a second one. `None` changes the signs of all momenta.
    pub reversal: Option<Vec<f64>>,
    /// Whether Φ_−h Φ_h is compared with the identity. The map is called with negative step sizes then, which not every code takes.
    pub symmetric: bool,
    /// Evaluations of the map in all, 200 or more; `None` for a million. A tight budget tries fewer step sizes,
    /// fewer random loops and fewer samples, and the verdict says what was left out.
    pub budget: Option<usize>,
}

impl Default for Diagnostic {
    /// Step sizes 2^-1 … 2^-10, everything else automatic, eight loops.
    fn default() -> Self {
        Diagnostic {
            rule: Rule::Auto,
            piecewise: Piecewise::default(),
            streaming: Streaming::default(),
            samples: SampleCount::Auto,
            step_sizes: (1..=10).map(|m| 0.5f64.powi(m)).collect(),
            has_step_size: true,
            repeat: 1,
            typical_step: None,
            sample_sweep: None,
            loops: 8,
            seed: 1,
            project: true,
            long_time: 0,
            order: None,
            localise: true,
            jacobian: true,
            properties: true,
            reversal: None,
            symmetric: false,
            budget: None,
        }
    }
}

/// What happens while a diagnosis runs.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Event<'a> {
    /// The diagnosis begins. Its progress can be read from now on.
    Started(&'a Arc<Progress>),
    /// So many more points will be measured.
    Planned(usize),
    /// A point was measured.
    Measured(&'a Point),
    /// The map failed at a step size on the given loop: with this error, which names both. The others are measured all the
    /// same.
    Failed(&'a Error),
}

impl Diagnostic {
    /// A search for step sizes, from a typical one; everything else as by default.
    ///
    /// ```
    /// use symplint::{Circle, Diagnostic, PerSample};
    ///
    /// // Jupiter round the Sun, in astronomical units and days, by symplectic Euler.
    /// let map = PerSample::new(2, |h, q, p| {
    ///     let r3 = q[0].hypot(q[1]).powi(3);
    ///     (0..2).for_each(|i| p[i] -= h * 2.959e-4 * q[i] / r3);
    ///     (0..2).for_each(|i| q[i] += h * p[i]);
    /// });
    /// let circle = Circle::new(vec![5.2, 0.0], vec![0.0, 7.5e-3], 1e-3)?;
    /// let diagnosis = Diagnostic::around(1.0).run(&map, &circle)?;
    /// let largest = diagnosis.points()[0].step_size;
    /// assert!((256.0..2048.0).contains(&largest));
    /// # Ok::<(), symplint::Error>(())
    /// ```
    pub fn around(typical_step: f64) -> Self {
        Diagnostic {
            step_sizes: Vec::new(),
            typical_step: Some(typical_step),
            ..Diagnostic::default()
        }
    }

    /// A map without a step size; everything else as by default.
    ///
    /// ```
    /// use symplint::{Circle, Diagnostic, PerSample, VerdictKind};
    ///
    /// // The fringe field of a magnet.
    /// let map = PerSample::new(1, |_, q, p| {
    ///     p[0] /= 1.0 + 0.3 * q[0] * q[0];
    ///     q[0] += 0.1 * q[0].powi(3);
    /// });
    /// let circle = Circle::new(vec![2e-3], vec![1e-3], 8e-3)?;
    /// let diagnosis = Diagnostic::without_step_size().run(&map, &circle)?;
    /// assert_eq!(diagnosis.verdict.kind, VerdictKind::Symplectic);
    /// # Ok::<(), symplint::Error>(())
    /// ```
    pub fn without_step_size() -> Self {
        Diagnostic {
            has_step_size: false,
            ..Diagnostic::default()
        }
    }

    /// Step sizes 2^`from`, 2^(`from` − 1), …, 2^`to`; everything else as by default.
    pub fn halving(from: i32, to: i32) -> Self {
        Diagnostic {
            step_sizes: (to..=from).rev().map(|m| 2f64.powi(m)).collect(),
            ..Diagnostic::default()
        }
    }
}
