//! Pieces and jumps at work, in batches.

use std::sync::Arc;

use super::curves::{CurvePoint, Curves, PointImage};
use super::examine::{CutReason, PieceKind, TurningPoints, View};
use super::jump::{Judgement, Jump};
use super::limits::{
    MARGIN_BETWEEN_POINTS, MARGIN_OF_NOISE, MAX_JUMP_OF_GRID, MAX_LENGTH_OF_NOISE, MAX_NOISE,
};
use super::lobatto::{DEGREE, POINTS};
use super::noise;
use super::piece::{Piece, SmoothPiece};
use super::scales::Scales;
use super::task::{EVALUATIONS_OF_BREAK, FinishedPiece, Outcome, Task, looks};
use crate::breaks::{Break, Progress, REACH_OF_CONFIRMATION, uncertainty_of_position};
use crate::error::Error;
use crate::signal::nearest;
use crate::state::{Coordinates, Ensemble, SMALL_MEMORY, in_parallel, period};

/// Everything that is known of the curves so far.
pub(super) struct Refinement<'a> {
    pub curves: Curves<'a>,
    pub coordinates: &'a Coordinates,
    pub scales: Scales,
    /// Pieces that are done.
    pub smooth: Vec<SmoothPiece>,
    /// Breaks of all curves.
    pub breaks: Vec<CurveBreak>,
    pub budget: Budget,
    /// Tasks that wait until others give back what was granted to them.
    waiting: Vec<Outcome>,
    noise_known: bool,
    /// Equispaced samples of the advanced loop, if there are any.
    pub samples: Option<&'a Ensemble>,
}

/// Evaluations made and granted.
pub(super) struct Budget {
    pub made: usize,
    /// Made, or promised to somebody who may need them.
    granted: usize,
    most: usize,
}

impl Budget {
    /// A budget of `most` evaluations, of which `made` were made.
    pub fn new(most: usize, made: usize) -> Self {
        Budget {
            made,
            granted: made,
            most,
        }
    }

    /// Grants this number of evaluations, if they may be made.
    pub fn grant(&mut self, evaluations: usize) -> bool {
        let within = evaluations <= self.most - self.granted;
        if within {
            self.granted += evaluations;
        }
        within
    }
}

/// A break of a curve.
pub(super) struct CurveBreak {
    pub curve: usize,
    /// The last parameter before it and the first after it.
    pub sides: [f64; 2],
    /// Their images.
    pub images: [PointImage; 2],
    /// Whether rounding inside the map, and not rounding of the states, decides on which side of the jump neighbouring states are.
    pub flickers: bool,
    /// How far from there it may be along the curve, if that is more than a jump of its size may.
    pub uncertainty: f64,
    /// The substep that breaks the curve, if the step has several.
    pub substep: Option<usize>,
}

impl CurveBreak {
    /// How far a coordinate jumps.
    pub fn jump(&self, c: usize, coordinates: &Coordinates) -> f64 {
        let [low, high] = self.images.each_ref().map(PointImage::after);
        nearest(high[c] - low[c], period(coordinates, c))
    }

    /// The break in the degree of freedom that jumps most, in the sizes of the coordinates; `of_solver` where the loop has
    /// breaks of a solver that stops at a tolerance.
    pub fn summary(&self, scales: &Scales, coordinates: &Coordinates, of_solver: bool) -> Break {
        let dof = coordinates.dof();
        let jump = |c: usize| self.jump(c, coordinates);
        let size = |i: usize| {
            let of = |c: usize| (scales.weight(c) * jump(c)).abs();
            of(i).max(of(dof + i))
        };
        let (most, _) = (0..dof).fold((0, 0.0), |most, i| {
            let size = size(i);
            if size > most.1 { (i, size) } else { most }
        });
        let compared = match of_solver || size(most) < MAX_NOISE {
            true => size(most),
            false => 1.0,
        };
        let rounding = uncertainty_of_position(scales.input_rounding, compared);
        Break {
            s: self.sides[1].rem_euclid(1.0),
            uncertainty: (self.sides[1] - self.sides[0] + rounding).max(self.uncertainty),
            dof: most,
            jump_q: jump(most),
            jump_p: jump(dof + most),
            substep: self.substep,
        }
    }
}

