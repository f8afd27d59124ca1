//! Bisection of a jump, and how a jump is distinguished from noise and from a steep stretch.

use super::limits::{
    CONFIRMING_STATES, HALVINGS_BEFORE_TEST, INTERMEDIATE_ZONE_STATES, MAX_MISMATCH_OF_SIZES,
    MAX_WIDTH_OF_CONSTANT_JUMP, MIN_BRACKET_WIDTH, MIN_JUMP_OVER_NOISE, MIN_PART_ON_HALVING,
    ROUNDINGS_OF_DISPLACEMENT, SPACING_BESIDE_JUMP, STATES_AROUND_ZONE, STATES_OF_LOOKS,
};
use crate::state::Block;

/// Two parameters with a jump between them, of a function that is continuous on both sides of it.
#[derive(Clone, Debug)]
pub(crate) struct Bracket {
    /// The jump is after `low` and not after `high`.
    pub low: f64,
    pub high: f64,
    /// Size that the jump should have.
    expected: f64,
    halvings: usize,
}

/// An end of a bracket.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    Low,
    High,
}

/// The facts about a bracket after it was halved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Progress {
    /// It can be halved again.
    Open,
    /// It is as narrow as double precision allows, and the values at its ends still differ.
    Jump,
    /// The difference of its ends has shrunk: the function is steep there, not discontinuous.
    Continuous,
}

impl Bracket {
    /// Between two parameters, round a jump that should have this size.
    pub fn new([low, high]: [f64; 2], expected: f64) -> Self {
        Bracket {
            low,
            high,
            expected,
            halvings: 0,
        }
    }

    /// The point to evaluate next.
    pub fn middle(&self) -> f64 {
        self.low + 0.5 * (self.high - self.low)
    }

    /// Times that it was halved.
    pub fn halvings(&self) -> usize {
        self.halvings
    }

    /// How often it can be halved at most.
    pub fn most_halvings(&self) -> usize {
        // Once more than if parameters were not rounded.
        1 + ((self.high - self.low) / MIN_BRACKET_WIDTH)
            .log2()
            .ceil()
            .max(0.0) as usize
    }

    /// The size that the jump should have.
    pub fn expected(&self) -> f64 {
        self.expected
    }

    /// Halves the bracket, whose middle becomes this `end`, with the `difference` of both ends, less what the
    /// smooth functions on the two sides make of its width.
    pub fn halve(&mut self, end: End, difference: f64) -> Progress {
        match end {
            End::Low => self.low = self.middle(),
            End::High => self.high = self.middle(),
        }
        self.halvings += 1;
        if self.high - self.low < MAX_WIDTH_OF_CONSTANT_JUMP {
            self.expected = self.expected.max(difference.abs());
        }
        if self.halvings > HALVINGS_BEFORE_TEST && self.is_little(difference) {
            Progress::Continuous
        } else if self.is_narrow() {
            Progress::Jump
        } else {
            Progress::Open
        }
    }

    /// Whether so little is left of the difference of both ends that it is not a jump. Counted modulo a period, that
    /// happens to wraps.
    pub fn is_little(&self, difference: f64) -> bool {
        difference.abs() < MIN_PART_ON_HALVING * self.expected
    }

    /// Whether it can no longer be halved.
    pub fn is_narrow(&self) -> bool {
        let middle = self.middle();
        self.high - self.low <= MIN_BRACKET_WIDTH || middle <= self.low || middle >= self.high
    }

    /// Parameters of the states next to the bracket that distinguish a jump from noise, on its `end`, from there outwards;
    /// the first is the end itself.
    pub fn beside(&self, end: End) -> impl Iterator<Item = f64> + use<> {
        (0..CONFIRMING_STATES).map(self.outwards(end, SPACING_BESIDE_JUMP))
    }

    /// Parameters of states at this `distance` from each other, from its `end` outwards; the first is the end itself.
    pub fn around(&self, end: End, distance: f64) -> impl Iterator<Item = f64> + use<> {
        (0..STATES_AROUND_ZONE).map(self.outwards(end, distance))
    }

    /// Parameters of states in the middle between those around a zone.
    pub fn between(&self, end: End, distance: f64) -> impl Iterator<Item = f64> + use<> {
        let half = self.outwards(end, 0.5 * distance);
        (0..INTERMEDIATE_ZONE_STATES).map(move |k| half(3 + 2 * k))
    }

    /// The parameter that is a number of these distances from an end.
    fn outwards(&self, end: End, distance: f64) -> impl Fn(usize) -> f64 + use<> {
        let (from, outwards) = match end {
            End::Low => (self.low, -distance),
            End::High => (self.high, distance),
        };
        move |k| from + k as f64 * outwards
    }
}

