//! The piecewise rule: ∮ p·dq of a loop that a map may have broken, to near round-off.
//!
//! A map can be evaluated at any s. So the advanced loop is cut into pieces, each the image of a
//! polynomial to the tolerance ([`piece`]); jumps are found by what they do to the Chebyshev
//! coefficients of a piece ([`lobatto`]) and closed in on until no double lies between
//! ([`bracket`]), kinks are cut at. States are evaluated in large batches, all pieces at once
//! ([`queue`]).
//!
//! The pieces give the absolutely continuous integral. The breaks are closed by segments
//! ([`closure`]): for a step that is a composition, where a break is born, and the segment is sent
//! through the rest of the step as another curve.

mod bracket;
mod chance;
mod closure;
mod curves;
mod fit;
mod integrator;
mod lobatto;
mod noise;
mod path;
mod piece;
mod places;
mod queue;
mod scales;
mod task;
mod twins;

use crate::breaks::Break;
use crate::error::Error;
use crate::loops::Loop;
use crate::map::{EvaluationCount, Evaluator, TimeAdvance};
use crate::rules::LoopIntegral;
use crate::signal::nearest;
use crate::signal::{CompensatedSum, UNIT_ROUNDOFF};
use crate::state::Ensemble;
use chance::doubt_of_chance;
use closure::{Chord, close};
use curves::Curves;
use fit::POINTS;
pub(crate) use integrator::Identity;
use piece::{Piece, Smooth};
use places::doubt_of_places;
use queue::Queue;
use scales::Scales;
use twins::look_for_twins;

/// How the segments that close breaks are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Closure {
    /// Between the ends of the advanced loop: straight chords.
    Chords,
    /// Where the substep breaks the loop, and then carried through the remaining substeps. A map that
    /// is one whole has straight chords.
    ///
    /// A composition of symplectic substeps with continuous potentials then conserves the closed
    /// integral to round-off at every step size, however often its force jumps.
    #[default]
    Substeps,
}

/// The piecewise rule: adaptive, for maps that can be evaluated at any s.
///
/// ```
/// use symplint::{Circle, PerSample, Piecewise};
///
/// // Position-first Strang splitting on H = p²/2 + |q|: the force jumps at q = 0.
/// let map = PerSample::new(1, |h, q, p| {
///     q[0] += 0.5 * h * p[0];
///     p[0] -= h * if q[0] < 0.0 { -1.0 } else { 1.0 };
///     q[0] += 0.5 * h * p[0];
/// });
/// let circle = Circle::new(vec![0.0], vec![0.0], 1.0)?;
/// let h: f64 = 0.5;
/// let found = Piecewise::default().integrate(&map, &circle, h)?;
///
/// // The paper's closed form of the absolutely continuous integral.
/// let expected = std::f64::consts::PI + 4.0 * h * h / (h * h + 4.0).sqrt();
/// assert!((found.continuous.value - expected).abs() < 1e-12);
/// // Two breaks, and a closed integral that is conserved.
/// assert_eq!(found.breaks.len(), 2);
/// assert!((found.closed().value - std::f64::consts::PI).abs() < 1e-13);
/// # Ok::<(), symplint::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piecewise {
    /// What an interpolant may be off, relative to the size of each coordinate on the loop.
    pub tolerance: f64,
    /// How breaks are closed.
    pub closure: Closure,
    /// Pieces to begin with. What happens between the states of a piece that looks smooth is not
    /// seen, but where a position turns round.
    pub pieces: usize,
    /// States to be advanced at most, but for a first look, of 12 states and 15 for each of the first pieces;
    /// what is not resolved by then is reported.
    pub most_evaluations: usize,
}

impl Default for Piecewise {
    fn default() -> Self {
        Piecewise {
            tolerance: 1e-11,
            closure: Closure::default(),
            pieces: 4,
            most_evaluations: 4_000_000,
        }
    }
}

/// What the piecewise rule finds of an advanced loop.
#[derive(Clone, Debug)]
pub struct PiecewiseIntegral {
    /// I_ac: the absolutely continuous part, what the paper's rules aim at.
    pub continuous: LoopIntegral,
    /// The part of its quadrature error that stands for breaks which may be elsewhere: where the loop only
    /// grazes what breaks it, rounding moves the breaks along s. The closed integral has none of it.
    pub place_error: f64,
    /// Contribution of the closing segments in each degree of freedom.
    pub closing: Vec<f64>,
    /// Every break, by its s.
    pub breaks: Vec<Break>,
    /// Pieces that the loop was cut into.
    pub pieces: usize,
    /// Stretches of s that could not be resolved; their error is in `quadrature_error`.
    pub unresolved: Vec<(f64, f64)>,
    /// States advanced, whole step or rest of one.
    pub evaluations: usize,
}

