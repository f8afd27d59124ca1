//! A stretch of a curve, and what its samples say of it.

use std::sync::Arc;

use super::bracket::Bracket;
use super::curves::Images;
use super::fit::{CHECKS, Fit, POINTS, turn};
use super::lobatto::{
    DEGREE, LOBATTO, NODES, SMOOTH, TERMS, Values, evaluate, polynomial, tail_squared,
};
use super::scales::{Scales, period};
use crate::signal::nearest;
use crate::signal::unwrap_row;
use crate::state::Coordinates;
use crate::state::Ensemble;
use crate::state::coordinate;

/// A stretch [a, b] of a curve.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub curve: usize,
    pub a: f64,
    pub b: f64,
    /// What each coordinate may be off because of the noise that the map has here, and not everywhere.
    pub noise: Option<Arc<[f64]>>,
}

/// A stretch this short is a straight line.
pub(super) const SHORTEST: f64 = 1e-11;

/// Part of the highest coefficients, squared, that one break has to explain.
const EXPLAINS: f64 = 0.95;

/// Explanations that are this good, relative to the best, are as good.
const AS_GOOD: f64 = 0.999;

/// Coefficients that fall by this factor, squared, along the tail belong to a smooth function: those of a
/// jump of the third derivative fall by 16 in amplitude from the 6th to the 12th.
const DECAYS: f64 = 1e-3;

/// A break whose size vanishes somewhere in its gap, to this part squared, is a kink there.
const VANISHES: f64 = 0.02;

/// A jump is this many times what rounding and tolerance allow for.
const NOISES: f64 = 4.0;

/// A jump is the range of an unresolved piece and what the coordinate moves back besides.
const AND_MOTION: f64 = 1.1;

/// Turning points looked at in one piece at most.
const MOST_TURNS: usize = 64;

/// What a piece turned out to be.
pub(super) enum Finding {
    /// Smooth: its part of the integral, if the states at `turns` agree.
    Smooth(Smooth),
    /// It jumps in this bracket.
    Jumps(Bracket),
    /// It has a kink between two parameters, or is too long: cut it there.
    Cut {
        at: Vec<f64>,
        why: Why,
        /// The piece as it is, if asked for.
        as_it_is: Option<Box<Smooth>>,
    },
}

/// Why a piece is cut.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Why {
    /// A kink, or a sample that it missed.
    Explained,
    /// It is too long for a smooth function.
    Steep,
    /// Nothing explains its highest coefficients.
    Unexplained,
}

/// A piece that is done, or may be taken as it is.
pub(super) struct Smooth {
    pub piece: Piece,
    /// ∫ (p − p_ref) dq of each degree of freedom.
    pub areas: Vec<f64>,
    /// q(b) − q(a) of each.
    pub gains: Vec<f64>,
    /// Largest |q| and |p − p_ref| times the motion of the other, summed: what rounding acts on.
    pub exposure: f64,
    /// Bound on the error by interpolation.
    pub error: f64,
    /// That bound if the piece hides a jump.
    pub error_of_jump: f64,
    /// What the interpolant of each coordinate may be off.
    pub off: Vec<f64>,
    /// Points where positions turn round, and what each coordinate should be there.
    pub turns: Vec<(f64, Vec<f64>)>,
    /// What each coordinate may be off there; empty without such points.
    pub allowed: Vec<f64>,
    /// Whether it is as good as wanted.
    pub resolved: bool,
}

impl Smooth {
    /// Owns up to not being resolved.
    pub fn unresolved(mut self: Box<Self>) -> Box<Self> {
        self.resolved = false;
        self.error = self.error_of_jump;
        self
    }
}

impl Piece {
    /// The whole of a curve, or a part of it.
    pub fn new(curve: usize, a: f64, b: f64) -> Self {
        Piece {
            curve,
            a,
            b,
            noise: None,
        }
    }

    /// A part of it: what is known of its noise holds there, too.
    pub fn part(&self, a: f64, b: f64) -> Self {
        Piece {
            a,
            b,
            ..self.clone()
        }
    }

    /// What a coordinate may be off: the tolerance, or what the noise here makes of it.
    pub fn allowance(&self, c: usize, scales: &Scales) -> f64 {
        let noise = self.noise.as_ref().map_or(0.0, |noise| noise[c]);
        scales.tolerance[c].max(noise)
    }

    /// Whether it lies within a stretch.
    pub fn lies_in(&self, [a, b]: &[f64; 2]) -> bool {
        self.a >= *a && self.b <= *b
    }

