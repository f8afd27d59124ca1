//! A jump between two nodes of a piece.

use super::curves::{CurvePoint, PointImage};
use super::limits::{FIRST_SMALL, MAX_NOISE, MAX_TERMS};
use super::lobatto::{evaluate, polynomial};
use super::piece::Piece;
use super::scales::Scales;
use crate::breaks::{
    Bracket, CONFIRMING_STATES, DISTANCES_FROM_ZONE, End, INTERMEDIATE_ZONE_STATES, Progress,
    STATES_AROUND_ZONE, STATES_OF_LOOKS, flickers, interleaved, is_between_levels,
    keeps_its_levels, lands_on_a_level, lasting, scatter, stands_out,
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
    /// Images of the states next to it, from each end of the bracket outwards.
    beside: [Vec<PointImage>; 2],
    /// How often these were examined.
    pub looks: usize,
    /// Images of the states round the zone in which the map may flicker, from each end outwards.
    around: [Vec<PointImage>; 2],
    /// Which of [`DISTANCES_FROM_ZONE`] they have, if the map flickers next to it.
    zone: Option<usize>,
    confirmation: Confirmation,
    /// Whether states that were to confirm it are on both of its levels.
    flickers: bool,
    /// States used of those that were granted with it, in addition to the bracket.
    used: usize,
    /// The sign of the jump for each coordinate.
    direction: Vec<f64>,
    /// A state nearby, from which coordinates are counted.
    reference: Vec<f64>,
    /// The function on the left, and what the right has more, over the piece.
    left: [f64; FIRST_SMALL],
    step: [f64; MAX_TERMS],
    /// States that are granted for it.
    pub price: usize,
}

/// Whether more states say the same of a jump as the first ones.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Confirmation {
    /// Not asked for, or not given by the states around a zone: nearer ones may give it.
    None,
    /// By this number of states on each side, if no zone was found.
    Wanted(usize),
    Made {
        is_break: bool,
    },
}

/// States that a jump may ask for next to it, and its ends displaced.
const MAX_STATES_BESIDE_JUMP: usize = 2 * CONFIRMING_STATES;

impl Jump {
    pub fn new(
        piece: Piece,
        gap: [f64; 2],
        ends: [PointImage; 2],
        (direction, reference): (Vec<f64>, Vec<f64>),
        (left, step): ([f64; FIRST_SMALL], [f64; MAX_TERMS]),
        expected: f64,
    ) -> Self {
        let bracket = Bracket::new(gap, expected);
        Jump {
            piece,
            gap,
            price: bracket.most_halvings() + MAX_STATES_BESIDE_JUMP,
            bracket,
            beside: ends.map(|end| vec![end]),
            looks: 0,
            around: [Vec::new(), Vec::new()],
            zone: None,
            confirmation: Confirmation::None,
            flickers: false,
            used: 0,
            direction,
            reference,
            left,
            step,
        }
    }

    /// The evaluations granted for it that are not needed after all.
    pub fn refund(&self) -> usize {
        self.price - self.bracket.halvings() - self.used
    }

    /// The images of both ends.
    pub fn ends(&self) -> [&PointImage; 2] {
        [&self.beside[0][0], &self.beside[1][0]]
    }

    /// The coordinates counted from some origin, in the direction of the jump.
    fn project(&self, state: &[f64], origin: &[f64], coordinates: &Coordinates) -> f64 {
        project(&self.direction, state, origin, coordinates)
    }

    /// From one end to the other, in that direction.
    fn jump(&self, coordinates: &Coordinates) -> f64 {
        let [low, high] = self.ends().map(PointImage::after);
        self.project(high, low, coordinates)
    }

