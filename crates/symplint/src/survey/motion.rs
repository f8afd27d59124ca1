//! How one step moves the samples of a loop against each other.

use crate::evidence::{MAX_ROUNDING_CHANGE, MIN_SAMPLES_OF_SHAPE, Motion};
use crate::signal::{Extent, MAX_RELATIVE_ROUNDING_INSIDE, Turns, UNIT_ROUNDOFF};
use crate::state::{Coordinates, Ensemble};

/// Changes of a coordinate that differ by no more than this many units in the last place of its values are the same.
const MAX_ROUNDINGS: f64 = 8.0;

/// The mean squared difference of neighbouring changes over their variance, at least, if they scatter as rounding does.
/// Derived: it is 2 for independent numbers (von Neumann, Ann. Math. Stat. 12, 1941), and (2πm/N)² for mode m of N samples.
const MIN_SCATTER: f64 = 1.0;

/// The motion of a loop, from its samples before and after a step.
pub(super) struct Motions {
    planes: Vec<Plane>,
    /// The root of the number of samples.
    root: f64,
}

impl Motions {
    /// No samples yet.
    pub fn new(dof: usize) -> Self {
        Motions {
            planes: vec![Plane::new(); dof],
            root: 0.0,
        }
    }

    /// Takes in samples before and after the step, in the order of the loop.
    pub fn add(&mut self, before: &Ensemble, after: &Ensemble, coordinates: &Coordinates) {
        let of_ones: Vec<(f64, f64)> = (0..before.samples())
            .map(|_| rotation(&mut self.root, 1.0))
            .collect();
        for (i, plane) in self.planes.iter_mut().enumerate() {
            plane.add(
                &of_ones,
                [before.q().row(i), before.p().row(i)],
                [after.q().row(i), after.p().row(i)],
                [coordinates.period(i), coordinates.momentum_period(i)],
            );
        }
    }

    /// The motion, if it is a number.
    pub fn value(&self, coordinates: &Coordinates) -> Option<Motion> {
        let count = self.root.powi(2);
        let deformation =
            (self.planes.iter()).fold(0.0, |most, plane| plane.deformation().max(most));
        let sum = |of: fn(&Plane) -> &Moments| -> f64 {
            let weighted = |(i, plane): (usize, &Plane)| {
                // Round a period p may be a function of q, and so are the changes of both.
                let area = match plane.winds(coordinates.period(i)) {
                    true => of(plane).widths(),
                    false => of(plane).emittance(),
                };
                coordinates.weight(i).abs() * area
            };
            self.planes.iter().enumerate().map(weighted).sum()
        };
        // Of a loop without an area, infinite or not a number.
        let squared = sum(|plane| &plane.of_changes) / sum(|plane| &plane.of_loop);
        let moves = self.planes.iter().any(Plane::moves);
        // What moves by rounding alone may be a step of any method.
        let is_known = self.planes.iter().any(Plane::is_known) || !moves;
        let motion = Motion {
            deformation,
            phase_advance: squared.sqrt(),
            imbalance: (self.planes.iter())
                .fold(0.0, |most, plane| plane.imbalance(count).max(most)),
            shear: is_known && self.planes.iter().all(|plane| plane.is_sheared(count)),
            moves,
        };
        (motion.deformation.is_finite() && motion.phase_advance.is_finite()).then_some(motion)
    }
}

/// The motion in one degree of freedom.
#[derive(Clone)]
struct Plane {
    of_loop: Moments,
    of_changes: Moments,
    /// The first position; infinite before there is one.
    first: f64,
    /// Of q and p.
    turns_before: [Turns; 2],
    turns: [Turns; 2],
    /// The sums of the squared differences of neighbouring changes of q and p.
    differences: [f64; 2],
}

impl Plane {
    fn new() -> Self {
        Plane {
            of_loop: Moments::default(),
            of_changes: Moments::default(),
            first: f64::INFINITY,
            turns_before: Default::default(),
            turns: Default::default(),
            differences: [0.0; 2],
        }
    }