    pub fn length(&self) -> f64 {
        self.b - self.a
    }

    /// Parameter at x in [−1, 1]; the ends are met exactly.
    pub fn s(&self, x: f64) -> f64 {
        if x <= -1.0 {
            self.a
        } else if x >= 1.0 {
            self.b
        } else {
            self.a + 0.5 * (1.0 + x) * self.length()
        }
    }

    pub fn x(&self, s: f64) -> f64 {
        2.0 * (s - self.a) / self.length() - 1.0
    }

    /// The parameters to evaluate: nodes, then checks.
    pub fn points(&self) -> impl Iterator<Item = f64> + '_ {
        LOBATTO.nodes.iter().chain(&CHECKS).map(|&x| self.s(x))
    }
}

/// The samples of one piece in a batch.
pub(super) struct View<'a> {
    pub piece: Piece,
    pub images: &'a Images,
    /// Its first sample.
    pub first: usize,
    pub scales: &'a Scales,
    pub coordinates: &'a Coordinates,
    /// Equispaced samples of the advanced loop that are known besides.
    pub seen: Option<&'a Ensemble>,
}

impl View<'_> {
    fn dof(&self) -> usize {
        self.coordinates.dof()
    }

    fn values(&self, states: &Ensemble, c: usize) -> [f64; POINTS] {
        let row = &coordinate(states, c)[self.first..self.first + POINTS];
        let mut values: [f64; POINTS] = row.try_into().expect("a piece has so many points");
        let period = period(self.coordinates, c);
        if period > 0.0 {
            let (nodes, checks) = values.split_at_mut(NODES);
            unwrap_row(nodes, period);
            // A check lies between two nodes.
            for (check, x) in checks.iter_mut().zip(CHECKS) {
                let after = LOBATTO.nodes.iter().position(|&node| node > x);
                let near = nodes[after.unwrap_or(DEGREE)];
                *check += period * ((near - *check) / period).round();
            }
        }
        values
    }

    /// Looks at the piece; `tight` if it may have to be taken as it is.
    pub fn examine(&self, tight: bool) -> Finding {
        let dof = self.dof();
        let short = self.piece.length() < SHORTEST;
        let mut fits: Vec<Fit> = Vec::with_capacity(2 * dof);
        let mut resolved = true;
        for c in 0..2 * dof {
            let fit = Fit::of(&self.values(&self.images.after, c), short);
            resolved &= fit.off <= self.allowed(c, &fit);
            fits.push(fit);
        }
        let missed = if resolved { self.missed(&fits) } else { None };
        if short {
            return Finding::Smooth(self.smooth(&fits, resolved && missed.is_none()));
        }
        match missed {
            Some(at) => self.cut(&fits, vec![at], Why::Explained, tight),
            None if resolved => Finding::Smooth(self.smooth(&fits, resolved)),
            None => self.seek_break(&fits, tight),
        }
    }

    /// The parameter of a seen sample on the piece that is not where the interpolants have it.
    fn missed(&self, fits: &[Fit]) -> Option<f64> {
        let seen = self.seen.filter(|_| self.piece.curve == 0)?;
        let samples = seen.samples() as f64;
        let first = (self.piece.a * samples).ceil().max(0.0) as usize;
        let last = (self.piece.b * samples).floor().min(samples - 1.0) as usize;
        let inside = |&s: &f64| s > self.piece.a && s < self.piece.b;
        (first..=last)
            .map(|k| (k, k as f64 / samples))
            .filter(|(_, s)| inside(s))
            .find(|&(k, s)| {
                fits.iter().enumerate().any(|(c, fit)| {
                    let expected = evaluate(&fit.coefficients, self.piece.x(s));
                    let off = coordinate(seen, c)[k] - expected;
                    let off = nearest(off, period(self.coordinates, c));
                    // The tolerance is that of the interpolant's own estimate.
                    off.abs() > 2.0 * self.allowed(c, fit)
                })
            })
            .map(|(_, s)| s)
    }

    fn cut(&self, fits: &[Fit], at: Vec<f64>, why: Why, tight: bool) -> Finding {
        let wanted = tight || why == Why::Unexplained;
        Finding::Cut {
            at,
            why,
            as_it_is: wanted.then(|| Box::new(self.smooth(fits, false))),
        }
    }

    /// What an interpolant may be off: the tolerance, and what the rounding of the state that the map got
    /// becomes where the loop is steep.
    fn allowed(&self, c: usize, fit: &Fit) -> f64 {
        let rounded = self.scales.input_rounding * fit.range() / self.piece.length();
        self.piece.allowance(c, self.scales) + rounded
    }

    fn smooth(&self, fits: &[Fit], resolved: bool) -> Smooth {
        let dof = self.dof();
        let short = self.piece.length() < SHORTEST;
        let mut smooth = Smooth {
            piece: self.piece.clone(),
            areas: Vec::with_capacity(dof),
            gains: Vec::with_capacity(dof),
            exposure: 0.0,
            error: 0.0,
            error_of_jump: 0.0,
            off: fits.iter().map(|fit| fit.off).collect(),
            turns: Vec::new(),
            allowed: Vec::new(),
            resolved,
        };
        for i in 0..dof {
            let (q, p) = (&fits[i], &fits[dof + i]);
            let weight = self.coordinates.weight(i);
            let reference = self.scales.p_reference[i];
            let from_start = q.values.map(|v| v - q.values[0]);
            let from_reference = p.values.map(|v| v - reference);
            smooth
                .areas
                .push(weight * LOBATTO.area(&from_reference, &from_start));
            smooth.gains.push(q.values[DEGREE] - q.values[0]);
            let largest = |values: &Values| values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            smooth.error += weight.abs() * (q.off * p.range() + p.off * q.range());
            // Any part of it may be a jump, which is missing where the reference is accounted for; of a straight
            // line, no more than its points are off.
            let jump = if short {
                q.off.min(q.range())
            } else {
                q.range()
            };
            let anywhere = p.range() + largest(&from_reference) + reference.abs();
            smooth.error_of_jump += weight.abs() * AND_MOTION * jump * anywhere;
            smooth.exposure +=
                weight.abs() * (largest(&q.values) * p.range() + largest(&p.values) * q.range());
        }
        // So short a piece may be as steep as rounding allows, and that is as steep as a jump.
        if !resolved || short {
            smooth.error = smooth.error_of_jump;
        }
        if resolved && !short {
            let allowed = fits.iter().enumerate().map(|(c, fit)| self.allowed(c, fit));
            smooth.allowed = allowed.collect();
            smooth.turns = (self.turning_points().into_iter())
                .map(|x| {
                    (
                        x,
                        fits.iter()
                            .map(|fit| evaluate(&fit.coefficients, x))
                            .collect(),
                    )
                })
                .collect();
        }
        smooth
    }

    /// Where a position turns round, at the beginning of any substep or at the end: a particle that
    /// only grazes a place where the force jumps does so there, between two nodes.
    fn turning_points(&self) -> Vec<f64> {
        let mut turns = Vec::new();
        let Images { after, inputs } = self.images;
        for i in 0..self.dof() {
            for states in inputs.iter().chain([after]) {
                turns.extend(turn(&Fit::of(&self.values(states, i), false)));
            }
            // A step that is one whole evaluates its force somewhere in between.
            if let [before] = &inputs[..] {
                let (a, b) = (self.values(before, i), self.values(after, i));
                turns.extend(turn(&Fit::of(
                    &std::array::from_fn(|k| 0.5 * (a[k] + b[k])),
                    false,
                )));
            }
        }
        turns.sort_by(f64::total_cmp);
        turns.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        let every = turns.len().div_ceil(MOST_TURNS).max(1);
        turns.into_iter().step_by(every).collect()
    }

    /// The gap between two nodes in which one break explains the coefficients best.
    fn seek_break(&self, fits: &[Fit], tight: bool) -> Finding {
        let mut explained = [0.0; DEGREE];
        let mut all = 0.0;
        for (c, fit) in fits.iter().enumerate() {
            let weight = self.scales.weight(c).powi(2);
            all += weight * tail_squared(&fit.coefficients);
            for (sum, gap) in explained.iter_mut().zip(&LOBATTO.gaps) {
                *sum += weight * gap.explained(&fit.coefficients);
            }
        }
        let most = explained.iter().copied().fold(0.0, f64::max);
        let in_the_middle = || vec![self.piece.s(0.0)];
        if self.decays(fits) {
            return self.cut(fits, in_the_middle(), Why::Steep, tight);
        }
        if most < EXPLAINS * all {
            return self.cut(fits, in_the_middle(), Why::Unexplained, tight);
        }
        // Three terms next to an end can say what one at the end itself says.
        let best = (0..DEGREE)
            .filter(|&i| explained[i] >= AS_GOOD * most)
            .min_by_key(|&i| LOBATTO.gaps[i].terms())
            .expect("the largest is one of them");
        let gap = &LOBATTO.gaps[best];
        let jumps: Vec<[f64; TERMS]> = (fits.iter())
            .map(|fit| gap.jump(&fit.coefficients))
            .collect();
        let (low, high) = (LOBATTO.nodes[best], LOBATTO.nodes[best + 1]);
        if let Some(ends) = self.kink(&jumps, [low, high], (all - most).max(0.0)) {
            let at = ends.map(|x| self.piece.s(x)).into();
            return self.cut(fits, at, Why::Explained, tight);
        }
        let middle = 0.5 * (low + high);
        let direction: Vec<f64> = (jumps.iter().enumerate())
            .map(|(c, jump)| self.scales.weight(c).powi(2) * polynomial(jump, middle))
            .collect();
        let mut left = [0.0; SMOOTH];
        let mut jump = [0.0; TERMS];
        let mut projected = [0.0; 2];
        let mut expected = 0.0;
        let mut noise = 0.0;
        let reference: Vec<f64> = fits.iter().map(|fit| fit.values[best]).collect();
        for (c, fit) in fits.iter().enumerate() {
            let part = gap.left(&fit.coefficients, &jumps[c]);
            for (sum, a) in left.iter_mut().zip(part) {
                *sum += direction[c] * a;
            }
            left[0] -= direction[c] * reference[c];
            for (sum, d) in jump.iter_mut().zip(jumps[c]) {
                *sum += direction[c] * d;
            }
            for (sum, k) in projected.iter_mut().zip([best, best + 1]) {
                *sum += direction[c] * (fit.values[k] - reference[c]);
            }
            expected += direction[c] * polynomial(&jumps[c], middle);
            noise += (direction[c] * self.allowed(c, fit)).powi(2);
        }
        // What rounding alone may be: no jump to close in on.
        if expected < NOISES * noise.sqrt() {
            return self.cut(fits, in_the_middle(), Why::Unexplained, tight);
        }
        Finding::Jumps(Bracket {
            piece: self.piece.clone(),
            gap: [low, high].map(|x| self.piece.s(x)),
            low: self.piece.s(low),
            high: self.piece.s(high),
            direction,
            reference,
            left,
            jump,
            projected,
            expected,
            turns: 0,
            again: false,
            as_it_is: Box::new(self.smooth(fits, false)),
        })
    }

    /// Whether the tails fall as those of smooth functions do.
    fn decays(&self, fits: &[Fit]) -> bool {
        let (mut early, mut late) = (0.0, 0.0);
        for (c, fit) in fits.iter().enumerate() {
            let weight = self.scales.weight(c).powi(2);
            let square = |range: std::ops::Range<usize>| {
                let part = &fit.coefficients[range];
                weight * part.iter().map(|a| a * a).sum::<f64>()
            };
            early += square(SMOOTH..SMOOTH + 3);
            late += square(DEGREE - 2..DEGREE + 1);
        }
        late < DECAYS * early
    }

    /// Between which points the jump of all coordinates vanishes, if it does: as closely as what is
    /// left `unexplained` lets it be known.
    fn kink(
        &self,
        jumps: &[[f64; TERMS]],
        [low, high]: [f64; 2],
        unexplained: f64,
    ) -> Option<[f64; 2]> {
        const PLACES: usize = 64;
        const SAFETY: f64 = 16.0;
        let square = |x: f64| {
            let terms = jumps.iter().enumerate();
            terms
                .map(|(c, jump)| (self.scales.weight(c) * polynomial(jump, x)).powi(2))
                .sum::<f64>()
        };
        let places = (0..=PLACES).map(|k| low + (high - low) * k as f64 / PLACES as f64);
        let (mut at, mut least, mut most) = (low, f64::INFINITY, 0.0f64);
        for x in places {
            let size = square(x);
            most = most.max(size);
            if size < least {
                (at, least) = (x, size);
            }
        }
        if least >= VANISHES * most {
            return None;
        }
        // Next to the end of the gap: what is wider than one place is not known to be smooth.
        let enough = SAFETY * unexplained.max(least);
        let edge = |mut inside: f64, mut outside: f64| {
            if square(outside) <= enough {
                return outside;
            }
            for _ in 0..30 {
                let middle = 0.5 * (inside + outside);
                if square(middle) <= enough {
                    inside = middle;
                } else {
                    outside = middle;
                }
            }
            outside
        };
        Some([edge(at, low), edge(at, high)])
    }
}
