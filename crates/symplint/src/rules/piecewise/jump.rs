//! A jump between two nodes of a piece.

use super::curves::{At, Image};
use super::limits::{LARGE, SMOOTH, TERMS};
use super::lobatto::{evaluate, polynomial};
use super::piece::{Piece, Smooth};
use super::scales::Scales;
use crate::breaks::{
    AROUND_A_ZONE, Bracket, DISTANCES_AROUND, End, LOOKS, OF_A_CONFIRMATION, Progress, REPETITIONS,
    flickers, is_between_levels, is_repeated, lasting, moves_by_a_jump, scatter, stands_out,
};
use crate::signal::nearest;
use crate::state::{Coordinates, period};

/// A jump of a piece that is closed in on.
///
/// Left and right of it the coordinates, projected on the direction of the jump, are two smooth
/// functions: a point in between belongs to the one it is nearer to.
pub(super) struct Jump {
    pub piece: Piece,
    /// The gap between two nodes that it was in at first.
    pub gap: [f64; 2],
    pub bracket: Bracket,
    /// Images of the states beside it, from each end of the bracket outwards.
    beside: [Vec<Image>; 2],
    /// How often these were looked at.
    pub looks: usize,
    /// Images of the states round the zone in which the map may flicker, from each end outwards.
    around: [Vec<Image>; 2],
    /// Which of [`DISTANCES_AROUND`] they have, if the map flickers beside it.
    zone: Option<usize>,
    /// Times that both ends were advanced again; `None` before that.
    repetitions: Option<usize>,
    /// Whether they had the same jump each time, and moved by no more than that when they were displaced.
    is_repeated: bool,
    /// Where the jump points, for each coordinate.
    direction: Vec<f64>,
    /// A state nearby, from which coordinates are counted.
    reference: Vec<f64>,
    /// The function on the left, and what the right has more, over the piece.
    left: [f64; SMOOTH],
    step: [f64; TERMS],
    /// States that are granted for it.
    pub price: usize,
    /// The piece unchanged.
    pub fallback: Smooth,
}

/// States that a jump may ask for beside it, and its ends again and displaced.
const BESIDE: usize = 2 * (LOOKS[LOOKS.len() - 1] - 1) + OF_A_CONFIRMATION;

impl Jump {
    pub fn new(
        piece: Piece,
        gap: [f64; 2],
        ends: [Image; 2],
        (direction, reference): (Vec<f64>, Vec<f64>),
        (left, step): ([f64; SMOOTH], [f64; TERMS]),
        expected: f64,
        fallback: Smooth,
    ) -> Self {
        let bracket = Bracket::new(gap, expected);
        Jump {
            piece,
            gap,
            price: bracket.most_halvings() + BESIDE,
            bracket,
            beside: ends.map(|end| vec![end]),
            looks: 0,
            around: [Vec::new(), Vec::new()],
            zone: None,
            repetitions: None,
            is_repeated: true,
            direction,
            reference,
            left,
            step,
            fallback,
        }
    }

    /// What was granted for it and is not needed after all.
    pub fn refund(&self) -> usize {
        let beside: usize = self.beside.iter().map(|side| side.len() - 1).sum();
        let again = self.repetitions.map_or(0, |made| 2 + 2 * made);
        self.price - self.bracket.halvings() - beside - again
    }

    /// The images of both ends.
    pub fn ends(&self) -> [&Image; 2] {
        [&self.beside[0][0], &self.beside[1][0]]
    }

    /// The coordinates counted from some origin, in the direction of the jump.
    fn project(&self, state: &[f64], origin: &[f64], coordinates: &Coordinates) -> f64 {
        let terms = self.direction.iter().enumerate();
        terms
            .map(|(c, direction)| direction * nearest(state[c] - origin[c], period(coordinates, c)))
            .sum()
    }

    /// Halves the bracket, with the image of its middle.
    pub fn halve(&mut self, image: Image, coordinates: &Coordinates) -> Progress {
        let smooth = |s: f64| evaluate(&self.left, self.piece.x(s));
        let middle = self.bracket.middle();
        let value = self.project(image.after(), &self.reference, coordinates) - smooth(middle);
        let end = match value < 0.5 * polynomial(&self.step, self.piece.x(middle)) {
            true => End::Low,
            false => End::High,
        };
        self.beside[end as usize][0] = image;
        let [low, high] = self
            .ends()
            .map(|end| self.project(end.after(), &self.reference, coordinates));
        let mut ends = [self.bracket.low, self.bracket.high];
        ends[end as usize] = middle;
        let difference = (high - smooth(ends[1])) - (low - smooth(ends[0]));
        self.bracket.halve(end, difference)
    }

