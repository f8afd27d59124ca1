//! What is to be done about a stretch of a curve, and what it costs.

use super::bracket::{Bracket, SURROUNDINGS};
use super::curves::At;
use super::fit::POINTS;
use super::noise;
use super::piece::{Piece, Smooth};

/// What a break takes besides: its sides and their surroundings.
pub(super) const OF_A_BREAK: usize = 6;

/// What a bracket may come to: to halve it down to the next double, to look round twice, to close a break, and
/// to look at the pieces and at the segment that closes it.
const OF_A_BRACKET: usize =
    MOST_TURNS + SURROUNDINGS[0] + SURROUNDINGS[1] + OF_A_BREAK + 3 * POINTS;

/// A gap is halved that often at most.
const MOST_TURNS: usize = 64;

/// What a task asks for next is no more.
pub(super) const MOST_NEXT: usize = OF_A_BRACKET;

/// One thing to do.
pub(super) enum Task {
    Piece(Piece),
    Bracket(Box<Bracket>),
    /// A jump that no double lies in: is it more than the noise on both sides of it?
    Confirm(Box<Bracket>),
    /// A piece that looks smooth, but for the turning points of its positions.
    Turns(Box<Smooth>),
    /// A very short stretch that nothing explains: noise, perhaps. With what it is as it is.
    Listen(Box<Smooth>),
}

/// What came of it.
#[derive(Default)]
pub(super) struct Outcome {
    /// What to do next.
    pub next: Vec<Task>,
    /// A break, by its curve and its two sides.
    pub broken: Option<(usize, [f64; 2])>,
    /// Whether the map may have noise.
    pub noisy: bool,
    /// What was granted and is not needed.
    pub refund: usize,
    /// The piece as it is: it is done where there is nothing to do next, or no means to.
    pub as_it_is: Option<Box<Smooth>>,
}

impl Task {
    /// The states it asks for.
    pub fn points(&self) -> Vec<At> {
        let curve = self.curve();
        let at = |s: f64| At { curve, s };
        match self {
            Task::Piece(piece) => piece.points().map(at).collect(),
            Task::Bracket(bracket) => vec![at(bracket.middle())],
            Task::Confirm(bracket) => bracket.surroundings().map(at).collect(),
            Task::Turns(smooth) => {
                let turns = smooth.turns.iter();
                turns.map(|(x, _)| at(smooth.piece.s(*x))).collect()
            }
            Task::Listen(smooth) => noise::points(&smooth.piece).collect(),
        }
    }

    /// How many states have to be granted for it: for a bracket all that it may come to, so that none is
    /// closed in on in vain.
    pub fn price(&self) -> usize {
        match self {
            Task::Bracket(bracket) if bracket.turns == 0 => OF_A_BRACKET,
            Task::Bracket(_) | Task::Confirm(_) => 0,
            other => other.cost(),
        }
    }

    /// How many they are.
    pub fn cost(&self) -> usize {
        match self {
            Task::Piece(_) => POINTS,
            Task::Bracket(_) => 1,
            Task::Confirm(bracket) => bracket.looks(),
            Task::Turns(smooth) => smooth.turns.len(),
            Task::Listen(_) => noise::LISTENING,
        }
    }

    /// What is known of its piece so far.
    pub fn into_piece(self) -> Option<Box<Smooth>> {
        match self {
            Task::Piece(_) => None,
            Task::Bracket(bracket) | Task::Confirm(bracket) => Some(bracket.as_it_is),
            Task::Turns(smooth) | Task::Listen(smooth) => Some(smooth),
        }
    }

    fn curve(&self) -> usize {
        match self {
            Task::Piece(piece) => piece.curve,
            Task::Bracket(bracket) | Task::Confirm(bracket) => bracket.piece.curve,
            Task::Turns(smooth) | Task::Listen(smooth) => smooth.piece.curve,
        }
    }
}

impl Outcome {
    /// What came of a bracket that was halved and looked round so often: that is all that it came to.
    pub fn of_bracket(mut self, halved: usize, looks: usize) -> Self {
        let looked = SURROUNDINGS[..looks].iter().sum::<usize>();
        self.refund = OF_A_BRACKET - halved.min(MOST_TURNS) - looked;
        self
    }

    /// The piece that it is about, as far as it is known.
    pub fn into_piece(mut self) -> Option<Box<Smooth>> {
        let of_next = || self.next.pop().and_then(Task::into_piece);
        self.as_it_is.or_else(of_next)
    }

    pub fn done(smooth: Box<Smooth>) -> Self {
        Outcome {
            as_it_is: Some(smooth),
            ..Outcome::default()
        }
    }

    pub fn then(next: Vec<Task>, as_it_is: Option<Box<Smooth>>) -> Self {
        Outcome {
            next,
            as_it_is,
            ..Outcome::default()
        }
    }
}

/// A piece cut at rising parameters: in the middle if they are not inside.
pub(super) fn cut(piece: &Piece, at: &[f64]) -> Vec<Task> {
    let (a, b) = (piece.a, piece.b);
    let mut edges = vec![a];
    edges.extend(at.iter().copied().filter(|&s| s > a && s < b));
    if edges.len() == 1 {
        edges.push(0.5 * (a + b));
    }
    edges.push(b);
    edges.dedup();
    (edges.windows(2))
        .map(|ends| Task::Piece(piece.part(ends[0], ends[1])))
        .collect()
}
