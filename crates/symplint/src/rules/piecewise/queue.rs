//! Pieces and brackets at work, in batches.

use rayon::prelude::*;

use super::bracket::{Bracket, Closed};
use super::curves::{At, Curves, Images};
use super::fit::POINTS;
use super::noise;
use super::piece::{Finding, Piece, Smooth, View, Why};
use super::scales::{Scales, period};
use super::task::{MOST_NEXT, OF_A_BREAK, Outcome, Task, cut};
use crate::breaks::Break;
use crate::error::Error;
use crate::signal::nearest;
use crate::state::Coordinates;
use crate::state::Ensemble;
use crate::state::coordinate;

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
    /// Evaluations that were granted, made or not; no more than may be made, but for the first ones.
    granted: usize,
    most_evaluations: usize,
    /// What has to wait until others give back what was granted to them.
    waiting: Vec<Outcome>,
    noise_known: bool,
    /// Equispaced samples of the advanced loop that are known besides.
    pub seen: Option<&'a Ensemble>,
}

/// A break of a curve.
pub(super) struct Found {
    pub curve: usize,
    /// The last parameter before it and the first after it.
    pub sides: [f64; 2],
    /// How far each coordinate of the loop jumps, positions first; empty for closing segments.
    pub jumps: Vec<f64>,
    /// ∫ (p − p_ref) dq along the straight chord between the sides, for each degree of freedom; empty for
    /// closing segments.
    pub areas: Vec<f64>,
    pub summary: Break,
}

/// Unexplained stretches shorter than this make one listen for noise.
const NOISE_LENGTH: f64 = 1e-3;

/// A break is this many times the noise beside it, and what the slope makes of its width.
const STANDS_OUT: f64 = 8.0;

/// A jump of this part of the loop's size is no noise of doubles. Its surroundings may well hold another
/// break.
const NO_NOISE: f64 = 1e-6;