impl PiecewiseIntegral {
    /// The integral of the loop with its breaks closed.
    pub fn closed(&self) -> LoopIntegral {
        let mut closed = self.continuous.clone();
        let mut value = CompensatedSum::default();
        for (sum, closing) in closed.contributions.iter_mut().zip(&self.closing) {
            *sum += closing;
            value.add(*sum);
        }
        closed.value = value.total();
        closed.quadrature_error =
            (closed.quadrature_error).map(|error| (error - self.place_error).max(0.0));
        closed
    }

    /// States that the pieces are made of.
    pub fn nodes(&self) -> usize {
        self.pieces * lobatto::NODES
    }
}

impl Piecewise {
    /// The same without a limit of evaluations: for the loop before the step, which costs none.
    fn unlimited(&self) -> Self {
        Piecewise {
            most_evaluations: Piecewise::default().most_evaluations,
            ..*self
        }
    }

    /// Integrates the loop that `map` makes of `phase_loop` in one step of size `h`.
    ///
    /// On the threads of the current Rayon pool; the result does not depend on their number.
    ///
    /// # Errors
    /// If map and loop differ in their degrees of freedom, the tolerance is not positive, the map
    /// fails or returns states that are not finite, or the integral overflows.
    pub fn integrate(
        &self,
        map: &dyn TimeAdvance,
        phase_loop: &dyn Loop,
        h: f64,
    ) -> Result<PiecewiseIntegral, Error> {
        let count = EvaluationCount::unlimited();
        self.integrate_beside(&Evaluator::new(map, &count)?, phase_loop, h, None)
    }

    /// The same with what is `seen` besides: equispaced samples of the advanced loop. Every piece has to
    /// agree with them, so that nothing as wide as their distance is missed.
    pub(crate) fn integrate_beside(
        &self,
        evaluator: &Evaluator<'_>,
        phase_loop: &dyn Loop,
        h: f64,
        seen: Option<&Ensemble>,
    ) -> Result<PiecewiseIntegral, Error> {
        self.check(evaluator, phase_loop)?;
        let coordinates = evaluator.coordinates();
        let curves = Curves {
            evaluator,
            h,
            phase_loop,
            segments: Vec::new(),
        };
        let sketch = evaluator.image(phase_loop, h, &sketch_points())?;
        let scales = Scales::new(&sketch, coordinates, self.tolerance);
        let edges = self.first_edges(&evaluator.known_breaks(phase_loop, h));
        let pieces = edges.windows(2).map(|ends| Piece::new(0, ends[0], ends[1]));
        let pieces: Vec<Piece> = pieces.collect();
        let mut queue = Queue::new(curves, coordinates, scales, self.most_evaluations, seen);
        queue.evaluations += SKETCH;
        queue.begin(SKETCH + pieces.len() * POINTS);
        queue.run(0, pieces)?;
        look_for_twins(&mut queue)?;
        let chords = close(&mut queue, self.closure)?;
        let place_error = doubt_of_places(&mut queue)?;
        collect(&queue, &chords, place_error)
    }

    /// Where the first pieces end: a few of one length, cut round the breaks that are known.
    fn first_edges(&self, known: &[f64]) -> Vec<f64> {
        let count = self.pieces.max(1);
        let uniform = (0..=count).map(|k| k as f64 / count as f64);
        let around = (known.iter().filter(|s| s.is_finite()))
            .flat_map(|s| [s - AROUND, s + AROUND])
            .filter(|edge| (AROUND..1.0 - AROUND).contains(edge));
        let mut edges: Vec<f64> = uniform.chain(around).collect();
        edges.sort_by(f64::total_cmp);
        edges.dedup();
        edges
    }

    fn check(&self, evaluator: &Evaluator<'_>, phase_loop: &dyn Loop) -> Result<(), Error> {
        evaluator.check_dof(phase_loop.dof())?;
        if !(self.tolerance.is_finite() && self.tolerance > 0.0) {
            return Err(Error::OutOfRange {
                what: "tolerance of the piecewise rule",
                value: self.tolerance,
                remedy: "give a positive number such as 1e-11",
            });
        }
        Ok(())
    }
}

/// A known break lies in a first piece that reaches this far to both sides of it: much further than the
/// rounding of where it is, and not at all on the scale of the loop.
const AROUND: f64 = 1e-10;

/// Parameters no further apart than this are a few doubles apart.
const NEIGHBOURS: f64 = 4.0 * f64::EPSILON;

/// Samples from which the sizes of the coordinates are learned.
const SKETCH: usize = 12;