impl<'a> Refinement<'a> {
    pub fn new(
        curves: Curves<'a>,
        coordinates: &'a Coordinates,
        scales: Scales,
        budget: Budget,
        samples: Option<&'a Ensemble>,
    ) -> Self {
        Refinement {
            curves,
            coordinates,
            scales,
            smooth: Vec::new(),
            breaks: Vec::new(),
            budget,
            waiting: Vec::new(),
            noise_known: false,
            samples,
        }
    }

    /// Images of points of curves that meet `substep` first; they were granted.
    pub fn images(
        &mut self,
        points: &[CurvePoint],
        substep: usize,
    ) -> Result<Vec<PointImage>, Error> {
        if points.is_empty() {
            return Ok(Vec::new());
        }
        let (images, evaluations) = self.curves.images(points, substep)?;
        self.budget.made += evaluations;
        Ok(images)
    }

    /// Resolves `pieces` of curves that meet `substep` first. The first look at them has been granted.
    pub fn run(&mut self, substep: usize, pieces: Vec<Piece>) -> Result<(), Error> {
        let mut tasks = looks(pieces);
        while !tasks.is_empty() {
            // Those that came last hold most states.
            let batch = tasks.split_off(tasks.len() - self.batch(&tasks, substep));
            self.advance(batch, substep, &mut tasks)?;
            if tasks.is_empty() {
                self.wake(&mut tasks);
            }
        }
        Ok(())
    }

    /// How many of the last tasks go into one batch.
    fn batch(&self, tasks: &[Task], substep: usize) -> usize {
        // The images of this batch, and as much again for those of earlier ones.
        let copies = 2 * (self.curves.evaluator.substeps() - substep + 1);
        let state = 16 * self.curves.dof() * copies;
        let most = SMALL_MEMORY / state.max(1);
        let mut states = 0;
        let fitting = tasks.iter().rev().take_while(|task| {
            states += task.cost();
            states <= most
        });
        fitting.count().max(1)
    }

    /// Evaluates what a batch asks for, and adds what comes of it to the tasks.
    fn advance(
        &mut self,
        batch: Vec<Task>,
        substep: usize,
        tasks: &mut Vec<Task>,
    ) -> Result<(), Error> {
        let small = |task: &Task| matches!(task, Task::Confirm(jump) if jump.bracket.expected().sqrt() < MAX_JUMP_OF_GRID);
        if batch.iter().any(small) {
            self.learn_noise()?;
        }
        let mut points = Vec::new();
        let ask = |task: &Task| {
            let before = points.len();
            task.ask(&mut points);
            points.len() - before
        };
        let asked: Vec<usize> = batch.iter().map(ask).collect();
        let images = self.images(&points, substep)?;
        // Each point is fitted in all coordinates.
        let numbers = images.len().div_ceil(batch.len().max(1)) * 2 * self.curves.dof() * DEGREE;
        let mut rest = images.into_iter();
        let own = asked
            .iter()
            .map(|asked| rest.by_ref().take(*asked).collect());
        let work: Vec<(Task, Vec<PointImage>)> = batch.into_iter().zip(own).collect();
        let outcomes = in_parallel(work, numbers, |(task, images)| self.proceed(task, images));
        if outcomes.iter().any(|outcome| outcome.noisy) {
            self.learn_noise()?;
        }
        for outcome in outcomes {
            self.budget.granted -= outcome.refund;
            if outcome.next.is_empty() && outcome.found.is_none() {
                let smooth = outcome.piece.map(|piece| self.integrated(piece));
                self.smooth.extend(smooth);
            } else if self.admit(&outcome) {
                self.start(outcome, tasks);
            } else {
                self.waiting.push(outcome);
            }
        }
        Ok(())
    }

    /// Grants what comes next, if it may be made.
    fn admit(&mut self, outcome: &Outcome) -> bool {
        let of_break = outcome.found.as_ref().map_or(0, |_| EVALUATIONS_OF_BREAK);
        let next = outcome.next.iter().map(Task::price).sum::<usize>();
        self.budget.grant(of_break + next)
    }

    fn start(&mut self, outcome: Outcome, tasks: &mut Vec<Task>) {
        self.breaks.extend(outcome.found);
        tasks.extend(outcome.next);
    }

    /// Continues with what waits and may continue now. If nothing may continue, nothing will: the pieces are taken unchanged.
    fn wake(&mut self, tasks: &mut Vec<Task>) {
        for outcome in std::mem::take(&mut self.waiting) {
            if self.admit(&outcome) {
                self.start(outcome, tasks);
            } else {
                self.waiting.push(outcome);
            }
        }
        if tasks.is_empty() {
            let outcomes = std::mem::take(&mut self.waiting).into_iter();
            let pieces = outcomes.filter_map(|outcome| outcome.piece);
            let numbers = 2 * self.curves.dof() * POINTS * DEGREE;
            let unresolved =
                in_parallel(pieces, numbers, |piece| self.integrated(piece).unresolved());
            self.smooth.extend(unresolved);
        }
    }

