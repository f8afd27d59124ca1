//! The examination of a piece by its states.

use std::f64::consts::TAU;
use std::sync::Arc;

use multiversion::multiversion;
use nalgebra::DMatrix;

use super::fit::{PieceFit, ends_of_tail, fit, fit_all, turning_point};
use super::jump::Jump;
use super::limits::{
    FIRST_SMALL, FULL_LEVEL, KINK_SAFETY, MARGIN_OF_NOISE, MARGIN_OF_RANGE,
    MAX_DISTANCE_OF_SAME_TURNING_POINT, MAX_SIZE_AT_KINK, MAX_TAIL_RATIO, MAX_TERMS,
    MAX_TURNING_POINTS, MIN_EXPLAINED_PART, MIN_JUMP_OVER_ROUNDING, MIN_PART_OF_BEST,
    ROUNDING_OF_OPERATIONS,
};
use super::lobatto::{
    DEGREE, LOBATTO, POINTS, Values, evaluate, explained, largest, polynomial, tail_squared,
};
use super::piece::{Piece, SmoothPiece};
use super::samples::{missed, missed_sample};
use super::scales::Scales;
use super::stage_states::{StageStates, Tile, tiles};
use crate::state::{Coordinates, Ensemble};

/// The kind of a piece.
pub(super) enum PieceKind {
    /// Its interpolants are as good as wanted, if the states at turning points of positions agree.
    Smooth(TurningPoints),
    /// They are not, and it is too short to be cut.
    TooShort,
    /// It jumps in this bracket.
    Jump(Box<Jump>),
    /// It has a kink between two parameters, or is too long: cut it there, or in the middle.
    Cut { at: Vec<f64>, why: CutReason },
}

/// Why a piece is cut.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum CutReason {
    /// A kink, or a sample that it missed.
    Explained,
    /// It is too long for a smooth function.
    Steep,
    /// Nothing explains its highest coefficients.
    Unexplained,
}

/// Turning points of positions on a piece: there a particle may graze a threshold at which the force jumps, between
/// two nodes. Without them, the loops of ECSIM with shapes of degree 1 are not closed (docs/census.md).
#[derive(Default)]
pub(super) struct TurningPoints {
    /// Each with what the coordinates should be there.
    pub expected: Vec<(f64, Vec<f64>)>,
    /// How far off they may be.
    pub allowed: Vec<f64>,
}

/// A piece, and what it is measured by.
pub(super) struct View<'a> {
    pub piece: &'a Piece,
    pub scales: &'a Scales,
    pub coordinates: &'a Coordinates,
    /// Equispaced samples of the advanced loop, if there are any.
    pub samples: Option<&'a Ensemble>,
    /// The interpolants of all coordinates after the step, if they were made.
    pub fits: Vec<PieceFit>,
}

/// What one degree of freedom of a piece adds to the integral.
struct PartOfDof {
    /// ∫ (p − p_ref) dq.
    area: f64,
    /// The largest |q|, |p| and |p − p_ref|.
    largest_q: f64,
    largest_p: f64,
    largest_from_reference: f64,
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn part_of_dof(q: &Values, p: &Values, reference: f64) -> PartOfDof {
    let from_start = q.map(|value| value - q[0]);
    let from_reference = p.map(|value| value - reference);
    PartOfDof {
        area: LOBATTO.area(&from_reference, &from_start),
        largest_q: largest(q),
        largest_p: largest(p),
        largest_from_reference: largest(&from_reference),
    }
}

impl<'a> View<'a> {
    pub fn new(
        piece: &'a Piece,
        scales: &'a Scales,
        coordinates: &'a Coordinates,
        samples: Option<&'a Ensemble>,
    ) -> Self {
        View {
            piece,
            scales,
            coordinates,
            samples,
            fits: Vec::new(),
        }
    }

    /// With the interpolants of all coordinates.
    pub fn fitted(mut self) -> Self {
        let last = self.last_stage();
        let mut tile = Tile::default();
        for coordinates in tiles(0..2 * self.dof()) {
            last.read(coordinates.clone(), &mut tile);
            self.fit_all(&tile[..coordinates.len()]);
        }
        self
    }

