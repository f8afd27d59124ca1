//! Where positions cross the lines of a grid.
//!
//! A map that interpolates on a grid breaks or bends a loop where a position crosses from one cell to the next. The
//! positions that a substep meets are smooth long before the states after the step are, so where they cross is known
//! from the states of a piece. These are guesses: a wrong one costs a few
//! evaluations. Without them, the recorded maps on grids take 2 to 18 % more evaluations, a force that is linear in each cell has 11.1
//! digits instead of 11.9, and the loop of momentum-first Lagrange shapes of degree 3 is not closed (truth table).

use super::examine::View;
use super::limits::{MAX_CROSSINGS, REACH_AROUND_CUT};
use super::lobatto::{LOBATTO, evaluate};

impl View<'_> {
    /// Parameters on both sides of where a position crosses a line of the grid, rising; none where there are more
    /// than a few, or the piece is about one already.
    pub fn around_crossings(&self) -> Vec<f64> {
        let spacing = self.coordinates.grid_spacing();
        let mut found = Vec::new();
        if spacing <= 0.0 || self.piece.length() <= 4.0 * REACH_AROUND_CUT {
            return found;
        }
        let (dof, stages) = (self.coordinates.dof(), self.piece.image(0).stages());
        for stage in (0..stages - 1).filter(|&stage| self.kicks(stage)) {
            let states = self.stage(stage);
            for i in 0..dof {
                let fit = self.fit(&states.values(i));
                if fit.off > self.allowed(i, &fit) {
                    continue;
                }
                for ((&from, &to), x) in
                    (fit.values.iter().zip(&fit.values[1..])).zip(LOBATTO.nodes.windows(2))
                {
                    let [low, high] = [from.min(to), from.max(to)].map(|q| (q / spacing).floor());
                    if high - low > MAX_CROSSINGS as f64 {
                        return Vec::new();
                    }
                    for line in 1..=(high - low) as usize {
                        let value = (low + line as f64) * spacing;
                        let before =
                            |x: f64| (evaluate(&fit.coefficients, x) < value) == (from < to);
                        found.push(self.piece.s(bisect([x[0], x[1]], before)));
                    }
                }
            }
        }
        found.sort_by(f64::total_cmp);
        found.dedup_by(|next, last| *next - *last < REACH_AROUND_CUT);
        if found.len() > MAX_CROSSINGS {
            return Vec::new();
        }
        found
            .iter()
            .flat_map(|s| [s - REACH_AROUND_CUT, s + REACH_AROUND_CUT])
            .collect()
    }

    /// Whether a substep changes momenta: one that does not has no force.
    fn kicks(&self, stage: usize) -> bool {
        let dof = self.coordinates.dof();
        let mut known = self.piece.images.iter().flatten();
        known.any(|image| image.stage(stage)[dof..] != image.stage(stage + 1)[dof..])
    }
}

/// The place at which a predicate that holds on the left fails.
fn bisect([mut low, mut high]: [f64; 2], holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
