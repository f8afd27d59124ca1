//! Pieces and brackets at work, in batches.

use rayon::prelude::*;

use super::bracket::{Bracket, Closed, SURROUNDINGS};
use super::curves::{At, Curves, Images, coordinate};
use super::fit::POINTS;
use super::piece::{Finding, Piece, Smooth, View};
use super::scales::{Scales, nearest, period};
use crate::breaks::Break;
use crate::coordinates::Coordinates;
use crate::ensemble::Ensemble;
use crate::error::Error;

/// Everything that is known of the curves so far.
pub(super) struct Queue<'a> {
    pub curves: Curves<'a>,
    pub coordinates: &'a Coordinates,
    pub scales: Scales,
    /// Pieces that are done.
    pub smooth: Vec<Smooth>,
    /// Breaks of all curves.
    pub breaks: Vec<Found>,
    pub evaluations: usize,
    most_evaluations: usize,
    /// Equispaced samples of the advanced loop that are known besides.
    seen: Option<&'a Ensemble>,
}

/// A break of a curve.
pub(super) struct Found {
    pub curve: usize,
    /// The last parameter before it and the first after it.
    pub sides: [f64; 2],
    /// How far each coordinate of the loop jumps, positions first; empty for closing segments.
    pub jumps: Vec<f64>,
    pub summary: Break,
}

/// One thing to do.
enum Task {
    Piece(Piece),
    Bracket(Box<Bracket>),
    /// A jump that no double lies in: is it more than the noise on both sides of it?
    Confirm(Box<Bracket>),
    /// A piece that looks smooth, but for the turning points of its positions.
    Turns(Box<Smooth>),
}

/// What came of it.
enum Outcome {
    Done(Box<Smooth>),
    More(Vec<Task>),
    /// A stretch that nothing explains and that is very short: noise, perhaps.
    Noisy(Vec<Task>),
    /// The map has this much noise in each coordinate.
    Noise {
        noise: Vec<f64>,
        more: Vec<Task>,
    },
    Broken {
        curve: usize,
        sides: [f64; 2],
        more: Vec<Task>,
    },
}

/// Unexplained stretches shorter than this make one look for noise.
const NOISE_LENGTH: f64 = 1e-3;

/// A break is this many times the noise beside it, and what the slope makes of its width.
const STANDS_OUT: f64 = 8.0;

/// A jump of this part of the loop's size is no noise of doubles. Its surroundings may well hold another
/// break.
const NO_NOISE: f64 = 1e-6;

/// States of one batch take this much memory at most, all substeps together.
const BATCH_BYTES: usize = 64 << 20;

impl Task {
    /// Parameters of the states it asks for.
    fn points(&self) -> Vec<f64> {
        match self {
            Task::Piece(piece) => piece.points().collect(),
            Task::Bracket(bracket) => vec![bracket.middle()],
            Task::Confirm(bracket) => bracket.surroundings().into(),
            Task::Turns(smooth) => {
                let turns = smooth.turns.iter();
                turns.map(|(x, _)| smooth.piece.s(*x)).collect()
            }
        }
    }

    fn curve(&self) -> usize {
        match self {
            Task::Piece(piece) => piece.curve,
            Task::Bracket(bracket) | Task::Confirm(bracket) => bracket.piece.curve,
            Task::Turns(smooth) => smooth.piece.curve,
        }
    }
}

impl<'a> Queue<'a> {
    pub fn new(
        curves: Curves<'a>,
        coordinates: &'a Coordinates,
        scales: Scales,
        most_evaluations: usize,
        seen: Option<&'a Ensemble>,
    ) -> Self {
        Queue {
            curves,
            coordinates,
            scales,
            smooth: Vec::new(),
            breaks: Vec::new(),
            evaluations: 0,
            most_evaluations,
            seen,
        }
    }

    /// Largest |q_i| that was met, to judge rounding by.
    pub fn largest_position(&self, i: usize) -> f64 {
        self.scales.magnitude[i]
    }

    /// Resolves `pieces` of curves that meet `substep` first.
    pub fn run(&mut self, substep: usize, pieces: Vec<Piece>) -> Result<(), Error> {
        let mut tasks: Vec<Task> = pieces.into_iter().map(Task::Piece).collect();
        while !tasks.is_empty() {
            let mut next = Vec::new();
            while !tasks.is_empty() {
                let others = tasks.split_off(self.batch(&tasks, substep));
                next.extend(self.turn(tasks, substep)?);
                tasks = others;
            }
            tasks = next;
        }
        Ok(())
    }

