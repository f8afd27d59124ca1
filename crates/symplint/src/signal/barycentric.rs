//! The polynomial through a few points, whatever their distances.

/// Lagrange interpolation in barycentric form (Berrut & Trefethen, SIAM Review 46, 2004).
#[derive(Clone, Debug)]
pub(crate) struct Barycentric {
    nodes: Vec<f64>,
    weights: Vec<f64>,
}

impl Barycentric {
    /// At different nodes.
    pub fn at(nodes: Vec<f64>) -> Self {
        // Distances count from the whole of them, so that products neither vanish nor overflow.
        let length = super::Extent::of(&nodes).length().max(f64::MIN_POSITIVE);
        let weight = |k: usize| {
            let others = (0..nodes.len()).filter(|&j| j != k);
            1.0 / others
                .map(|j| (nodes[k] - nodes[j]) / length)
                .product::<f64>()
        };
        Barycentric {
            weights: (0..nodes.len()).map(weight).collect(),
            nodes,
        }
    }

    /// The highest divided difference of some values, up to a factor that depends on the nodes alone.
    pub fn divided_difference(&self, values: &[f64]) -> f64 {
        self.weights.iter().zip(values).map(|(w, v)| w * v).sum()
    }

    /// The polynomial through some values, at `x`.
    pub fn evaluate(&self, values: &[f64], x: f64) -> f64 {
        self.basis(x).iter().zip(values).map(|(w, v)| w * v).sum()
    }

    /// The weights of the values at the nodes in the value of the polynomial at `x`.
    pub fn basis(&self, x: f64) -> Vec<f64> {
        if self.nodes.contains(&x) {
            let at = |node: &f64| if *node == x { 1.0 } else { 0.0 };
            return self.nodes.iter().map(at).collect();
        }
        let parts = self.nodes.iter().zip(&self.weights);
        let mut parts: Vec<f64> = parts.map(|(node, weight)| weight / (x - node)).collect();
        let sum: f64 = parts.iter().sum();
        parts.iter_mut().for_each(|part| *part /= sum);
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_met_between_their_points_and_beyond() {
        let f = |x: f64| 1.0 - x + 3.0 * x.powi(3);
        for scale in [1.0, 1e-12] {
            let nodes = [0.2, 0.21, 0.22, 0.27].map(|x| scale * x).to_vec();
            let values: Vec<f64> = nodes.iter().map(|x| f(x / scale)).collect();
            let polynomial = Barycentric::at(nodes);
            for x in [0.2, 0.205, 0.25, 0.3] {
                let got = polynomial.evaluate(&values, scale * x);
                assert!((got - f(x)).abs() < 1e-11, "{x}: {got}");
            }
        }
        assert_eq!(Barycentric::at(vec![0.5]).evaluate(&[1.0], 0.7), 1.0);
    }

    #[test]
    fn divided_differences_annul_lower_powers() {
        let nodes = vec![0.0, 0.1, 0.5, 2.0];
        let difference = Barycentric::at(nodes.clone());
        let of = |power: i32| {
            let values: Vec<f64> = nodes.iter().map(|x| x.powi(power)).collect();
            difference.divided_difference(&values)
        };
        assert!((0..3).all(|power| of(power).abs() < 1e-12));
        assert!(of(3).abs() > 1.0);
    }
}