    /// Takes in samples. `of_ones` are the rotations that take the ones of their rows into the triangles.
    fn add(
        &mut self,
        of_ones: &[(f64, f64)],
        before: [&[f64]; 2],
        after: [&[f64]; 2],
        periods: [f64; 2],
    ) {
        if let (f64::INFINITY, Some(&first)) = (self.first, before[0].first()) {
            self.first = first;
        }
        for (k, &of_one) in of_ones.iter().enumerate() {
            let (mut state, mut change) = ([0.0; 2], [0.0; 2]);
            for c in 0..2 {
                let [old, new] = [before[c][k], after[c][k]];
                state[c] = self.turns_before[c].unwrap(old, periods[c]);
                let last = self.turns[c].last(periods[c]);
                change[c] = self.turns[c].unwrap(new - old, periods[c]);
                self.differences[c] += last.map_or(0.0, |last| (change[c] - last).powi(2));
            }
            self.of_loop.add(of_one, state);
            self.of_changes.add(of_one, change);
        }
    }

    fn winds(&self, period: f64) -> bool {
        let mut turns = self.turns_before[0];
        turns.unwrap(self.first, period);
        turns.turns != 0.0
    }

    /// The range of the changes of q and of p, over the range of each on the loop.
    fn relative_changes(&self) -> [f64; 2] {
        [0, 1].map(|c| {
            let size = self.of_loop.extents[c].length();
            match size > 0.0 {
                true => self.of_changes.extents[c].length() / size,
                false => 0.0,
            }
        })
    }

    fn deformation(&self) -> f64 {
        let [q, p] = self.relative_changes();
        q.max(p)
    }

    /// See [`Motion::imbalance`]: 0 for a kick or a free flight alone.
    fn imbalance(&self, count: f64) -> f64 {
        let [q, p] = self.relative_changes();
        match self.is_sheared(count) || q == 0.0 || p == 0.0 {
            true => 0.0,
            false => (q / p).max(p / q).sqrt(),
        }
    }

    fn is_sheared(&self, count: f64) -> bool {
        (0..2).any(|c| self.keeps_shape(c) || self.is_rounding(c, count))
    }

    /// Whether a coordinate of all samples changes by the same, to rounding.
    fn keeps_shape(&self, c: usize) -> bool {
        self.of_changes.extents[c].length() <= MAX_ROUNDINGS * UNIT_ROUNDOFF * self.largest(c)
    }

    /// A bound on the values of a coordinate, before and after the step.
    fn largest(&self, c: usize) -> f64 {
        self.of_loop.extents[c].magnitude() + self.of_changes.extents[c].magnitude()
    }

    /// Whether the changes of a coordinate are small, and scatter from sample to sample.
    fn is_rounding(&self, c: usize, count: f64) -> bool {
        let [change, size] = [&self.of_changes, &self.of_loop].map(|of| of.extents[c].length());
        count >= MIN_SAMPLES_OF_SHAPE as f64
            && change <= MAX_RELATIVE_ROUNDING_INSIDE * size
            && self.differences[c] >= MIN_SCATTER * self.of_changes.squares(c)
    }

    /// Whether one coordinate changes by so much more than rounding that the change of the other would be seen: it deforms; or it
    /// moves while the other stays to the last bit; or neither deforms, though it moves so far that it would deform if its velocity
    /// doubled over the distance from the loop to the origin.
    fn is_known(&self) -> bool {
        (0..2).any(|c| {
            let [changes, other] = [c, 1 - c].map(|c| &self.of_changes.extents[c]);
            let (size, largest) = (self.of_loop.extents[c].length(), self.largest(c));
            let deforms = size > 0.0 && changes.length() >= MAX_RELATIVE_ROUNDING_INSIDE * size;
            let shift = changes.magnitude();
            let shifted = (0..2).all(|c| self.keeps_shape(c))
                && shift * size >= MAX_ROUNDING_CHANGE * largest.powi(2);
            deforms || shifted || other.magnitude() == 0.0 && shift >= MAX_ROUNDING_CHANGE * largest
        })
    }