    /// Advances the ends of one break of the loop once more, if the budget allows it: what the map does at random, or as earlier calls
    /// left it, looks like a break.
    pub fn repeat_ends(&mut self) -> Result<(), Error> {
        let mut of_loop = self.breaks.iter().filter(|found| found.curve == 0);
        let Some(found) = of_loop.find(|found| !found.flickers) else {
            return Ok(());
        };
        let jump = |c: usize| found.jump(c, self.coordinates);
        let size = |c: usize| (self.scales.weight(c) * jump(c)).abs();
        let largest = (0..2 * self.coordinates.dof()).max_by(|&a, &b| size(a).total_cmp(&size(b)));
        let Some((c, jump)) = largest.map(|c| (c, jump(c))) else {
            return Ok(());
        };
        let first = found.images.clone();
        let ends = found.sides.map(|s| CurvePoint::on(0, s));
        if self.curves.evaluator.is_noisy() || !self.budget.grant(ends.len()) {
            return Ok(());
        }
        for (first, again) in first.iter().zip(self.images(&ends, 0)?) {
            let results = [first.after()[c], again.after()[c]];
            self.curves.evaluator.compare(c, results, jump);
        }
        Ok(())
    }

    /// Raises the tolerances to the noise that the map has all along the loop, once.
    fn learn_noise(&mut self) -> Result<(), Error> {
        if !self.noise_known && self.budget.grant(noise::STATES) {
            self.noise_known = true;
            let points: Vec<CurvePoint> = noise::points(0, [0.0, 1.0]).collect();
            let images = self.images(&points, 0)?;
            let found = noise::allowance(&images, self.coordinates);
            for (noise, found) in self.scales.noise.iter_mut().zip(found) {
                *noise = noise.max(found);
            }
        }
        Ok(())
    }

    fn proceed(&self, task: Task, images: Vec<PointImage>) -> Outcome {
        match task {
            Task::Look(mut piece) => {
                piece.fill(images.into_iter());
                self.look(piece)
            }
            Task::Halve(mut jump) => match jump.halve(images[0].clone(), self.coordinates) {
                Progress::Open => self.go_on(Task::Halve(jump)),
                Progress::Jump => self.go_on(Task::Confirm(jump)),
                // A kink close to an end, or a steep stretch: at a smaller scale it will show.
                Progress::Continuous => Outcome {
                    refund: jump.refund(),
                    ..Outcome::cut(Box::new(jump.piece), &jump.gap)
                },
            },
            Task::Confirm(mut jump) => {
                jump.look(&images, self.coordinates);
                self.confirm(jump)
            }
            Task::CheckTurningPoints(piece, smooth, turning) => {
                self.check_turning_points(*piece, *smooth, &turning, &images)
            }
            Task::EstimateNoise(piece) => self.explain_by_noise(piece, &images),
        }
    }

    /// With a task that was paid for.
    fn go_on(&self, task: Task) -> Outcome {
        Outcome {
            next: vec![task],
            ..Outcome::default()
        }
    }