    /// How many tasks go into one batch.
    fn batch(&self, tasks: &[Task], substep: usize) -> usize {
        let copies = self.curves.map.substeps() - substep + 1;
        let state = 16 * self.curves.dof() * copies;
        let most = (BATCH_BYTES / state).max(1);
        let mut states = 0;
        let fitting = tasks.iter().take_while(|task| {
            states += match task {
                Task::Piece(_) => POINTS,
                Task::Bracket(_) => 1,
                Task::Confirm(_) => SURROUNDINGS,
                Task::Turns(smooth) => smooth.turns.len(),
            };
            states <= most
        });
        fitting.count().max(1)
    }

    /// Evaluates what a batch asks for, and sees what comes of it.
    fn turn(&mut self, batch: Vec<Task>, substep: usize) -> Result<Vec<Task>, Error> {
        let mut points = Vec::new();
        let mut firsts = Vec::with_capacity(batch.len());
        for task in &batch {
            firsts.push(points.len());
            let curve = task.curve();
            points.extend(task.points().into_iter().map(|s| At { curve, s }));
        }
        self.evaluations += points.len();
        let last = self.evaluations >= self.most_evaluations;
        let keep = batch.iter().any(|task| matches!(task, Task::Piece(_)));
        let images = self.curves.images(&points, substep, keep)?;
        let outcomes: Vec<Outcome> = (batch.into_par_iter().zip(firsts))
            .map(|(task, first)| self.proceed(task, &images, first, last))
            .collect();
        let mut next = Vec::new();
        let mut noisy = false;
        for outcome in outcomes {
            match outcome {
                Outcome::Done(smooth) => self.smooth.push(*smooth),
                Outcome::More(more) => next.extend(more),
                Outcome::Noisy(more) => {
                    noisy = true;
                    next.extend(more);
                }
                Outcome::Noise { noise, more } => {
                    self.scales.allow(&noise);
                    next.extend(more);
                }
                Outcome::Broken { curve, sides, more } => {
                    self.breaks.push(Found {
                        curve,
                        sides,
                        jumps: Vec::new(),
                        summary: Break {
                            s: sides[1],
                            dof: 0,
                            jump_q: 0.0,
                            jump_p: 0.0,
                            substep: None,
                        },
                    });
                    next.extend(more);
                }
            }
        }
        if noisy {
            self.evaluations += self.scales.learn_noise(&self.curves)?;
        }
        Ok(next)
    }

    fn proceed(&self, task: Task, images: &Images, first: usize, last: bool) -> Outcome {
        match task {
            Task::Piece(piece) => self.look(piece, images, first, last),
            Task::Bracket(mut bracket) => {
                let value = bracket.project(&images.after, first, self.coordinates);
                let piece = bracket.piece;
                if last {
                    return Outcome::More(vec![Task::Piece(piece)]);
                }
                match bracket.halve(value) {
                    Closed::No => Outcome::More(vec![Task::Bracket(bracket)]),
                    Closed::Jump => Outcome::More(vec![Task::Confirm(bracket)]),
                    // A kink close to an end, or a steep place: closer up it will show.
                    Closed::Faded => Outcome::More(cut(piece, &bracket.gap)),
                }
            }
            Task::Confirm(bracket) => self.confirm(&bracket, images, first),
            Task::Turns(smooth) => self.check_turns(smooth, images, first, last),
        }
    }

