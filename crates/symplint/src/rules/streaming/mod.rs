//! The streaming rule: ∮ p·dq of ensembles that do not fit into memory.
//!
//! A centred difference of order 2m ([`Stencil`]) needs the m samples on either side. So samples are
//! made, advanced and used up in their order ([`window`]), with no more kept of each degree of freedom
//! than a few sums ([`row`]): memory is O(m d), not O(N_s d). The first m samples are made again at the
//! end, to close the loop.

mod row;
mod window;

use crate::breaks::{Break, REACH, SearchResult, Suspect, follow_up, most_outstanding};
use crate::error::Error;
use crate::loops::Loop;
use crate::map::{EvaluationCount, Evaluator, TimeAdvance};
use crate::rules::stencil::Stencil;
use crate::rules::{
    Defect, LoopAfterStep, LoopIntegral, LoopIntegrator, RuleKind, Samples, Subject,
};
use crate::signal::CompensatedSum;
use crate::state::Coordinates;
use row::{MAX_HALF_WIDTH, Row};
use window::{Source, Window};

/// The streaming rule: a centred difference of order 2m along the loop, in the memory of a few dozen states.
///
/// On smooth loops it is as good as the pseudospectral rule from twice the samples, or four times as
/// many: a mode whose phase advances by θ from sample to sample has a relative error of about θ^{2m} (m!)²/(2m+1)!.
///
/// ```
/// use symplint::{Circle, PerSample};
/// use symplint::rules::Streaming;
///
/// // A unit mass on a unit spring by the explicit midpoint rule: areas grow by 1 + h⁴/4.
/// let map = PerSample::new(1, |h, q, p| {
///     let (q_half, p_half) = (q[0] + 0.5 * h * p[0], p[0] - 0.5 * h * q[0]);
///     q[0] += h * p_half;
///     p[0] -= h * q_half;
/// });
/// let circle = Circle::new(vec![3.0], vec![0.0], 1.0)?;
/// let after = Streaming::default().integrate(&map, &circle, 0.5, 256)?.integral;
/// let expected = std::f64::consts::PI * (1.0 + 0.5f64.powi(4) / 4.0);
/// assert!((after.value - expected).abs() < 1e-14);
/// # Ok::<(), symplint::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Streaming {
    /// m: neighbours on either side in the stencil, from 8 to 16. The search for jumps uses 10 samples, so
    /// narrower stencils save no memory.
    pub half_width: usize,
}

impl Default for Streaming {
    /// Order 20, which takes as many samples as the detector of jumps.
    fn default() -> Self {
        Streaming { half_width: REACH }
    }
}

/// The result of the streaming rule for an advanced loop.
#[derive(Clone, Debug)]
pub struct StreamingIntegral {
    /// The loop integral. Its quadrature error is estimated from the differences of order m of all samples,
    /// which bound what the stencil misses and show what the samples do.
    ///
    /// Of a broken loop it tends to the integral with its breaks closed by chords.
    pub integral: LoopIntegral,
    /// A break to which the samples led, if there is one; jumps below 1e-11 of the range of their coordinates
    /// are taken for rounding.
    pub found: Option<Break>,
    /// Cells of the map's grid, or half periods of a position, between neighbouring samples at most; 0
    /// for a map with neither.
    pub cells_apart: f64,
    /// States advanced, those for finding a break aside.
    pub evaluations: usize,
}

impl Streaming {
    /// The fewest neighbours on either side.
    pub const MIN_HALF_WIDTH: usize = 8;

    /// The most neighbours on either side.
    pub const MAX_HALF_WIDTH: usize = MAX_HALF_WIDTH;

    /// Integrates the loop that `map` makes of `phase_loop` in one step of size `h`, from `samples` samples.
    ///
    /// Needs the memory of m + 16 states, 11 for sums, and what the map itself needs while it advances 16
    /// states, in two blocks; more states, up to 16 MiB, in few degrees of freedom. On the threads of the
    /// current Rayon pool; the result does not depend on their number.
    ///
    /// # Errors
    /// If map and loop differ in their degrees of freedom, the stencil is too narrow or too wide, for the samples
    /// or altogether, the map fails or returns states that are not finite, or the integral overflows.
    pub fn integrate(
        &self,
        map: &dyn TimeAdvance,
        phase_loop: &dyn Loop,
        h: f64,
        samples: usize,
    ) -> Result<StreamingIntegral, Error> {
        let count = EvaluationCount::unlimited();
        self.integrate_with(&Evaluator::new(map, &count)?, phase_loop, h, samples)
    }

