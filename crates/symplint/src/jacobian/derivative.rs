//! The derivative of a step along a tangent vector, with its error.

/// In units of the [frame](super::frame::Frame), positions first.
#[derive(Clone)]
pub(super) struct Derivative {
    pub value: Vec<f64>,
    /// Half the width of the interval in which each component lies: truncation and noise of differences,
    /// round-off of a tangent map.
    pub error: Vec<f64>,
    /// Whether the differences converged: if not, the map is not differentiable on the scale of their distances.
    /// With a tangent map, whether the last digit of the state leaves it as it is.
    pub converged: bool,
    /// The same derivative from other trials of a tangent map; differences have none.
    pub trials: Vec<Vec<f64>>,
}

impl Derivative {
    /// The largest component, but at least 1: errors are relative to it.
    pub fn largest(&self) -> f64 {
        largest(&self.value).max(1.0)
    }

    /// The same along a multiple of the vector, so that the largest component is 1.
    pub fn to_unit_size(&self) -> Derivative {
        Derivative::combined(&[(1.0 / largest(&self.value), self)])
    }

    /// The largest error of a component.
    pub fn largest_error(&self) -> f64 {
        largest(&self.error)
    }

    /// Σ a D: the derivative along Σ a u, as the derivative is linear.
    pub fn combined(terms: &[(f64, &Derivative)]) -> Derivative {
        let sum = |component: &dyn Fn(f64, &Derivative) -> f64| -> f64 {
            terms.iter().map(|&(a, term)| component(a, term)).sum()
        };
        let coordinates = 0..terms[0].1.value.len();
        let trials = 0..terms[0].1.trials.len();
        Derivative {
            value: (coordinates.clone())
                .map(|c| sum(&|a, term| a * term.value[c]))
                .collect(),
            error: (coordinates.clone())
                .map(|c| sum(&|a, term| a.abs() * term.error[c]))
                .collect(),
            converged: terms.iter().all(|(_, term)| term.converged),
            trials: trials
                .map(|trial| {
                    let component = |c| sum(&|a, term: &Derivative| a * term.trials[trial][c]);
                    coordinates.clone().map(component).collect()
                })
                .collect(),
        }
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, x| most.max(x.abs()))
}