    /// The states beside it, or around its zone, that the next look needs and that are not known yet; or its ends again, in another
    /// order each time, and displaced at first.
    pub fn surroundings(&self) -> impl Iterator<Item = At> {
        let curve = self.piece.curve;
        let within = move |s: f64| match curve {
            0 if (0.0..=1.0).contains(&s) => s,
            0 => s.rem_euclid(1.0),
            _ => s.clamp(0.0, 1.0),
        };
        self.order().into_iter().flat_map(move |end| {
            let around = |distance: f64| self.bracket.around(end, distance);
            let states: Vec<f64> = match (self.repetitions, self.zone) {
                (Some(made), _) => {
                    let once = if made == 0 { 2 } else { 1 };
                    around(0.0).take(once).collect()
                }
                (None, None) => {
                    let known = self.beside[end as usize].len();
                    self.bracket.beside(end, self.looks).skip(known).collect()
                }
                (None, Some(k)) => around(DISTANCES_AROUND[k]).skip(1).collect(),
            };
            // The second one of the same state is displaced.
            let again = self.repetitions.is_some();
            states.into_iter().enumerate().map(move |(k, s)| At {
                curve,
                s: within(s),
                pattern: if again && k == 1 { 1 + end as usize } else { 0 },
            })
        })
    }

    /// In which order the ends are advanced.
    fn order(&self) -> [End; 2] {
        match self.repetitions {
            Some(k) if k % 2 == 0 => [End::High, End::Low],
            _ => [End::Low, End::High],
        }
    }

    /// How many they are.
    pub fn missing(&self) -> usize {
        match (self.repetitions, self.zone) {
            (Some(0), _) => 4,
            (Some(_), _) => 2,
            (None, None) => (self.beside.iter())
                .map(|side| LOOKS[self.looks] - side.len())
                .sum(),
            (None, Some(_)) => 2 * (AROUND_A_ZONE - 1),
        }
    }

    /// How many of them were not granted with the jump.
    pub fn extra(&self) -> usize {
        match (self.repetitions, self.zone) {
            (None, Some(_)) => self.missing(),
            _ => 0,
        }
    }

    /// Asks for both ends again; whether that was not done often enough.
    pub fn repeat(&mut self) -> bool {
        let made = *self.repetitions.get_or_insert(0);
        self.is_repeated && made < REPETITIONS
    }

    /// Takes in both ends again, and displaced.
    fn look_again(&mut self, images: &[Image], made: usize, coordinates: &Coordinates) {
        let mut sides = images.split_at(images.len() / 2);
        if self.order()[0] == End::High {
            sides = (sides.1, sides.0);
        }
        let again = [sides.0, sides.1];
        let jump = |[low, high]: [&Image; 2]| self.project(high.after(), low.after(), coordinates);
        let [before, after] = [jump(self.ends()), jump(again.map(|side| &side[0]))];
        self.is_repeated &= is_repeated(before, after);
        let beside = self.beside.each_ref().map(Vec::as_slice);
        let [low, high] = self.projected(beside, coordinates);
        let lasting = lasting(before, [&low, &high]);
        for end in [End::Low, End::High] {
            let [from, moved] = match again[end as usize] {
                [from, moved] => [from, moved].map(Image::after),
                _ => continue,
            };
            let moved = self.project(moved, from, coordinates);
            self.is_repeated &= moves_by_a_jump(after, lasting, moved);
        }
        self.repetitions = Some(made + 1);
        if !self.is_repeated {
            let ends = [self.bracket.low, self.bracket.high].into_iter().zip(again);
            ends.for_each(|(s, side)| self.piece.replace(s, &side[0]));
        }
    }

    /// Takes their images in.
    pub fn look(&mut self, images: &[Image], coordinates: &Coordinates) {
        if let Some(made) = self.repetitions {
            return self.look_again(images, made, coordinates);
        }
        let (left, right) = images.split_at(images.len() / 2);
        for (k, images) in [left, right].into_iter().enumerate() {
            match self.zone {
                None => self.beside[k].extend_from_slice(images),
                Some(_) => {
                    let end = self.beside[k][..1].iter();
                    self.around[k] = end.chain(images).cloned().collect();
                }
            }
        }
        if self.zone.is_none() {
            self.looks += 1;
        }
    }