/// Where they are: at multiples of the golden section, so that no loop runs round between all of them, and
/// in order, as positions are unwrapped.
fn sketch_points() -> [f64; SKETCH] {
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    let mut points = std::array::from_fn(|k| (GOLDEN * k as f64).fract());
    points.sort_by(f64::total_cmp);
    points
}

/// Adds up pieces and chords, in the order of the loop.
///
/// Momenta are counted from a reference, p = p_ref + …: what p_ref contributes is known exactly, as
/// the positions return but for the breaks and whole periods.
fn collect(
    queue: &Queue<'_>,
    chords: &[Chord],
    place_error: f64,
) -> Result<PiecewiseIntegral, Error> {
    let coordinates = queue.coordinates;
    let dof = coordinates.dof();
    let mut smooth: Vec<&Smooth> = queue.smooth.iter().collect();
    smooth
        .sort_by(|x, y| (x.piece.curve.cmp(&y.piece.curve)).then(x.piece.a.total_cmp(&y.piece.a)));
    let mut areas = vec![CompensatedSum::default(); dof];
    let mut closing = vec![CompensatedSum::default(); dof];
    let mut gains = vec![CompensatedSum::default(); dof];
    let mut closing_gains = vec![CompensatedSum::default(); dof];
    let (mut error, mut exposure, mut scale) = (doubt_of_chance(queue), 0.0, 0.0);
    for piece in &smooth {
        let of_loop = piece.piece.curve == 0;
        for i in 0..dof {
            let (areas, gains) = if of_loop {
                (&mut areas, &mut gains)
            } else {
                (&mut closing, &mut closing_gains)
            };
            areas[i].add(piece.areas[i]);
            gains[i].add(piece.gains[i]);
        }
        error += piece.error;
        exposure += piece.exposure;
        scale += piece.areas.iter().map(|area| area.abs()).sum::<f64>();
    }
    for chord in chords {
        for i in 0..dof {
            closing[i].add(chord.areas[i]);
            closing_gains[i].add(chord.gains[i]);
        }
    }
    let mut contributions = Vec::with_capacity(dof);
    let mut of_closing = Vec::with_capacity(dof);
    let mut total = CompensatedSum::default();
    for i in 0..dof {
        let of_loop = queue.breaks.iter().filter(|found| found.curve == 0);
        let jumps: f64 = of_loop.map(|found| found.jumps[i]).sum();
        let around = gains[i].total() + jumps;
        let winding = around - nearest(around, coordinates.period(i));
        let reference = coordinates.weight(i) * queue.scales.p_reference[i];
        let contribution = areas[i].total() + reference * (winding - jumps);
        // Each jump is a difference of two rounded positions.
        let rounded = UNIT_ROUNDOFF * queue.breaks.len() as f64 * queue.largest_position(i);
        exposure += (reference * rounded / UNIT_ROUNDOFF).abs();
        contributions.push(contribution);
        // The closed curve may wind otherwise: a segment opens by whole periods where a jump, of which only
        // the ends are known, seems to be less.
        let closed = gains[i].total() + closing_gains[i].total();
        let closed_winding = closed - nearest(closed, coordinates.period(i));
        of_closing.push(closing[i].total() + reference * (closed_winding - winding + jumps));
        total.add(contribution);
    }
    let value = total.total();
    if !(value.is_finite() && (error + place_error).is_finite() && scale.is_finite()) {
        let dof = contributions.iter().position(|c| !c.is_finite());
        return Err(Error::Overflow {
            dof: dof.unwrap_or(0),
            value: value + error + scale,
        });
    }
    let mut unresolved: Vec<(f64, f64)> = (smooth.iter())
        .filter(|piece| piece.piece.curve == 0 && !piece.resolved)
        .map(|piece| (piece.piece.a, piece.piece.b))
        .collect();
    unresolved.dedup();
    let mut breaks: Vec<Break> = (queue.breaks.iter())
        .filter(|found| found.curve == 0)
        .map(|found| found.summary)
        .collect();
    breaks.sort_by(|a, b| a.s.total_cmp(&b.s));
    // A force that has a value of its own where it jumps breaks the loop twice round one double.
    breaks.dedup_by(|next, found| {
        let one = next.dof == found.dof && next.s - found.s < NEIGHBOURS;
        if one {
            found.jump_q += next.jump_q;
            found.jump_p += next.jump_p;
        }
        one
    });
    Ok(PiecewiseIntegral {
        continuous: LoopIntegral {
            value,
            contributions,
            quadrature_error: Some(error + place_error),
            roundoff: 4.0 * UNIT_ROUNDOFF * (exposure + scale),
            scale,
            omitted: None,
            regularity: None,
        },
        place_error,
        closing: of_closing,
        breaks,
        pieces: smooth.iter().filter(|p| p.piece.curve == 0).count(),
        unresolved,
        evaluations: queue.evaluations,
    })
}
