//! The cost of a Jacobian test, and the best one that a budget allows.

use super::constants::CONSTANTS;
use super::{JacobianTest, richardson};
use crate::signal::noise::NODES_BESIDE;

/// This number of points is preferred to more tangent vectors at one point.
const PREFERRED_POINTS: usize = 2;

impl JacobianTest {
    /// Evaluations that the test makes of a map in `dof` degrees of freedom, with a tangent map or without: at
    /// each point 13, and 12 for each tangent vector; with a tangent map 25, and 7 for each tangent vector.
    ///
    /// More are made within the [`budget`](Self::budget) where a map needs them: up to 36 at a point where the
    /// output of the map is coarse, as in single precision; 6 for a derivative that converges slowly; all
    /// differences once the tangent map is found to be wrong; and, for a defect of random tangent vectors,
    /// up to 2 log₂ d + 4 derivatives that trace it to two degrees of freedom.
    ///
    /// ```
    /// use symplint::JacobianTest;
    ///
    /// let test = JacobianTest::within(100, 1, false).unwrap();
    /// assert_eq!(test.points, 2);
    /// assert_eq!(test.evaluations(1, false), 2 * (13 + 12 * 2));
    /// ```
    pub fn evaluations(&self, dof: usize, has_tangent: bool) -> usize {
        let directions = self.count(dof);
        let of_derivatives = match has_tangent {
            true => richardson::FIRST_STATES + CONSTANTS.trials * directions,
            false => richardson::FIRST_STATES * directions,
        };
        self.points * (1 + NODES_BESIDE.len() + of_derivatives)
    }

    /// The best test that makes `budget` evaluations at most, and no better one than by default: first two points,
    /// then more tangent vectors, up to all unit vectors, then more points. `None` where not one pair of
    /// tangent vectors at one point is within the budget.
    pub fn within(budget: usize, dof: usize, has_tangent: bool) -> Option<Self> {
        let default = JacobianTest::default();
        let full = (dof <= default.full_up_to).then_some(default);
        let random = (2..=default.directions)
            .rev()
            .filter(|directions| *directions < 2 * dof)
            .map(|directions| JacobianTest {
                full_up_to: 0,
                directions,
                ..default
            });
        let candidates = || full.into_iter().chain(random.clone());
        let with_points = |least: usize| {
            move |test: JacobianTest| {
                let of_point = JacobianTest { points: 1, ..test }.evaluations(dof, has_tangent);
                let points = (budget / of_point).min(default.points);
                (points >= least).then_some(JacobianTest {
                    points,
                    budget,
                    ..test
                })
            }
        };
        (candidates().find_map(with_points(PREFERRED_POINTS)))
            .or_else(|| candidates().find_map(with_points(1)))
    }
}