/// Whether a `jump` stands out of the values next to it, each side from its end outwards: of their noise, and of their steps,
/// which are what the slope makes of the rounding of states; and whether the values on the two sides are as far apart as the
/// ends, which one wrong state is not.
pub(crate) fn stands_out(jump: f64, sides: [&[f64]; 2]) -> bool {
    let lasts = lasting(jump, sides) / jump > 0.5;
    // Other breaks close by spoil two of five steps at most; at the first look there are two in all.
    let step = |side: &[f64]| median(side.windows(2).map(|x| (x[1] - x[0]).abs()));
    let climb = step(sides[0]).max(step(sides[1]));
    lasts && jump.abs() > MIN_JUMP_OVER_NOISE * scatter(sides).max(climb)
}

/// How far the values on one side of a `jump` are from those on the other.
pub(crate) fn lasting(jump: f64, sides: [&[f64]; 2]) -> f64 {
    let [low, high] = sides.map(|side| median(side.iter().map(|x| x - side[0])));
    jump + high - low
}

/// Displaces a state by a few roundings of each coordinate, one way in `pattern` 1 and the other way in pattern 2. The two differ in size,
/// so that displacements that cancel at one end of a bracket do not cancel at the other.
pub(crate) fn displace(block: &mut Block<'_>, sample: usize, pattern: usize) {
    let dof = block.q.count();
    for c in 0..2 * dof {
        // Quasi-random: a sign, and a part between ½ and 3/2.
        let k = (c + 1) as f64;
        let forward = ((0.618_034 * k).fract() < 0.5) == pattern.is_multiple_of(2);
        let part = 0.5 + (0.754_878 * k + 0.3 * pattern as f64).fract();
        let row = match c < dof {
            true => block.q.row_mut(c),
            false => block.p.row_mut(c - dof),
        };
        let size = part * ROUNDINGS_OF_DISPLACEMENT * f64::EPSILON * row[sample].abs();
        row[sample] += if forward { size } else { -size };
    }
}

/// Whether a displaced end of a `jump` lands on one of its levels: it has not `moved`, or by the jump, or as far as the values on
/// the two sides are apart, since what breaks the loop may be so close that the state is on its other side, or by two jumps, which
/// a force with a separate value at its threshold has. On a slope it moves by
/// several times the jump, as the jump is a rounding of the state times the slope; in noise it moves by any part of it.
pub(crate) fn lands_on_a_level(jump: f64, lasting: f64, moved: f64) -> bool {
    let off = |level: f64| (moved.abs() - level.abs()).abs();
    let levels = [0.0, jump, 2.0 * jump, lasting].into_iter();
    levels.map(off).fold(f64::INFINITY, f64::min) <= MAX_MISMATCH_OF_SIZES * jump.abs()
}

/// Whether the values on each side of a `jump`, from its end outwards, are on one level, apart from their slope, and the two levels as far
/// apart as the ends: what a map does at random, or from the bits of the state, has both levels on both sides. Up to the first
/// look, they may have separate values, as a force that is 0 at its threshold.
pub(crate) fn keeps_its_levels(jump: f64, sides: [&[f64]; 2]) -> bool {
    let is_level = |side: &&[f64]| {
        let side = &side[STATES_OF_LOOKS[0]..];
        let step = (side[side.len() - 1] - side[0]) / (side.len() - 1) as f64;
        let off = |(k, x): (usize, &f64)| (x - side[0] - k as f64 * step).abs();
        let mut values = side.iter().enumerate();
        values.all(|value| off(value) <= MAX_MISMATCH_OF_SIZES * jump.abs())
    };
    lasting(jump, sides) / jump > 0.5 && sides.iter().all(is_level)
}

/// The values around a zone, from the end outwards, with those in the middle between them: at equal distances, without the end.
pub(crate) fn interleaved<T: Clone>(around: &[T], between: &[T]) -> Vec<T> {
    let pairs = around[1..].iter().zip(between);
    let each = pairs.flat_map(|(at, next)| [at.clone(), next.clone()]);
    each.chain(around.last().cloned()).collect()
}