    /// Looks at the piece with all its fits. `None` if interpolants below the full degree are not as good as wanted: those of a higher
    /// degree may be.
    pub fn look(mut self) -> Option<(Self, PieceKind)> {
        let (dof, last) = (self.dof(), self.last_stage());
        let mut are_good = true;
        let mut tile = Tile::default();
        // What a force does is seen in momenta first.
        for coordinates in tiles(dof..2 * dof).chain(tiles(0..dof)) {
            last.read(coordinates.clone(), &mut tile);
            let before = self.fits.len();
            self.fit_all(&tile[..coordinates.len()]);
            let mut fits = coordinates.zip(&self.fits[before..]);
            are_good &= fits.all(|(c, fit)| fit.off <= self.allowed(c, fit));
            if !are_good && self.piece.level < FULL_LEVEL {
                return None;
            }
        }
        self.fits.rotate_left(dof);
        let finding = self.examine(are_good)?;
        Some((self, finding))
    }

    pub fn dof(&self) -> usize {
        self.coordinates.dof()
    }

    pub fn fit(&self, values: &[f64; POINTS]) -> PieceFit {
        match self.piece.is_short() {
            true => PieceFit::straight(values),
            false => fit(values, self.piece.level),
        }
    }

    /// Adds the fits of a tile.
    fn fit_all(&mut self, tile: &[[f64; POINTS]]) {
        let missing = (2 * self.dof()).saturating_sub(self.fits.len());
        self.fits.reserve_exact(missing);
        match self.piece.is_short() {
            true => self.fits.extend(tile.iter().map(PieceFit::straight)),
            false => fit_all(tile, self.piece.level, &mut self.fits),
        }
    }

    /// The states of a stage.
    pub fn stage(&self, stage: usize) -> StageStates<'a> {
        StageStates::new(self.piece, self.coordinates, stage)
    }