    /// Takes a jump for a break if it stands out of the noise on both sides.
    fn confirm(&self, bracket: &Bracket, images: &Images, first: usize) -> Outcome {
        let Piece { curve, a, b } = bracket.piece;
        // Each side from its own end of the bracket, so that a wrap in between is none of it.
        let (low, high) = (first + SURROUNDINGS / 2 - 1, first + SURROUNDINGS / 2);
        let between = |sample: usize, origin: usize| {
            bracket.project_from(&images.after, sample, origin, self.coordinates)
        };
        let projected: Vec<f64> = (first..=low)
            .map(|sample| between(sample, low))
            .chain((high..first + SURROUNDINGS).map(|sample| between(sample, high)))
            .collect();
        let jump = between(high, low).abs();
        let beside = Bracket::scatter(&projected).max(bracket.climb(&projected));
        let size = (0..2 * self.curves.dof()).fold(0.0, |most: f64, c| {
            let row = coordinate(&images.after, c);
            let apart = nearest(row[high] - row[low], period(self.coordinates, c));
            most.max((self.scales.weight(c) * apart).abs())
        });
        if size > NO_NOISE || jump > STANDS_OUT * beside {
            let piece = |a: f64, b: f64| (b > a).then_some(Task::Piece(Piece { curve, a, b }));
            return Outcome::Broken {
                curve,
                sides: [bracket.low, bracket.high],
                more: (piece(a, bracket.low).into_iter())
                    .chain(piece(bracket.high, b))
                    .collect(),
            };
        }
        if bracket.wraps(jump) {
            return Outcome::More(cut(bracket.piece, &bracket.gap));
        }
        let noise = (0..2 * self.curves.dof()).map(|c| {
            let row = &coordinate(&images.after, c)[first..first + SURROUNDINGS];
            let period = period(self.coordinates, c);
            let values: Vec<f64> = row.iter().map(|v| nearest(v - row[0], period)).collect();
            Bracket::scatter(&values)
        });
        Outcome::Noise {
            noise: noise.collect(),
            more: vec![Task::Piece(bracket.piece)],
        }
    }

    fn look(&self, piece: Piece, images: &Images, first: usize, last: bool) -> Outcome {
        let view = View {
            piece,
            images,
            first,
            scales: &self.scales,
            coordinates: self.coordinates,
            seen: self.seen,
        };
        match view.examine(last) {
            Finding::Smooth(smooth) if smooth.turns.is_empty() || last => {
                Outcome::Done(Box::new(smooth))
            }
            Finding::Smooth(smooth) => Outcome::More(vec![Task::Turns(Box::new(smooth))]),
            Finding::Jumps(bracket) => Outcome::More(vec![Task::Bracket(Box::new(bracket))]),
            Finding::Cut { at, explained } => {
                let halves = cut(piece, &at);
                if !explained && piece.length() < NOISE_LENGTH {
                    Outcome::Noisy(halves)
                } else {
                    Outcome::More(halves)
                }
            }
        }
    }

    /// Accepts a piece if its turning points are where the interpolant has them; else cuts it there.
    fn check_turns(
        &self,
        smooth: Box<Smooth>,
        images: &Images,
        first: usize,
        last: bool,
    ) -> Outcome {
        for (k, (x, expected)) in smooth.turns.iter().enumerate() {
            let misses = expected.iter().enumerate().any(|(c, expected)| {
                let value = coordinate(&images.after, c)[first + k];
                let off = nearest(value - expected, period(self.coordinates, c));
                // The tolerance is that of the interpolant's own estimate.
                off.abs() > 2.0 * smooth.allowed[c]
            });
            if misses && !last {
                return Outcome::More(cut(smooth.piece, &[smooth.piece.s(*x)]));
            }
        }
        Outcome::Done(smooth)
    }

    /// Learns from the advanced states on both sides of each of the breaks from `first` on how far
    /// the coordinates jump.
    pub fn measure_breaks(&mut self, first: usize, after: &Ensemble) {
        let dof = self.curves.dof();
        for (k, found) in self.breaks[first..].iter_mut().enumerate() {
            let jump = |c: usize| {
                let row = coordinate(after, c);
                nearest(row[2 * k + 1] - row[2 * k], period(self.coordinates, c))
            };
            let size = |i: usize| {
                let of = |c: usize| (self.scales.weight(c) * jump(c)).abs();
                of(i).max(of(dof + i))
            };
            let most = (0..dof).fold((0, 0.0), |most, i| {
                let size = size(i);
                if size > most.1 { (i, size) } else { most }
            });
            found.summary.dof = most.0;
            found.summary.jump_q = jump(most.0);
            found.summary.jump_p = jump(dof + most.0);
            if found.curve == 0 {
                found.summary.s = found.sides[1].rem_euclid(1.0);
                found.jumps = (0..2 * dof).map(jump).collect();
            }
        }
    }
}

/// A piece cut at rising parameters: in the middle if they are not inside.
fn cut(piece: Piece, at: &[f64]) -> Vec<Task> {
    let Piece { curve, a, b } = piece;
    let mut edges = vec![a];
    edges.extend(at.iter().copied().filter(|&s| s > a && s < b));
    if edges.len() == 1 {
        edges.push(0.5 * (a + b));
    }
    edges.push(b);
    edges.dedup();
    (edges.windows(2))
        .map(|ends| {
            Task::Piece(Piece {
                curve,
                a: ends[0],
                b: ends[1],
            })
        })
        .collect()
}
