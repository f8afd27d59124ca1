//! Tasks for a stretch of a curve, and their costs.

use super::curves::CurvePoint;
use super::examine::TurningPoints;
use super::jump::Jump;
use super::noise;
use super::piece::{Piece, SmoothPiece};
use super::refinement::CurveBreak;

/// States of a closing segment whose ends are known, if it is straight: inner nodes and checks.
const EVALUATIONS_OF_SEGMENT: usize = 4;

/// States that tell how well the position of a break is known.
const EVALUATIONS_OF_POSITION: usize = 2;

/// The cost of a break after it was found.
pub(super) const EVALUATIONS_OF_BREAK: usize = EVALUATIONS_OF_SEGMENT + EVALUATIONS_OF_POSITION;

/// One thing to do.
pub(super) enum Task {
    /// Look at a piece.
    Look(Box<Piece>),
    /// Halve the bracket of a jump.
    Halve(Box<Jump>),
    /// Tell a jump that no double lies in from the noise on both sides of it.
    Confirm(Box<Jump>),
    /// Compare a piece that looks smooth with its states at turning points of positions.
    CheckTurningPoints(Box<Piece>, Box<SmoothPiece>, TurningPoints),
    /// Estimate the noise of a very short stretch that nothing explains.
    EstimateNoise(Box<Piece>),
}

/// What came of it.
#[derive(Default)]
pub(super) struct Outcome {
    /// What to do next.
    pub next: Vec<Task>,
    pub found: Option<CurveBreak>,
    /// Whether the map may have noise.
    pub noisy: bool,
    /// The evaluations granted that are not needed.
    pub refund: usize,
    /// The piece unchanged: it is done if there is nothing to do next, or no means to.
    pub piece: Option<FinishedPiece>,
}

/// A piece as it is.
pub(super) enum FinishedPiece {
    /// Integrated already.
    Smooth(SmoothPiece),
    /// Not resolved: it is integrated if nothing else can be done about it.
    Piece(Box<Piece>),
}

impl Task {
    /// Adds the states it asks for.
    pub fn ask(&self, points: &mut Vec<CurvePoint>) {
        match self {
            Task::Look(piece) => points.extend(piece.missing_points()),
            Task::Halve(jump) => {
                points.push(CurvePoint::on(jump.piece.curve, jump.bracket.middle()));
            }
            Task::Confirm(jump) => points.extend(jump.surroundings()),
            Task::CheckTurningPoints(piece, _, turning) => {
                let expected = turning.expected.iter();
                points.extend(expected.map(|&(s, _)| CurvePoint::on(piece.curve, s)));
            }
            Task::EstimateNoise(piece) => {
                points.extend(noise::points(piece.curve, [piece.a, piece.b]));
            }
        }
    }

    /// How many states it asks for.
    pub fn cost(&self) -> usize {
        match self {
            Task::Look(piece) => piece.missing().count(),
            Task::Halve(_) => 1,
            Task::Confirm(jump) => jump.missing(),
            Task::CheckTurningPoints(_, _, turning) => turning.expected.len(),
            Task::EstimateNoise(_) => noise::STATES,
        }
    }

    /// How many states have to be granted for it: for a jump all that it may come to, so that none is
    /// closed in on in vain.
    pub fn price(&self) -> usize {
        match self {
            Task::Halve(jump) if jump.bracket.halvings() == 0 => jump.price,
            Task::Halve(_) => 0,
            Task::Confirm(jump) => jump.extra(),
            other => other.cost(),
        }
    }
}

impl Outcome {
    pub fn done(smooth: SmoothPiece) -> Self {
        Outcome::then(Vec::new(), FinishedPiece::Smooth(smooth))
    }

    pub fn then(next: Vec<Task>, piece: FinishedPiece) -> Self {
        Outcome {
            next,
            piece: Some(piece),
            ..Outcome::default()
        }
    }

    /// To look at the parts of an unresolved piece.
    pub fn cut(piece: Box<Piece>, at: &[f64]) -> Self {
        Outcome::then(looks(piece.cut(at)), FinishedPiece::Piece(piece))
    }
}

pub(super) fn looks(pieces: Vec<Piece>) -> Vec<Task> {
    let boxed = pieces.into_iter().map(Box::new);
    boxed.map(Task::Look).collect()
}