/// The middle one of some values, the larger one of two.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Whether the values on the sides of a `jump`, each side from its end outwards, are those before the jump and those
/// after it, and no others: rounding decides on which side of a threshold a state is, such as the tolerance at which a
/// solver stops. Noise has any values.
pub(crate) fn flickers(jump: f64, sides: [&[f64]; 2]) -> bool {
    let little = jump.abs() / MIN_JUMP_OVER_NOISE;
    let is_of_a_level = |side: &[f64], other: f64| {
        let off = |x: &f64| (x - side[0]).abs().min((x - side[0] - other).abs());
        side.iter().all(|x| off(x) < little)
    };
    is_of_a_level(sides[0], jump) && is_of_a_level(sides[1], -jump)
}

/// Whether the values on both sides of a `jump`, at equal distances from its end outwards, are smooth: none of them is
/// on the other side of the jump.
pub(crate) fn is_between_levels(jump: f64, sides: [&[f64]; 2]) -> bool {
    let third_difference = |x: &[f64]| (x[3] - x[0] - 3.0 * (x[2] - x[1])).abs();
    let differences = sides.iter().flat_map(|side| side.windows(4));
    let largest = differences.map(third_difference).fold(0.0, f64::max);
    jump.abs() > MIN_JUMP_OVER_NOISE * largest
}