    /// The same with the evaluations counted by `evaluator`.
    pub(crate) fn integrate_with(
        &self,
        evaluator: &Evaluator<'_>,
        phase_loop: &dyn Loop,
        h: f64,
        samples: usize,
    ) -> Result<StreamingIntegral, Error> {
        evaluator.check_dof(phase_loop.dof())?;
        let coordinates = evaluator.coordinates();
        let source = Source {
            phase_loop,
            samples,
            step: Some((evaluator, h)),
        };
        let revolution = self.revolution(&source, coordinates)?;
        // Between the samples only as many states are needed: the window is gone.
        let found = follow_up(
            evaluator,
            phase_loop,
            h,
            &revolution.suspects,
            samples,
            None,
        )?;
        let is_substantial = |found: &Break| {
            let of_found = revolution.suspects.iter().zip(&revolution.ranges);
            let mut ranges = of_found.filter(|(suspect, _)| suspect.dof == found.dof);
            ranges.any(|(_, &ranges)| found.is_substantial(ranges))
        };
        let mut integral = revolution.integral;
        if found == SearchResult::Unaffordable {
            integral.quadrature_error = None;
        }
        let found = match found {
            SearchResult::Found(found) => Some(found).filter(is_substantial),
            SearchResult::Clean | SearchResult::Unaffordable => None,
        };
        Ok(StreamingIntegral {
            found,
            integral,
            cells_apart: revolution.cells_apart,
            evaluations: samples + self.half_width.max(REACH),
        })
    }

    /// Integrates the loop itself, by the same stencil from as many samples: what
    /// [`integrate`](Self::integrate) is to be compared with.
    ///
    /// # Errors
    /// If `coordinates` has other degrees of freedom than the loop; else as there.
    pub fn initial(
        &self,
        phase_loop: &dyn Loop,
        coordinates: &Coordinates,
        samples: usize,
    ) -> Result<LoopIntegral, Error> {
        let source = Source {
            phase_loop,
            samples,
            step: None,
        };
        Ok(self.revolution(&source, coordinates)?.integral)
    }

    /// The loop once round.
    fn revolution(
        &self,
        source: &Source<'_>,
        coordinates: &Coordinates,
    ) -> Result<Revolution, Error> {
        self.check(source.samples)?;
        let dof = source.phase_loop.dof();
        Error::check_length("coordinates", dof, coordinates.dof())?;
        let stencil = Stencil::new(self.half_width);
        let (samples, old) = (source.samples, self.half_width.max(REACH));
        let mut window = Window::new(dof, old)?;
        let mut rows = vec![Row::default(); dof];
        let mut cells_apart = 0.0f64;

        let periods = |i: usize| [coordinates.period(i), coordinates.momentum_period(i)];
        window.begin(source, 0, old)?;
        window.consume(0, &mut rows, |i, row, q, p| {
            row.begin(q, p, periods(i));
            0.0
        });
        let mut next = old;
        let mut use_up = |window: &mut Window, next: usize, count: usize| {
            let furthest = window.consume(count, &mut rows, |i, row, q, p| {
                let furthest = row.add(&stencil, [old, next], q, p, periods(i));
                furthest / spacing(coordinates, i)
            });
            cells_apart = cells_apart.max(furthest);
        };
        while next < samples {
            let count = window.capacity().min(samples - next);
            window.fill(source, next, count)?;
            use_up(&mut window, next, count);
            next += count;
        }
        window.fill(source, 0, old)?;
        use_up(&mut window, next, old);
        Revolution::new(&rows, &window, &stencil, source, coordinates, cells_apart)
    }

