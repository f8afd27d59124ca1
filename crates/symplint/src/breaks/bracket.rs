//! Bisection of a jump, and how a jump is told from noise and from a steep stretch.

use super::limits::{
    AROUND_A_ZONE, LOOKS, NARROWEST, NOISES_OF_A_JUMP, PATIENCE, SPACING, STAYS_ON_HALVING,
};

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

/// What is known of a bracket after it was halved.
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
        1 + ((self.high - self.low) / NARROWEST).log2().ceil().max(0.0) as usize
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
        if self.halvings > PATIENCE && self.is_little(difference) {
            Progress::Continuous
        } else if self.is_narrow() {
            Progress::Jump
        } else {
            Progress::Open
        }
    }

    /// Whether so little is left of the difference of both ends that it is no jump. Counted modulo a period, that
    /// happens to wraps.
    pub fn is_little(&self, difference: f64) -> bool {
        difference.abs() < STAYS_ON_HALVING * self.expected
    }

    /// Whether it can no longer be halved.
    pub fn is_narrow(&self) -> bool {
        let middle = self.middle();
        self.high - self.low <= NARROWEST || middle <= self.low || middle >= self.high
    }

    /// Parameters of the states beside the bracket that tell a jump from noise, on its `end`, from there outwards;
    /// the first is the end itself.
    pub fn beside(&self, end: End, look: usize) -> impl Iterator<Item = f64> + use<> {
        let (from, outwards) = match end {
            End::Low => (self.low, -SPACING),
            End::High => (self.high, SPACING),
        };
        (0..LOOKS[look]).map(move |k| from + k as f64 * outwards)
    }

    /// Parameters of states at this `distance` from each other, from its `end` outwards; the first is the end itself.
    pub fn around(&self, end: End, distance: f64) -> impl Iterator<Item = f64> + use<> {
        let (from, outwards) = match end {
            End::Low => (self.low, -distance),
            End::High => (self.high, distance),
        };
        (0..AROUND_A_ZONE).map(move |k| from + k as f64 * outwards)
    }

    /// Whether a `jump` stands out of the values beside the bracket, each side from its end outwards: of their
    /// noise, and of what their slope makes of the width of the bracket.
    pub fn stands_out(&self, jump: f64, sides: [&[f64]; 2]) -> bool {
        let steps = sides.iter().flat_map(|side| side.windows(2));
        let steepest = steps.fold(0.0, |m: f64, x| m.max((x[1] - x[0]).abs()));
        let climb = steepest * (self.high - self.low) / SPACING;
        jump > NOISES_OF_A_JUMP * scatter(sides).max(climb)
    }
}

/// Whether the values on the sides of a `jump`, each side from its end outwards, are those before the jump and those
/// after it, and no others: rounding decides on which side of a threshold a state is, such as the tolerance at which a
/// solver stops. Noise has any values.
pub(crate) fn flickers(jump: f64, sides: [&[f64]; 2]) -> bool {
    let little = jump.abs() / NOISES_OF_A_JUMP;
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
    jump.abs() > NOISES_OF_A_JUMP * largest
}

/// How far the values on the sides of a jump scatter, on the side where they do so more.
///
/// Second differences of a straight line vanish; those of noise are larger than it. Noise fills a side; a
/// second jump close by spoils two of its four differences at most, and the second smallest counts. At the
/// first look there is one alone.
pub(crate) fn scatter(sides: [&[f64]; 2]) -> f64 {
    let of_side = |side: &[f64]| {
        let mut bends: Vec<f64> = (side.windows(3))
            .map(|x| (x[0] - 2.0 * x[1] + x[2]).abs())
            .collect();
        bends.sort_by(f64::total_cmp);
        bends[usize::from(bends.len() > 1)]
    };
    of_side(sides[0]).max(of_side(sides[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_stands_out_of_what_the_slope_makes_of_the_width() {
        // Four spacings wide, beside a line that climbs by one in each.
        let bracket = Bracket::new([0.25, 0.25 + 4.0 * SPACING], 1.0);
        let line = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        assert!(!bracket.stands_out(NOISES_OF_A_JUMP * 4.0 - 0.1, [&line, &line]));
        assert!(bracket.stands_out(NOISES_OF_A_JUMP * 4.0 + 0.1, [&line, &line]));
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