    /// Halves the bracket, with the image of its middle.
    pub fn halve(&mut self, image: PointImage, coordinates: &Coordinates) -> Progress {
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

    /// The states next to it, or around its zone, that the next look needs and that are not known yet. The last of each side that
    /// confirm a jump without a zone is its end, displaced.
    pub fn surroundings(&self) -> impl Iterator<Item = CurvePoint> {
        let curve = self.piece.curve;
        let within = move |s: f64| match curve {
            0 if (0.0..=1.0).contains(&s) => s,
            0 => s.rem_euclid(1.0),
            _ => s.clamp(0.0, 1.0),
        };
        [End::Low, End::High].into_iter().flat_map(move |end| {
            let known = self.beside[end as usize].len();
            let is_wanted = self.is_wanted();
            let states: Vec<f64> = match self.zone.map(|k| DISTANCES_FROM_ZONE[k]) {
                None => (self.bracket.beside(end))
                    .take(self.beside_wanted())
                    .skip(known)
                    .collect(),
                Some(distance) if is_wanted => self.bracket.between(end, distance).collect(),
                Some(distance) => self.bracket.around(end, distance).skip(1).collect(),
            };
            let is_displaced = is_wanted && self.zone.is_none();
            let own = self.bracket.beside(end).take(usize::from(is_displaced));
            let displaced = own.map(move |s| (s, 1 + end as usize));
            let states = states.into_iter().map(|s| (s, 0)).chain(displaced);
            states.map(move |(s, pattern)| CurvePoint {
                curve,
                s: within(s),
                pattern,
            })
        })
    }

    /// How many states of each side the next look has, without a zone.
    fn beside_wanted(&self) -> usize {
        match self.confirmation {
            Confirmation::Wanted(states) => states,
            _ => STATES_OF_LOOKS[self.looks],
        }
    }

    /// Whether the next look is to confirm it.
    fn is_wanted(&self) -> bool {
        matches!(self.confirmation, Confirmation::Wanted(_))
    }

    /// How many of them are not known.
    pub fn missing(&self) -> usize {
        let beside = |side: &Vec<PointImage>| self.beside_wanted() - side.len();
        let is_wanted = self.is_wanted();
        match self.zone {
            None => self.beside.iter().map(beside).sum::<usize>() + 2 * usize::from(is_wanted),
            Some(_) if is_wanted => 2 * INTERMEDIATE_ZONE_STATES,
            Some(_) => 2 * (STATES_AROUND_ZONE - 1),
        }
    }

    /// How many of them were not granted with the jump.
    pub fn extra(&self) -> usize {
        self.zone.map_or(0, |_| self.missing())
    }

    /// Asks for the states that confirm it, if it has not been done: fewer if it is large.
    pub fn wants_confirmation(&mut self, scales: &Scales, coordinates: &Coordinates) -> bool {
        // The same states would be asked for again.
        let is_known = self.flickers && self.zone.is_none();
        let is_new = self.confirmation == Confirmation::None && !is_known;
        if is_new {
            self.confirmation = Confirmation::Wanted(match self.is_large(scales, coordinates) {
                true => STATES_OF_LOOKS[1],
                false => CONFIRMING_STATES,
            });
        }
        is_new
    }

    /// Whether noise cannot be as large.
    fn is_large(&self, scales: &Scales, coordinates: &Coordinates) -> bool {
        let sizes = self.sizes(coordinates).into_iter().enumerate();
        sizes
            .map(|(c, size)| scales.weight(c) * size)
            .any(|part| part > MAX_NOISE)
    }

    /// Takes in more states on both sides, and the ends displaced.
    fn confirm(&mut self, sides: [&[PointImage]; 2], coordinates: &Coordinates) {
        let jump = self.jump(coordinates);
        let [low, high] = self.projected(&self.beside, coordinates);
        let did_stand_out = stands_out(jump, [&low, &high]);
        let mut moved = [0.0; 2];
        for ((side, images), moved) in self.beside.iter_mut().zip(sides).zip(&mut moved) {
            let [new @ .., displaced] = images else {
                continue;
            };
            let from = side[0].after();
            *moved = project(&self.direction, displaced.after(), from, coordinates);
            side.extend_from_slice(new);
        }
        let [low, high] = self.projected(&self.beside, coordinates);
        let lasting = lasting(jump, [&low, &high]);
        let is_steady = moved
            .iter()
            .all(|moved| lands_on_a_level(jump, lasting, *moved));
        let flickers = flickers(jump, [&low, &high]);
        let is_break = match did_stand_out {
            true => keeps_its_levels(jump, [&low, &high]),
            false => flickers,
        };
        self.flickers = is_steady && !is_break && flickers;
        self.confirmation = match self.flickers {
            true => Confirmation::None,
            false => Confirmation::Made {
                is_break: is_steady && is_break,
            },
        };
    }

    /// Takes in the states between those around the zone. If they do not confirm it, nearer states may.
    fn confirm_zone(&mut self, sides: [&[PointImage]; 2], coordinates: &Coordinates) {
        for (side, between) in self.around.iter_mut().zip(sides) {
            *side = interleaved(side, between);
        }
        let [low, high] = self.projected(&self.around, coordinates);
        let is_break = is_between_levels(self.jump(coordinates), [&low, &high]);
        self.confirmation = match is_break {
            true => Confirmation::Made { is_break },
            false => Confirmation::None,
        };
    }

    /// Takes their images in.
    pub fn look(&mut self, images: &[PointImage], coordinates: &Coordinates) {
        let (left, right) = images.split_at(images.len() / 2);
        match (self.zone, self.is_wanted()) {
            (None, true) => self.confirm([left, right], coordinates),
            (Some(_), true) => self.confirm_zone([left, right], coordinates),
            (None, false) => {
                self.beside[0].extend_from_slice(left);
                self.beside[1].extend_from_slice(right);
                self.looks += 1;
            }
            (Some(_), false) => {
                let ends = self.beside.each_ref().map(|side| &side[..1]);
                self.around = [[ends[0], left].concat(), [ends[1], right].concat()];
            }
        }
        if self.zone.is_none() {
            self.used += images.len();
        }
    }

    /// Goes on to states round the zone, or nearer to it; whether there is room for them in the piece.
    pub fn look_around(&mut self) -> bool {
        let room = (self.bracket.low - self.piece.a).min(self.piece.b - self.bracket.high);
        let first = self.zone.map_or(0, |k| k + 1);
        let fits = |k: &usize| (STATES_AROUND_ZONE - 1) as f64 * DISTANCES_FROM_ZONE[*k] <= room;
        self.zone = (first..DISTANCES_FROM_ZONE.len()).find(fits);
        self.zone.is_some()
    }

    /// Whether rounding decides on which side of it the states next to it are.
    pub fn flickers(&self) -> bool {
        self.zone.is_some()
    }

    /// The states of each side in the direction of the jump, from its own end, so that a wrap in between is not a part
    /// of it.
    fn projected(&self, sides: &[Vec<PointImage>; 2], coordinates: &Coordinates) -> [Vec<f64>; 2] {
        sides.each_ref().map(|side| {
            let origin = side[0].after();
            let each = side.iter();
            each.map(|image| self.project(image.after(), origin, coordinates))
                .collect()
        })
    }

    /// Its size from the states next to it.
    pub fn judge(&self, scales: &Scales, coordinates: &Coordinates) -> Judgement {
        let jump = self.jump(coordinates);
        match self.confirmation {
            Confirmation::Made { is_break: true } => return Judgement::Break,
            Confirmation::Made { is_break: false } => return Judgement::Noise,
            _ => {}
        }
        if self.zone.is_some() {
            let [left, right] = self.projected(&self.around, coordinates);
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
        let large = self.is_large(scales, coordinates);
        // The steps of a grid are jumps with nothing next to them, and noise all the same.
        let no_step = all.any(|c| apart(c) > self.piece.allowance(c, scales));
        let [left, right] = self.projected(&self.beside, coordinates);
        let sides = [&left[..], &right[..]];
        if is_rounding {
            Judgement::Noise
        } else if self.flickers {
            // It may be large all the same: other breaks are close by.
            if large {
                Judgement::Break
            } else {
                Judgement::LookAround
            }
        } else if stands_out(jump, sides) && (large || no_step) {
            Judgement::Break
        } else if self.looks < STATES_OF_LOOKS.len() {
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
    fn sizes(&self, coordinates: &Coordinates) -> Vec<f64> {
        let [low, high] = self.ends().map(PointImage::after);
        let jump = |c: usize| nearest(high[c] - low[c], period(coordinates, c)).abs();
        (0..2 * coordinates.dof()).map(jump).collect()
    }

    /// How far each coordinate scatters next to it.
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

/// A state counted from an origin, in a direction.
fn project(direction: &[f64], state: &[f64], origin: &[f64], coordinates: &Coordinates) -> f64 {
    let terms = direction.iter().enumerate();
    terms
        .map(|(c, direction)| direction * nearest(state[c] - origin[c], period(coordinates, c)))
        .sum()
}

/// The kind of a jump.
pub(super) enum Judgement {
    Break,
    /// It may be noise: more states tell.
    LookAgain,
    /// Rounding decides on which side of it the states next to it are: those further away show the side.
    LookAround,
    Noise,
}