    fn last_stage(&self) -> StageStates<'a> {
        self.stage(self.piece.image(0).stages() - 1)
    }

    /// The kind of the piece; `None` if a sample is not on an interpolant below the full degree.
    fn examine(&self, are_good: bool) -> Option<PieceKind> {
        let missed = if are_good { missed_sample(self) } else { None };
        if are_good && missed.is_none() {
            return Some(PieceKind::Smooth(self.turning_points()));
        }
        if self.piece.level < FULL_LEVEL {
            return None;
        }
        if self.piece.is_short() {
            return Some(PieceKind::TooShort);
        }
        let at = match missed {
            Some(at) => vec![at],
            None => self.around_crossings(),
        };
        Some(match at.is_empty() {
            true => self.seek_break(),
            false => PieceKind::Cut {
                at,
                why: CutReason::Explained,
            },
        })
    }

    /// What an interpolant may be off: the tolerance, and what the rounding of the state that the map got
    /// becomes where the loop is steep. A straight line may be off by the change that a kink makes of its length.
    pub fn allowed(&self, c: usize, fit: &PieceFit) -> f64 {
        let length = self.piece.length();
        let rounded = self.scales.input_rounding * fit.range / length;
        let kinked = match self.piece.is_short() {
            true => TAU * self.scales.size[c] * length,
            false => 0.0,
        };
        self.piece.allowance(c, self.scales) + rounded + kinked
    }

    /// Whether the interpolants are good enough if so much noise is allowed for.
    pub fn is_explained_by(&self, noise: &[f64]) -> bool {
        let allowed = |c: usize| noise[c].max(self.piece.allowance(c, self.scales));
        (self.fits.iter().enumerate()).all(|(c, fit)| fit.off <= allowed(c))
    }

    /// Its part of the integral.
    pub fn integrate(&self, resolved: bool) -> SmoothPiece {
        let dof = self.dof();
        let short = self.piece.is_short();
        let mut smooth = SmoothPiece {
            curve: self.piece.curve,
            a: self.piece.a,
            b: self.piece.b,
            areas: Vec::with_capacity(dof),
            gains: Vec::with_capacity(dof),
            exposure: 0.0,
            error: 0.0,
            missed: None,
            error_of_jump: 0.0,
            error_of_noise: 0.0,
            resolved,
        };
        for i in 0..dof {
            let (q, p) = (&self.fits[i], &self.fits[dof + i]);
            let weight = self.coordinates.weight(i);
            let reference = self.scales.p_reference[i];
            let of_dof = part_of_dof(&q.values, &p.values, reference);
            smooth.areas.push(weight * of_dof.area);
            smooth.gains.push(q.values[DEGREE] - q.values[0]);
            // The noise may be a jump, as large as states scatter.
            let scatter = |noise: &Arc<[f64]>| noise[i] / MARGIN_OF_NOISE;
            let scatter = self.piece.noise.as_ref().map_or(0.0, scatter);
            // Any part of it may be a jump, which is missing where the reference is accounted for; of a straight
            // line, no more than its points are off.
            let jump = if short { q.off.min(q.range) } else { q.range };
            let anywhere = p.range + of_dof.largest_from_reference + reference.abs();
            smooth.error_of_jump += weight.abs() * MARGIN_OF_RANGE * jump * anywhere;
            smooth.error += weight.abs() * (q.error * p.range + p.error * q.range);
            smooth.error_of_noise += weight.abs() * scatter.min(q.range) * anywhere;
            smooth.exposure +=
                weight.abs() * (of_dof.largest_q * p.range + of_dof.largest_p * q.range);
        }
        // So short a piece may be as steep as rounding allows, and that is as steep as a jump.
        match !resolved || short {
            true => smooth.error = smooth.error_of_jump,
            false => smooth.missed = missed(self),
        }
        smooth
    }

    /// Turning points of a position at the beginning of any substep or at the end.
    fn turning_points(&self) -> TurningPoints {
        if self.piece.is_short() {
            return TurningPoints::default();
        }
        let last = self.piece.image(0).stages() - 1;
        let stages: Vec<StageStates<'_>> = (0..last).map(|k| self.stage(k)).collect();
        let after = self.stage(last);
        let mut before = vec![Tile::default(); last];
        let mut points = Vec::new();
        for positions in tiles(0..self.dof()) {
            for (tile, stage) in before.iter_mut().zip(&stages) {
                stage.read(positions.clone(), tile);
            }
            for (k, i) in positions.enumerate() {
                // What rests has none, but for rounding.
                let moves =
                    |fit: &PieceFit| fit.range > ROUNDING_OF_OPERATIONS * self.scales.magnitude[i];
                let turns = |values: &Values| LOBATTO.turns(values, self.piece.level);
                let mut add = |fit: &PieceFit| {
                    if moves(fit) {
                        points.extend(turning_point(fit));
                    }
                };
                for before in before.iter().map(|tile| &tile[k]) {
                    let nodes: &Values = before.first_chunk().expect("nodes come first");
                    if turns(nodes) {
                        add(&self.fit(before));
                    }
                    // A step that is one whole evaluates its force somewhere in between.
                    let between = |k: usize| 0.5 * (nodes[k] + self.fits[i].values[k]);
                    if stages.len() == 1 && turns(&std::array::from_fn(between)) {
                        let after = after.values(i);
                        let middle = std::array::from_fn(|k| 0.5 * (before[k] + after[k]));
                        add(&self.fit(&middle));
                    }
                }
                if turns(&self.fits[i].values) {
                    add(&self.fits[i]);
                }
            }
        }
        points.sort_by(f64::total_cmp);
        points.dedup_by(|a, b| (*a - *b).abs() < MAX_DISTANCE_OF_SAME_TURNING_POINT);
        let every = points.len().div_ceil(MAX_TURNING_POINTS).max(1);
        let fits = || self.fits.iter();
        let expected = points.into_iter().step_by(every).map(|x| {
            let values = fits().map(|fit| evaluate(&fit.coefficients, x));
            (self.piece.s(x), values.collect())
        });
        TurningPoints {
            expected: expected.collect(),
            allowed: (fits().enumerate())
                .map(|(c, fit)| self.allowed(c, fit))
                .collect(),
        }
    }

    /// The gap between two nodes in which one break explains the coefficients best.
    fn seek_break(&self) -> PieceKind {
        let in_the_middle = |why: CutReason| PieceKind::Cut {
            at: Vec::new(),
            why,
        };
        let weighted = || {
            let fits = self.fits.iter().enumerate();
            fits.map(|(c, fit)| (self.scales.weight(c).powi(2), &fit.coefficients))
        };
        let explained = explained(&mut weighted());
        let all = weighted().map(|(weight, of)| weight * tail_squared(of));
        let all: f64 = all.sum();
        let most = explained.iter().copied().fold(0.0, f64::max);
        if self.decays() {
            return in_the_middle(CutReason::Steep);
        }
        let best = (0..DEGREE)
            .filter(|&i| explained[i] >= MIN_PART_OF_BEST * most)
            .min_by_key(|&i| LOBATTO.gaps[i].terms());
        // Sums that overflow explain nothing, either.
        let Some(best) = best.filter(|_| most >= MIN_EXPLAINED_PART * all) else {
            return in_the_middle(CutReason::Unexplained);
        };
        let steps: Vec<[f64; MAX_TERMS]> = (self.fits.iter())
            .map(|fit| LOBATTO.gaps[best].jump(&fit.coefficients))
            .collect();
        if let Some(ends) = self.kink(best, &steps, (all - most).max(0.0)) {
            return PieceKind::Cut {
                at: ends.map(|x| self.piece.s(x)).into(),
                why: CutReason::Explained,
            };
        }
        match self.jump(best, &steps) {
            Some(jump) => PieceKind::Jump(Box::new(jump)),
            None => in_the_middle(CutReason::Unexplained),
        }
    }

    /// The jump by `steps` in a gap, unless rounding alone may be one of its size.
    fn jump(&self, best: usize, steps: &[[f64; MAX_TERMS]]) -> Option<Jump> {
        let gap = &LOBATTO.gaps[best];
        let (low, high) = (LOBATTO.nodes[best], LOBATTO.nodes[best + 1]);
        let middle = 0.5 * (low + high);
        let direction: Vec<f64> = (steps.iter().enumerate())
            .map(|(c, step)| self.scales.weight(c).powi(2) * polynomial(step, middle))
            .collect();
        let mut left = [0.0; FIRST_SMALL];
        let mut step = [0.0; MAX_TERMS];
        let mut expected = 0.0;
        let mut noise = 0.0;
        let reference: Vec<f64> = self.fits.iter().map(|fit| fit.values[best]).collect();
        for (c, fit) in self.fits.iter().enumerate() {
            let part = gap.left(&fit.coefficients, &steps[c]);
            for (sum, a) in left.iter_mut().zip(part) {
                *sum += direction[c] * a;
            }
            left[0] -= direction[c] * reference[c];
            for (sum, d) in step.iter_mut().zip(steps[c]) {
                *sum += direction[c] * d;
            }
            expected += direction[c] * polynomial(&steps[c], middle);
            noise += (direction[c] * self.allowed(c, fit)).powi(2);
        }
        if expected < MIN_JUMP_OVER_ROUNDING * noise.sqrt() {
            return None;
        }
        let ends = [best, best + 1].map(|k| self.piece.image(k).clone());
        let gap = [low, high].map(|x| self.piece.s(x));
        Some(Jump::new(
            self.piece.clone(),
            gap,
            ends,
            (direction, reference),
            (left, step),
            expected,
        ))
    }

    /// Whether the tails fall as for smooth functions.
    fn decays(&self) -> bool {
        let (mut early, mut late) = (0.0, 0.0);
        for (c, fit) in self.fits.iter().enumerate() {
            let weight = self.scales.weight(c).powi(2);
            let [first, last] = ends_of_tail(&fit.coefficients);
            early += weight * first;
            late += weight * last;
        }
        late < MAX_TAIL_RATIO * early
    }

    /// Between which points of a gap the steps of all coordinates vanish, if they do: as closely as what is
    /// left `unexplained` lets it be known.
    fn kink(&self, gap: usize, steps: &[[f64; MAX_TERMS]], unexplained: f64) -> Option<[f64; 2]> {
        const POSITIONS: usize = 64;
        let (low, high) = (LOBATTO.nodes[gap], LOBATTO.nodes[gap + 1]);
        let weighted = |c: usize, term: usize| self.scales.weight(c) * steps[c][term];
        let matrix = DMatrix::from_fn(steps.len(), MAX_TERMS, weighted);
        // A few polynomials whose squares have the same sum as the squares of all coordinates.
        let triangle = matrix.qr().unpack_r();
        let rows = triangle.row_iter();
        let rows: Vec<[f64; MAX_TERMS]> = rows
            .map(|row| std::array::from_fn(|term| row[term]))
            .collect();
        let square = |x: f64| {
            rows.iter()
                .map(|row| polynomial(row, x).powi(2))
                .sum::<f64>()
        };
        let at = |k: usize| low + (high - low) * k as f64 / POSITIONS as f64;
        let squares: Vec<f64> = (0..=POSITIONS).map(|k| square(at(k))).collect();
        let most = squares.iter().copied().fold(0.0, f64::max);
        let by_size = |&a: &usize, &b: &usize| squares[a].total_cmp(&squares[b]);
        let least = (0..=POSITIONS).min_by(by_size)?;
        if squares[least] >= MAX_SIZE_AT_KINK * most {
            return None;
        }
        // Next to the end of the gap: what is wider than one position is not known to be smooth.
        let enough = KINK_SAFETY * unexplained.max(squares[least]);
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
        Some([edge(at(least), low), edge(at(least), high)])
    }
}
