//! Periodic momenta, unwrapped along the loop.

use crate::signal::nearest;
use crate::state::{Coordinates, Ensemble};

/// Momenta that are periodic, unwrapped at equispaced samples of the advanced loop: a momentum anywhere is taken in the
/// period in which it is nearest to the line between its neighbouring samples. Empty where none is periodic.
#[derive(Default)]
pub(super) struct Lift {
    momenta: Vec<Momentum>,
    /// Degrees of freedom in all.
    dof: usize,
    /// Whether it winds, so that ∮ p·dq has no value.
    pub winds: bool,
}

struct Momentum {
    dof: usize,
    period: f64,
    row: Vec<f64>,
}

impl Lift {
    /// That of samples of the advanced loop.
    pub fn new(samples: &Ensemble, coordinates: &Coordinates) -> Self {
        if !coordinates.has_momentum_periods() {
            return Lift::default();
        }
        let (unwrapped, winding) = samples.unwrap_momenta(coordinates);
        let periodic = (0..samples.dof()).filter(|&dof| coordinates.momentum_period(dof) > 0.0);
        Lift {
            momenta: periodic
                .map(|dof| Momentum {
                    dof,
                    period: coordinates.momentum_period(dof),
                    row: unwrapped.p().row(dof).to_vec(),
                })
                .collect(),
            dof: samples.dof(),
            winds: !winding.is_empty(),
        }
    }

    /// Unwraps the momenta of one of `states`: that at `s` of the loop, or of a segment whose `ends` are unwrapped.
    pub fn unwrap(&self, states: &mut Ensemble, sample: usize, s: f64, ends: Option<[&[f64]; 2]>) {
        for Momentum { dof, period, row } in &self.momenta {
            let [from, to, part] = match ends {
                Some([low, high]) => [low[self.dof + dof], high[self.dof + dof], s],
                None => {
                    let position = s.rem_euclid(1.0) * row.len() as f64;
                    let k = position.floor();
                    let at = |k: f64| row[k as usize % row.len()];
                    [at(k), at(k + 1.0), position - k]
                }
            };
            let to = from + nearest(to - from, *period);
            let expected = from + part * (to - from);
            let mut block = states.block();
            let momentum = &mut block.p.row_mut(*dof)[sample];
            *momentum = expected + nearest(*momentum - expected, *period);
        }
    }
}
