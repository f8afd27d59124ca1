//! The polynomial through a few points, whatever their distances.

use super::lobatto::{LOBATTO, Values};

/// A polynomial in barycentric form.
pub(super) struct Path {
    /// Each with its parameter, its value and its weight.
    points: Vec<(f64, f64, f64)>,
}

impl Path {
    /// Through points of different parameters.
    pub fn through(points: Vec<(f64, f64)>) -> Self {
        // Distances count from the whole of them, so that products neither vanish nor overflow.
        let ends = points.first().zip(points.last());
        let length = ends.map_or(1.0, |(first, last)| {
            (last.0 - first.0).abs().max(f64::MIN_POSITIVE)
        });
        let weight = |at: usize| {
            let others = points.iter().enumerate().filter(|(k, _)| *k != at);
            let apart = others.map(|(_, other)| (points[at].0 - other.0) / length);
            1.0 / apart.product::<f64>()
        };
        let points = (points.iter().enumerate())
            .map(|(k, &(s, value))| (s, value, weight(k)))
            .collect();
        Path { points }
    }

    /// Its value.
    pub fn at(&self, s: f64) -> f64 {
        let (mut above, mut below) = (0.0, 0.0);
        for &(at, value, weight) in &self.points {
            if s == at {
                return value;
            }
            above += weight * value / (s - at);
            below += weight / (s - at);
        }
        above / below
    }

    /// Its values at the nodes of a piece.
    pub fn values(&self, [a, b]: [f64; 2]) -> Values {
        LOBATTO
            .nodes
            .map(|x| self.at(a + 0.5 * (1.0 + x) * (b - a)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_goes_on_beyond_its_points_and_between_them() {
        let f = |s: f64| 1.0 - s + 3.0 * s.powi(3);
        let points = [0.2, 0.21, 0.22, 0.27].map(|s| (s, f(s)));
        let path = Path::through(points.to_vec());
        for s in [0.2, 0.205, 0.25, 0.3] {
            assert!((path.at(s) - f(s)).abs() < 1e-12);
        }
        let straight = Path::through(vec![(0.5, 1.0)]);
        assert_eq!(straight.at(0.7), 1.0);
    }
}