    fn check(&self, samples: usize) -> Result<(), Error> {
        if !(Self::MIN_HALF_WIDTH..=Self::MAX_HALF_WIDTH).contains(&self.half_width) {
            return Err(Error::OutOfRange {
                what: "half width of the streaming rule's stencil",
                value: self.half_width as f64,
                remedy: "take 8 to 16 neighbours on either side",
            });
        }
        if samples < 2 * self.half_width + 1 {
            return Err(Error::StencilTooWide {
                samples,
                half_width: self.half_width,
            });
        }
        Ok(())
    }
}

impl LoopIntegrator for Streaming {
    fn kind(&self) -> RuleKind {
        RuleKind::Streaming
    }

    fn keeps_samples(&self) -> bool {
        false
    }

    fn before(&self, subject: &Subject<'_>, samples: Samples<'_>) -> Result<LoopIntegral, Error> {
        self.initial(subject.phase_loop, subject.coordinates(), samples.count())
    }

    fn after(
        &self,
        subject: &Subject<'_>,
        h: f64,
        samples: Samples<'_>,
        initial: &LoopIntegral,
    ) -> Result<LoopAfterStep, Error> {
        let Subject {
            evaluator,
            phase_loop,
        } = *subject;
        let found = self.integrate_with(evaluator, phase_loop, h, samples.count())?;
        Ok(LoopAfterStep {
            defect: Defect::between(initial, &found.integral)?,
            regularity: None,
            integral: found.integral,
            breaks: found.found.into_iter().collect(),
            closed: None,
            samples: samples.count(),
            cells_apart: found.cells_apart,
        })
    }
}

/// What matters between neighbouring samples of q_i: a cell of the grid, half a period, the smaller of them;
/// infinite where there is neither.
fn spacing(coordinates: &Coordinates, i: usize) -> f64 {
    let or_infinite = |width: f64| if width > 0.0 { width } else { f64::INFINITY };
    or_infinite(coordinates.grid_spacing()).min(or_infinite(0.5 * coordinates.period(i)))
}

/// The sums of one turn round the loop.
struct Revolution {
    integral: LoopIntegral,
    suspects: Vec<Suspect>,
    /// Ranges of q and p in the degree of freedom of each suspect.
    ranges: Vec<[f64; 2]>,
    cells_apart: f64,
}

impl Revolution {
    /// Adds the degrees of freedom in their order.
    fn new(
        rows: &[Row],
        window: &Window,
        stencil: &Stencil,
        source: &Source<'_>,
        coordinates: &Coordinates,
        cells_apart: f64,
    ) -> Result<Self, Error> {
        let mut contributions = Vec::with_capacity(rows.len());
        let mut total = CompensatedSum::default();
        let (mut quadrature_error, mut roundoff, mut scale) = (Some(0.0), 0.0, 0.0);
        let mut suspects = Vec::new();
        for (dof, row) in rows.iter().enumerate() {
            let (q, p) = window.history(dof);
            let periods = [coordinates.period(dof), coordinates.momentum_period(dof)];
            let of_row = row.integral(stencil, q, p, periods);
            let weight = coordinates.weight(dof);
            let contribution = weight * of_row.value;
            let error = of_row.quadrature_error.unwrap_or(0.0);
            let all = of_row.value.abs() + of_row.scale + of_row.roundoff + error;
            let value = weight.abs() * all;
            if !value.is_finite() {
                return Err(Error::Overflow { dof, value });
            }
            total.add(contribution);
            contributions.push(contribution);
            quadrature_error = (quadrature_error.zip(of_row.quadrature_error))
                .map(|(sum, error): (f64, f64)| sum + weight.abs() * error);
            roundoff += weight.abs() * of_row.roundoff;
            scale += weight.abs() * of_row.scale;
            suspects.extend(row.suspects(dof, source.samples, q.len()));
        }
        most_outstanding(&mut suspects);
        let value = total.total();
        Ok(Revolution {
            integral: LoopIntegral {
                value,
                contributions,
                quadrature_error,
                roundoff: roundoff + f64::EPSILON * value.abs(),
                scale,
                omitted: None,
                regularity: None,
            },
            ranges: (suspects.iter().map(|s| rows[s.dof].ranges())).collect(),
            suspects,
            cells_apart,
        })
    }
}