/// How far the values on the sides of a jump scatter, on the side where they do so more.
///
/// Second differences of a straight line vanish; those of noise are larger than it. Noise fills a side; a
/// second jump close by spoils two of its differences at most, and the largest of the others counts. At the
/// first look there is one alone.
pub(crate) fn scatter(sides: [&[f64]; 2]) -> f64 {
    let of_side = |side: &[f64]| {
        let mut bends: Vec<f64> = (side.windows(3))
            .map(|x| (x[0] - 2.0 * x[1] + x[2]).abs())
            .collect();
        bends.sort_by(f64::total_cmp);
        bends[bends.len().saturating_sub(3)]
    };
    of_side(sides[0]).max(of_side(sides[1]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::Ensemble;

    #[test]
    fn a_jump_stands_out_of_the_steps_beside_it() {
        let line = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        assert!(!stands_out(MIN_JUMP_OVER_NOISE - 0.1, [&line, &line]));
        assert!(stands_out(MIN_JUMP_OVER_NOISE + 0.1, [&line, &line]));
        // Other breaks, and a separate value where a force jumps.
        for other in [
            [0.0, 1.0, 1.0, 1.0, 1.0, 1.0],
            [0.0, 0.0, 0.0, 7.0, 7.0, 7.0],
        ] {
            assert!(stands_out(1.0, [&[0.0; 6], &other]), "{other:?}");
        }
    }

    #[test]
    fn one_wrong_state_and_a_root_do_not_stand_out() {
        for wrong in [1.0, -1.0] {
            let side = [wrong, 0.0, 0.0, 0.0, 0.0, 0.0];
            assert!(!stands_out(wrong, [&[0.0; 6], &side]));
            assert!(!stands_out(wrong, [&[0.0; 3], &side[..3]]));
        }
        // √s, whose bracket is 1/64 of the spacing wide.
        let root: [f64; 6] = std::array::from_fn(|k| (1.0 / 64.0 + k as f64).sqrt());
        assert!(!stands_out(root[0], [&[0.0; 6], &root]));
        assert!(!stands_out(root[0], [&[0.0; 3], &root[..3]]));
    }

    #[test]
    fn noise_beside_a_jump_is_what_a_second_jump_does_not_spoil() {
        let noisy: [f64; 10] = std::array::from_fn(|k| if k % 2 == 0 { 0.1 } else { -0.1 });
        for states in [3, 6, 10] {
            // Every second difference is 4 times the noise.
            let found = scatter([&[0.0; 10][..states], &noisy[..states]]);
            assert!((found - 0.4).abs() < 1e-15, "{states}: {found}");
        }
        let with_jump: [f64; 10] = std::array::from_fn(|k| f64::from(u8::from(k > 4)));
        assert_eq!(scatter([&[0.0; 10], &with_jump]), 0.0);
        // Rest on the side, but for four states in ten.
        let half = [0.0, 0.0, 0.0, 0.0, 0.0, 0.1, -0.1, 0.1, -0.1, 0.1];
        assert!(scatter([&[0.0; 10], &half]) > 0.2);
    }

    #[test]
    fn states_around_a_zone_and_between_them_are_equally_far_apart() {
        let bracket = Bracket::new([0.5, 0.5 + 1e-9], 1.0);
        for (end, sign) in [(End::Low, -1.0), (End::High, 1.0)] {
            let around: Vec<f64> = bracket.around(end, 1e-3).collect();
            let between: Vec<f64> = bracket.between(end, 1e-3).collect();
            let all = interleaved(&around, &between);
            assert_eq!(all.len(), STATES_AROUND_ZONE - 1 + INTERMEDIATE_ZONE_STATES);
            let origin = around[0];
            for (k, s) in all.iter().enumerate() {
                let expected = origin + sign * (1e-3 + 5e-4 * k as f64);
                assert!((s - expected).abs() < 1e-15, "{k}: {s}");
            }
        }
    }

    #[test]
    fn the_size_of_a_break_stays_while_its_bracket_shrinks() {
        let narrowed = |expected: f64, difference: &dyn Fn(f64) -> f64| {
            let mut bracket = Bracket::new([0.25, 0.375], expected);
            loop {
                let width = 0.5 * (bracket.high - bracket.low);
                match bracket.halve(End::Low, difference(width)) {
                    Progress::Open => {}
                    progress => return progress,
                }
            }
        };
        assert_eq!(narrowed(1.0, &|_| 1.0), Progress::Jump);
        assert_eq!(narrowed(1.0, &|width| 1.0 + 1e12 * width), Progress::Jump);
        // It is much larger close by than it seemed, and shrinks.
        let hidden = |power: f64| move |width: f64| 1e-9f64.max(width.min(1e-12).powf(power));
        assert_eq!(narrowed(1e-9, &hidden(0.5)), Progress::Continuous);
    }

    #[test]
    fn displaced_ends_move_along_a_slope_and_by_no_more_than_a_jump() {
        let moved = |value: &dyn Fn(f64, f64) -> f64, pattern: usize| {
            let mut states = Ensemble::zeros(1, 1);
            states.block().q.row_mut(0)[0] = -0.25;
            states.block().p.row_mut(0)[0] = 1.0;
            let before = value(-0.25, 1.0);
            displace(&mut states.block(), 0, pattern);
            value(states.q().row(0)[0], states.p().row(0)[0]) - before
        };
        for pattern in [1, 2] {
            // A sum that a scaling of the state leaves 0, steep in either.
            let steep = moved(&|q, p| 1e9 * (q + 0.25 * p), pattern);
            let of_a_rounding = 1e9 * 0.125 * f64::EPSILON;
            assert!(!lands_on_a_level(of_a_rounding, 0.0, steep), "{steep:e}");
            let flat = moved(&|q, p| 3.0 * q - p, pattern);
            assert!(lands_on_a_level(1e-11, 0.0, flat), "{flat:e}");
        }
        // A root, from one side or the other.
        let root = |q: f64, _: f64| (q + 0.25).max(0.0).sqrt();
        let above = [1, 2].map(|pattern| moved(&root, pattern));
        let of_a_rounding = (0.125 * f64::EPSILON).sqrt();
        assert!(
            above
                .iter()
                .any(|moved| !lands_on_a_level(of_a_rounding, 0.0, *moved)),
            "{above:?}"
        );
    }

    #[test]
    fn each_side_of_a_break_keeps_its_level() {
        // A slope, and a rounding.
        let side: [f64; 10] = std::array::from_fn(|k| 0.02 * k as f64 + 0.1 * (k % 2) as f64);
        assert!(keeps_its_levels(1.0, [&side, &side]));
        for k in 0..10 {
            let mut wrong = side;
            wrong[k] += 1.0;
            let was_seen = k > 0 && k < STATES_OF_LOOKS[0];
            assert_eq!(keeps_its_levels(1.0, [&side, &wrong]), was_seen, "{k}");
            assert_eq!(keeps_its_levels(-1.0, [&wrong, &side]), was_seen, "{k}");
        }
    }

    #[test]
    fn a_displaced_end_lands_on_one_of_the_levels() {
        for level in [0.0, 1.0, -1.0, 2.0, 4.0] {
            assert!(lands_on_a_level(1.0, 4.0, level + 0.24), "{level}");
            assert!(!lands_on_a_level(1.0, 4.0, level + 0.26), "{level}");
        }
    }

    #[test]
    fn what_flickers_takes_the_values_of_both_sides_and_no_others() {
        let jump = 2.0;
        // Up to an eighth of the jump off.
        let [low, high] = [[5.0, 7.2, 4.8, 5.0], [7.0, 7.0, 5.2, 6.8]];
        assert!(flickers(jump, [&low, &high]));
        assert!(flickers(-jump, [&high, &low]));
        for other in [3.0, 5.3, 6.0, 9.0] {
            assert!(!flickers(jump, [&[5.0, 7.0, other], &high]), "{other}");
            let other = 12.0 - other;
            assert!(!flickers(jump, [&low, &[7.0, 5.0, other]]), "{other}");
        }
    }
}