    fn moves(&self) -> bool {
        (self.of_changes.extents.iter()).any(|changes| changes.magnitude() > 0.0)
    }
}

/// Ranges and second moments of two coordinates. There may be millions of them.
#[derive(Clone, Default)]
struct Moments {
    extents: [Extent; 2],
    /// The columns of the upper triangle R of a QR factorisation with rows (1, x, y): it keeps the digits that sums
    /// of squares would cancel. The first column, the root of the number of samples, is the same for all moments, and left out.
    triangle: ([f64; 2], [f64; 3]),
}

impl Moments {
    fn add(&mut self, of_one: (f64, f64), [x, y]: [f64; 2]) {
        self.extents[0].include(x);
        self.extents[1].include(y);
        // Rotates the entries of the row into the triangle one by one (Givens).
        let ([mean_x, x_x], [mean_y, x_y, y_y]) = &mut self.triangle;
        let x = rotate(of_one, mean_x, x);
        let y = rotate(of_one, mean_y, y);
        let turn = rotation(x_x, x);
        let y = rotate(turn, x_y, y);
        rotation(y_y, y);
    }

    /// The sum of the squared deviations of a coordinate from its mean.
    fn squares(&self, c: usize) -> f64 {
        let ([_, x], [_, xy, y]) = self.triangle;
        [x.powi(2), xy.powi(2) + y.powi(2)][c]
    }

    /// √(⟨x²⟩⟨y²⟩) of deviations from the mean, times the number of samples.
    fn widths(&self) -> f64 {
        let ([_, x], [_, xy, y]) = self.triangle;
        x.abs() * xy.hypot(y)
    }

    /// √(⟨x²⟩⟨y²⟩ − ⟨xy⟩²) of deviations from the mean (Lapostolle, IEEE Trans. Nucl. Sci. 18, 1971), times the
    /// number of samples.
    fn emittance(&self) -> f64 {
        let ([_, x], [_, _, y]) = self.triangle;
        (x * y).abs()
    }
}

/// The rotation (cos, sin) that takes `entry` into `above`, and takes it there.
fn rotation(above: &mut f64, entry: f64) -> (f64, f64) {
    let length = above.hypot(entry);
    let turn = match length > 0.0 {
        true => (*above / length, entry / length),
        false => (1.0, 0.0),
    };
    *above = length;
    turn
}