/// States of one batch take this much memory at most, all substeps together.
const BATCH_BYTES: usize = 64 << 20;

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
            granted: 0,
            most_evaluations,
            waiting: Vec::new(),
            noise_known: false,
            seen,
        }
    }

    /// Largest |q_i| that was met, to judge rounding by.
    pub fn largest_position(&self, i: usize) -> f64 {
        self.scales.magnitude[i]
    }

    /// Counts evaluations that are made whatever may be made.
    pub fn begin(&mut self, evaluations: usize) {
        self.granted += evaluations;
    }

    /// Grants so many evaluations, if they may be made.
    pub fn grant(&mut self, evaluations: usize) -> bool {
        let granted = self.granted + evaluations;
        let within = granted <= self.most_evaluations;
        if within {
            self.granted = granted;
        }
        within
    }

    /// Resolves `pieces` of curves that meet `substep` first. The first look at them has been granted.
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
            if tasks.is_empty() {
                tasks = self.wake();
            }
        }
        Ok(())
    }

    /// How many tasks go into one batch.
    fn batch(&self, tasks: &[Task], substep: usize) -> usize {
        let copies = self.curves.evaluator.substeps() - substep + 1;
        let state = 16 * self.curves.dof() * copies;
        let most = (BATCH_BYTES / state).max(1);
        let mut states = 0;
        let fitting = tasks.iter().take_while(|task| {
            states += task.cost();
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
            points.extend(task.points());
        }
        let small = |task: &Task| matches!(task, Task::Confirm(bracket) if bracket.expected.sqrt() < NO_NOISE);
        if batch.iter().any(small) {
            self.learn_noise()?;
        }
        self.evaluations += points.len();
        let tight = self.granted + MOST_NEXT * batch.len() > self.most_evaluations;
        let keep = batch.iter().any(|task| matches!(task, Task::Piece(_)));
        let images = self.curves.images(&points, substep, keep)?;
        let outcomes: Vec<Outcome> = (batch.into_par_iter().zip(firsts))
            .map(|(task, first)| self.proceed(task, &images, first, tight))
            .collect();
        let mut next = Vec::new();
        let mut noisy = false;
        for outcome in outcomes {
            noisy |= outcome.noisy;
            self.decide(outcome, &mut next);
        }
        if noisy {
            self.learn_noise()?;
        }
        Ok(next)
    }

    /// Goes on with what comes next, if it may; else it has to wait for what others give back.
    fn decide(&mut self, outcome: Outcome, next: &mut Vec<Task>) {
        self.granted -= outcome.refund;
        if outcome.next.is_empty() && outcome.broken.is_none() {
            self.smooth.extend(outcome.as_it_is.map(|smooth| *smooth));
        } else if self.admit(&outcome) {
            self.start(outcome, next);
        } else {
            self.waiting.push(outcome);
        }
    }

    /// Grants what comes next, if it may be made.
    fn admit(&mut self, outcome: &Outcome) -> bool {
        let segment = if self.curves.evaluator.substeps() > 1 {
            POINTS
        } else {
            0
        };
        let of_break = outcome.broken.map_or(0, |_| OF_A_BREAK + segment);
        self.grant(of_break + outcome.next.iter().map(Task::price).sum::<usize>())
    }

    fn start(&mut self, outcome: Outcome, next: &mut Vec<Task>) {
        next.extend(outcome.next);
        self.breaks
            .extend(outcome.broken.map(|(curve, sides)| Found {
                curve,
                sides,
                jumps: Vec::new(),
                areas: Vec::new(),
                summary: Break {
                    s: sides[1],
                    dof: 0,
                    jump_q: 0.0,
                    jump_p: 0.0,
                    substep: None,
                },
            }));
    }

    /// What waits and may go on now. If nothing may, nothing will: the pieces are taken as they are.
    fn wake(&mut self) -> Vec<Task> {
        let mut next = Vec::new();
        for outcome in std::mem::take(&mut self.waiting) {
            if self.admit(&outcome) {
                self.start(outcome, &mut next);
            } else {
                self.waiting.push(outcome);
            }
        }
        if next.is_empty() {
            let waiting = std::mem::take(&mut self.waiting).into_iter();
            let as_they_are = waiting.filter_map(Outcome::into_piece);
            self.smooth
                .extend(as_they_are.map(|smooth| *smooth.unresolved()));
        }
        next
    }

    /// Raises the tolerances to the noise that the map has all along the loop, once.
    fn learn_noise(&mut self) -> Result<(), Error> {
        if !self.noise_known && self.grant(noise::LISTENING) {
            self.noise_known = true;
            let points: Vec<At> = noise::points(&Piece::new(0, 0.0, 1.0)).collect();
            self.evaluations += points.len();
            let after = self.curves.images(&points, 0, false)?.after;
            let noise = noise::of_states(&after, 0, self.coordinates);
            self.scales.allow(&Scales::allowance(noise));
        }
        Ok(())
    }

    fn proceed(&self, task: Task, images: &Images, first: usize, tight: bool) -> Outcome {
        match task {
            Task::Piece(piece) => self.look(piece, images, first, tight),
            Task::Bracket(mut bracket) => {
                let value = bracket.project(&images.after, first, self.coordinates);
                match bracket.halve(value) {
                    Closed::No => Outcome::then(vec![Task::Bracket(bracket)], None),
                    Closed::Jump => Outcome::then(vec![Task::Confirm(bracket)], None),
                    // A kink close to an end, or a steep place: closer up it will show.
                    Closed::Faded => {
                        let pieces = cut(&bracket.piece, &bracket.gap);
                        Outcome::then(pieces, Some(bracket.as_it_is)).of_bracket(bracket.turns, 0)
                    }
                }
            }
            Task::Confirm(bracket) => self.confirm(*bracket, images, first),
            Task::Turns(smooth) => self.check_turns(smooth, images, first),
            Task::Listen(smooth) => self.listen(smooth, images, first),
        }
    }

    /// Takes a jump for a break if it stands out of the noise on both sides.
    fn confirm(&self, mut bracket: Bracket, images: &Images, first: usize) -> Outcome {
        // Each side from its own end of the bracket, so that a wrap in between is none of it.
        let (end, high) = (first + bracket.looks(), first + bracket.looks() / 2);
        let low = high - 1;
        let between = |sample: usize, origin: usize| {
            bracket.project_from(&images.after, sample, origin, self.coordinates)
        };
        let projected: Vec<f64> = (first..=low)
            .map(|sample| between(sample, low))
            .chain((high..end).map(|sample| between(sample, high)))
            .collect();
        let jump = between(high, low).abs();
        let beside = Bracket::scatter(&projected).max(bracket.climb(&projected));
        let apart = |c: usize| {
            let row = coordinate(&images.after, c);
            nearest(row[high] - row[low], period(self.coordinates, c)).abs()
        };
        let all = 0..2 * self.curves.dof();
        let large = (all.clone()).any(|c| self.scales.weight(c) * apart(c) > NO_NOISE);
        // The steps of a grid are jumps with nothing beside them, and noise all the same.
        let mut no_step = all.filter(|&c| apart(c) > bracket.piece.allowance(c, &self.scales));
        let looks = 1 + usize::from(bracket.again);
        if large || (jump > STANDS_OUT * beside && no_step.next().is_some()) {
            let Piece { curve, a, b, .. } = bracket.piece;
            let sides = [bracket.low, bracket.high];
            let pieces = [[a, sides[0]], [sides[1], b]].into_iter();
            return Outcome {
                next: (pieces.filter(|[a, b]| b > a))
                    .map(|[a, b]| Task::Piece(bracket.piece.part(a, b)))
                    .collect(),
                broken: Some((curve, sides)),
                as_it_is: Some(bracket.as_it_is),
                ..Outcome::default()
            }
            .of_bracket(bracket.turns, looks);
        }
        let wraps = bracket.wraps(jump);
        if !wraps && !bracket.again {
            bracket.again = true;
            return Outcome::then(vec![Task::Confirm(Box::new(bracket))], None);
        }
        let mut pieces = cut(&bracket.piece, &bracket.gap);
        if !wraps {
            let noise = (0..2 * self.curves.dof()).map(|c| {
                let row = &coordinate(&images.after, c)[first..end];
                let period = period(self.coordinates, c);
                let values: Vec<f64> = row.iter().map(|v| nearest(v - row[0], period)).collect();
                Bracket::scatter(&values)
            });
            let allowance = Scales::allowance(noise.collect());
            for task in &mut pieces {
                if let Task::Piece(piece) = task
                    && piece.lies_in(&bracket.gap)
                {
                    piece.noise = Some(allowance.clone());
                }
            }
        }
        Outcome {
            noisy: !wraps,
            ..Outcome::then(pieces, Some(bracket.as_it_is))
        }
        .of_bracket(bracket.turns, looks)
    }

    fn look(&self, piece: Piece, images: &Images, first: usize, tight: bool) -> Outcome {
        let view = View {
            piece: piece.clone(),
            images,
            first,
            scales: &self.scales,
            coordinates: self.coordinates,
            seen: self.seen,
        };
        match view.examine(tight) {
            Finding::Smooth(smooth) if smooth.turns.is_empty() => Outcome::done(Box::new(smooth)),
            Finding::Smooth(smooth) => Outcome::then(vec![Task::Turns(Box::new(smooth))], None),
            Finding::Jumps(bracket) => Outcome::then(vec![Task::Bracket(Box::new(bracket))], None),
            Finding::Cut { at, why, as_it_is } => {
                let noisy = why != Why::Explained && piece.length() < NOISE_LENGTH;
                let listens = noisy && self.noise_known && why == Why::Unexplained;
                match as_it_is {
                    Some(smooth) if listens => Outcome::then(vec![Task::Listen(smooth)], None),
                    as_it_is => Outcome {
                        noisy,
                        ..Outcome::then(cut(&piece, &at), as_it_is)
                    },
                }
            }
        }
    }

    /// Looks at a piece once more if the noise that it has explains it; else cuts it.
    fn listen(&self, smooth: Box<Smooth>, images: &Images, first: usize) -> Outcome {
        let noise = noise::of_states(&images.after, first, self.coordinates);
        let allowance = Scales::allowance(noise);
        let allowed = allowance.iter().zip(&self.scales.tolerance);
        let explained = (smooth.off.iter().zip(allowed))
            .all(|(off, (noise, tolerance))| *off <= noise.max(*tolerance));
        let next = if explained {
            let mut piece = smooth.piece.clone();
            piece.noise = Some(allowance);
            vec![Task::Piece(piece)]
        } else {
            cut(&smooth.piece, &[])
        };
        Outcome::then(next, Some(smooth))
    }

    /// Accepts a piece if its turning points are where the interpolant has them; else cuts it there.
    fn check_turns(&self, smooth: Box<Smooth>, images: &Images, first: usize) -> Outcome {
        for (k, (x, expected)) in smooth.turns.iter().enumerate() {
            let misses = expected.iter().enumerate().any(|(c, expected)| {
                let value = coordinate(&images.after, c)[first + k];
                let off = nearest(value - expected, period(self.coordinates, c));
                // The tolerance is that of the interpolant's own estimate.
                off.abs() > 2.0 * smooth.allowed[c]
            });
            if misses {
                let pieces = cut(&smooth.piece, &[smooth.piece.s(*x)]);
                return Outcome::then(pieces, Some(smooth));
            }
        }
        Outcome::done(smooth)
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