    /// Goes on to states round the zone, or nearer to it; whether there is room for them in the piece.
    pub fn look_around(&mut self) -> bool {
        let room = (self.bracket.low - self.piece.a).min(self.piece.b - self.bracket.high);
        let first = self.zone.map_or(0, |k| k + 1);
        let fits = |k: &usize| (AROUND_A_ZONE - 1) as f64 * DISTANCES_AROUND[*k] <= room;
        self.zone = (first..DISTANCES_AROUND.len()).find(fits);
        self.zone.is_some()
    }

    /// Whether rounding decides on which side of it the states beside it are.
    pub fn flickers(&self) -> bool {
        self.zone.is_some()
    }

    /// The states of each side in the direction of the jump, from its own end, so that a wrap in between is none
    /// of it.
    fn projected(&self, sides: [&[Image]; 2], coordinates: &Coordinates) -> [Vec<f64>; 2] {
        sides.map(|side| {
            let origin = side[0].after();
            let each = side.iter();
            each.map(|image| self.project(image.after(), origin, coordinates))
                .collect()
        })
    }

    /// What the states beside it say of it.
    pub fn judge(&self, scales: &Scales, coordinates: &Coordinates) -> Judgement {
        let [low, high] = self.ends().map(Image::after);
        let jump = self.project(high, low, coordinates);
        if self.repetitions.is_some() {
            return match self.is_repeated {
                true => Judgement::Break,
                false => Judgement::Noise,
            };
        }
        if self.zone.is_some() {
            let around = self.around.each_ref().map(Vec::as_slice);
            let [left, right] = self.projected(around, coordinates);
            return match is_between_levels(jump, [&left, &right]) {
                true => Judgement::Break,
                false => Judgement::LookAround,
            };
        }
        let sizes = self.sizes(coordinates);
        let apart = |c: usize| sizes[c];
        let mut all = 0..2 * coordinates.dof();
        let is_rounding = (scales.grain.as_ref())
            .is_some_and(|grain| !all.clone().any(|c| grain.is_exceeded(c, apart(c))));
        let large = (all.clone()).any(|c| scales.weight(c) * apart(c) > LARGE);
        // The steps of a grid are jumps with nothing beside them, and noise all the same.
        let no_step = all.any(|c| apart(c) > self.piece.allowance(c, scales));
        let beside = self.beside.each_ref().map(Vec::as_slice);
        let [left, right] = self.projected(beside, coordinates);
        let sides = [&left[..], &right[..]];
        if is_rounding {
            Judgement::Noise
        } else if stands_out(jump, sides) && (large || no_step) {
            Judgement::Break
        } else if !large && self.bracket.is_little(jump) {
            Judgement::Wrap
        } else if self.looks < LOOKS.len() {
            Judgement::LookAgain
        } else if large && flickers(jump, sides) {
            Judgement::Break
        } else if no_step && flickers(jump, sides) {
            Judgement::LookAround
        } else {
            Judgement::Noise
        }
    }

    /// How far each coordinate jumps.
    pub fn sizes(&self, coordinates: &Coordinates) -> Vec<f64> {
        let [low, high] = self.ends().map(Image::after);
        let jump = |c: usize| nearest(high[c] - low[c], period(coordinates, c)).abs();
        (0..2 * coordinates.dof()).map(jump).collect()
    }

    /// How far each coordinate scatters beside it.
    pub fn noise(&self, coordinates: &Coordinates) -> Vec<f64> {
        let origin = self.ends()[0].after();
        let of_coordinate = |c: usize| {
            let period = period(coordinates, c);
            let sides = self.beside.each_ref().map(|side| -> Vec<f64> {
                let each = side.iter();
                each.map(|image| nearest(image.after()[c] - origin[c], period))
                    .collect()
            });
            scatter([&sides[0], &sides[1]])
        };
        (0..2 * coordinates.dof()).map(of_coordinate).collect()
    }
}

/// What a jump is.
pub(super) enum Judgement {
    Break,
    /// A period, and none.
    Wrap,
    /// It may be noise: more states tell.
    LookAgain,
    /// Rounding decides on which side of it the states beside it are: those further away tell.
    LookAround,
    Noise,
}