/// Rotates two entries of a column; returns the lower one.
fn rotate((cos, sin): (f64, f64), above: &mut f64, entry: f64) -> f64 {
    let lower = cos * entry - sin * *above;
    *above = cos * *above + sin * entry;
    lower
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One step of a loop of 64 samples, an ellipse of these half axes.
    fn motion(axes: [f64; 2], step: impl Fn(f64, f64) -> (f64, f64)) -> Motion {
        let (mut before, mut after) = (Ensemble::zeros(1, 64), Ensemble::zeros(1, 64));
        let (old, new) = (before.block(), after.block());
        let (mut old, mut new) = (old, new);
        for k in 0..64 {
            let (sin, cos) = (k as f64 * std::f64::consts::TAU / 64.0).sin_cos();
            let (q, p) = (axes[0] * (3.0 + sin), axes[1] * cos);
            let (next_q, next_p) = step(q, p);
            (old.q.row_mut(0)[k], old.p.row_mut(0)[k]) = (q, p);
            (new.q.row_mut(0)[k], new.p.row_mut(0)[k]) = (next_q, next_p);
        }
        let coordinates = Coordinates::plain(1);
        let mut motions = Motions::new(1);
        motions.add(&before, &after, &coordinates);
        motions.value(&coordinates).unwrap()
    }

    #[test]
    fn an_oscillation_is_advanced_by_its_angle_in_all_units() {
        for angle in [1e-3, 0.5, 2.0, 3.0] {
            for unit in [1e-9, 1.0, 1e6] {
                let (sin, cos) = f64::sin_cos(angle);
                let found = motion([0.3 * unit, 0.7 / unit], |q, p| {
                    let (q, p) = (q / unit, p * unit);
                    (unit * (cos * q + sin * p), (cos * p - sin * q) / unit)
                });
                let exact = 2.0 * (angle / 2.0).sin();
                assert!(
                    (found.phase_advance - exact).abs() < 1e-6 * exact,
                    "{found:?}"
                );
                assert!(!found.shear);
            }
        }
    }

    #[test]
    fn shears_and_translations_advance_nothing() {
        let flight = motion([1.0, 1.0], |q, p| (q + 0.5 * p, p));
        let kick = motion([1.0, 1.0], |q, p| (q, p - 3.0 * q.sin()));
        let falling = motion([1.0, 1.0], |q, p| (q + 0.5 * p, p - 9.81));
        let shifted = motion([1.0, 1.0], |q, p| (q + 8.0, p));
        for found in [flight, kick, falling, shifted] {
            assert!(found.shear && found.phase_advance < 1e-7, "{found:?}");
        }
        assert!((flight.deformation - 0.5).abs() < 1e-12);
        assert!(shifted.deformation < 1e-15);
        // A weak force added to a free flight is not a shear.
        let weak = motion([1.0, 1.0], |q, p| (q + 0.5 * p, p - 1e-6 * q));
        assert!(!weak.shear, "{weak:?}");
        assert!((weak.phase_advance - (0.5e-6f64).sqrt()).abs() < 1e-6);
        // Rotated, a shear is one in neither coordinate, and advances nothing all the same.
        let turned = motion([1.0, 1.0], |q, p| (q + 0.3 * (q + p), p - 0.3 * (q + p)));
        assert!(!turned.shear && turned.phase_advance < 1e-7, "{turned:?}");
    }

    /// A free flight whose momenta go through other units inside: rounding of numbers near 1 is left of them.
    #[test]
    fn rounding_inside_a_shear_makes_no_rotation_of_it() {
        for size in [1.0, 1e-3, 1e-6] {
            let found = motion([size, size], |q, p| (q + 0.5 * p, (1.0 + p) - 1.0));
            assert!(found.shear && found.moves, "{size}: {found:?}");
            // A force a hundred times as large does.
            let weak = motion([size, size], |q, p| {
                (q + 0.5 * p, (1.0 + p) - 1.0 - 1e-13 / size * q)
            });
            assert!(!weak.shear, "{size}: {weak:?}");
        }
        let at_rest = motion([1.0, 1.0], |q, p| (q, p));
        assert!(at_rest.shear && !at_rest.moves, "{at_rest:?}");
    }

    /// Of a step that is so small that the changes of both coordinates are rounding, nothing is known.
    #[test]
    fn a_step_below_rounding_is_no_shear() {
        for h in [1e-10, 1e-14, 1e-15, 1e-16, 1e-17] {
            let euler = motion([1.0, 0.5], |q, p| (q + h * p, p - h * q.sin()));
            assert!(!euler.shear, "{h}: {euler:?}");
        }
        // The loop is far from the origin, and moves far, compared with its size.
        let orbit = motion([1e-6, 1e-6], |q, p| {
            let (q, p) = (q + 7.0, p + 7.5);
            (q + 1e-9 * p - 7.0, p - 1e-9 / q.powi(2) - 7.5)
        });
        assert!(!orbit.shear, "{orbit:?}");
        for size in [1e-11, 1e-7] {
            let kick = motion([1.0, 1.0], |q, p| (q, p - size * q.sin()));
            let shift = motion([1.0, 1.0], |q, p| (q + size, p));
            assert!(kick.shear && shift.shear, "{size}: {kick:?}, {shift:?}");
        }
        for size in [1e-3, 1.0, 1e3] {
            let translation = motion([size, size], |q, p| (q + 0.1 * size, p - 0.01 * size));
            assert!(translation.shear, "{size}: {translation:?}");
        }
    }

    #[test]
    fn a_force_of_a_narrow_feature_counts() {
        let steep = |q: f64, p: f64| (q + 0.5 * p, p - 0.5 * ((q - 3.0) * 1e6).tanh());
        assert!(motion([1.0, 1.0], steep).phase_advance > 0.3);
    }
}