    /// Takes a jump for a break if it stands out of the noise on both sides, and more states confirm it.
    fn confirm(&self, mut jump: Box<Jump>) -> Outcome {
        let judgement = jump.judge(&self.scales, self.coordinates);
        match judgement {
            Judgement::LookAgain => return self.go_on(Task::Confirm(jump)),
            Judgement::Break if jump.wants_confirmation(&self.scales, self.coordinates) => {
                let piece = FinishedPiece::Piece(Box::new(jump.piece.clone()));
                return Outcome::then(vec![Task::Confirm(jump)], piece);
            }
            Judgement::LookAround if jump.look_around() => {
                let piece = FinishedPiece::Piece(Box::new(jump.piece.clone()));
                return Outcome::then(vec![Task::Confirm(jump)], piece);
            }
            _ => {}
        }
        let piece = &jump.piece;
        let mut outcome = Outcome {
            refund: jump.refund(),
            ..Outcome::default()
        };
        let parts = match judgement {
            Judgement::Break => {
                let sides = [jump.bracket.low, jump.bracket.high];
                let images = jump.ends().map(PointImage::clone);
                let [low, high] = images.clone().map(Some);
                let left = piece.part([piece.a, sides[0]], [piece.images[0].clone(), low]);
                let right = piece.part([sides[1], piece.b], [high, piece.images[DEGREE].clone()]);
                outcome.found = Some(CurveBreak {
                    curve: piece.curve,
                    sides,
                    images,
                    // The rounding of a state far from the origin is enough to make it.
                    flickers: jump.flickers() && self.scales.input_rounding < REACH_OF_CONFIRMATION,
                    uncertainty: 0.0,
                    substep: None,
                });
                let parts = [left, right].into_iter();
                parts.filter(|part| part.b > part.a).collect()
            }
            Judgement::Noise | Judgement::LookAgain | Judgement::LookAround => {
                let noise = jump.noise(self.coordinates).into_iter();
                let allowance: Arc<[f64]> = noise.map(|noise| MARGIN_OF_NOISE * noise).collect();
                let mut parts = piece.cut(&jump.gap);
                for part in parts.iter_mut().filter(|part| part.lies_in(&jump.gap)) {
                    part.noise = Some(allowance.clone());
                }
                outcome.noisy = true;
                parts
            }
        };
        outcome.next = looks(parts);
        outcome.piece = Some(FinishedPiece::Piece(Box::new(jump.piece)));
        outcome
    }

    fn view<'b>(&'b self, piece: &'b Piece) -> View<'b> {
        View::new(piece, &self.scales, self.coordinates, self.samples)
    }

    /// A piece about which nothing more is done.
    fn integrated(&self, piece: FinishedPiece) -> SmoothPiece {
        match piece {
            FinishedPiece::Smooth(smooth) => smooth,
            FinishedPiece::Piece(piece) => self.view(&piece).fitted().integrate(false),
        }
    }

    fn look(&self, piece: Box<Piece>) -> Outcome {
        let Some((view, finding)) = self.view(&piece).look() else {
            let mut next = piece.clone();
            next.level += 1;
            return Outcome::then(vec![Task::Look(next)], FinishedPiece::Piece(piece));
        };
        match finding {
            PieceKind::Smooth(turning) => {
                let smooth = view.integrate(true);
                if turning.expected.is_empty() {
                    return Outcome::done(smooth);
                }
                let unchanged = FinishedPiece::Smooth(smooth.clone());
                let task = Task::CheckTurningPoints(piece, Box::new(smooth), turning);
                Outcome::then(vec![task], unchanged)
            }
            PieceKind::TooShort => Outcome::done(view.integrate(false)),
            PieceKind::Jump(jump) => {
                Outcome::then(vec![Task::Halve(jump)], FinishedPiece::Piece(piece))
            }
            PieceKind::Cut { at, why } => {
                let noisy = why != CutReason::Explained && piece.length() < MAX_LENGTH_OF_NOISE;
                if noisy && self.noise_known && why == CutReason::Unexplained {
                    let task = Task::EstimateNoise(piece.clone());
                    return Outcome::then(vec![task], FinishedPiece::Piece(piece));
                }
                Outcome {
                    noisy,
                    ..Outcome::cut(piece, &at)
                }
            }
        }
    }

    /// Looks at a piece once more if the noise that it has explains it; else cuts it.
    fn explain_by_noise(&self, piece: Box<Piece>, images: &[PointImage]) -> Outcome {
        let allowance = noise::allowance(images, self.coordinates);
        if !self.view(&piece).fitted().is_explained_by(&allowance) {
            return Outcome::cut(piece, &[]);
        }
        let mut next = piece.clone();
        next.noise = Some(allowance.into());
        Outcome::then(vec![Task::Look(next)], FinishedPiece::Piece(piece))
    }

    /// Accepts a piece if its turning points are where the interpolant has them; else cuts it there.
    fn check_turning_points(
        &self,
        piece: Piece,
        smooth: SmoothPiece,
        turning: &TurningPoints,
        images: &[PointImage],
    ) -> Outcome {
        for ((s, expected), image) in turning.expected.iter().zip(images) {
            let misses = expected.iter().enumerate().any(|(c, expected)| {
                let value = image.after()[c];
                let off = nearest(value - expected, period(self.coordinates, c));
                off.abs() > MARGIN_BETWEEN_POINTS * turning.allowed[c]
            });
            if misses {
                return Outcome::then(looks(piece.cut(&[*s])), FinishedPiece::Smooth(smooth));
            }
        }
        Outcome::done(smooth)
    }
}
