//! Periodic momenta, unwrapped along the loop.

use crate::signal::nearest;
use crate::state::{Block, Coordinates, Ensemble};

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

    /// Unwraps the momenta of a state of a block: that at `s` of the loop, or of a segment whose `ends` are unwrapped.
    pub fn unwrap(&self, block: &mut Block<'_>, sample: usize, s: f64, ends: Option<[&[f64]; 2]>) {
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
            let momentum = &mut block.p.row_mut(*dof)[sample];
            *momentum = expected + nearest(*momentum - expected, *period);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two degrees of freedom; the second momentum has period 2 and climbs through it.
    fn samples() -> (Ensemble, Coordinates) {
        let coordinates = Coordinates::plain(2).with_momentum_periods(vec![0.0, 2.0]);
        let mut samples = Ensemble::zeros(2, 8);
        let mut block = samples.block();
        for k in 0..8 {
            // Up by 0.9 a sample and down again; kept in [0, 2).
            let climbed = 1.5 + 0.9 * (4 - (k as i32 - 4).abs()) as f64;
            block.p.row_mut(1)[k] = climbed % 2.0;
            block.p.row_mut(0)[k] = 7.0;
        }
        (samples, coordinates.unwrap())
    }

    #[test]
    fn a_momentum_on_the_loop_is_taken_in_the_period_of_its_neighbours() {
        let (samples, coordinates) = samples();
        let lift = Lift::new(&samples, &coordinates);
        assert!(!lift.winds);
        // Half-way between samples 2 and 3, and 7 and 0: less than half a period off the line between them.
        for (s, line) in [(2.5 / 8.0, 3.75), (7.5 / 8.0, 1.95), (-0.5 / 8.0, 1.95)] {
            for (off, periods) in [(0.6, -2.0), (-0.6, 0.0), (-0.6, 4.0), (0.6, 4.0)] {
                let expected = line + off;
                let mut states = Ensemble::zeros(2, 2);
                states.block().p.row_mut(1)[1] = expected + periods;
                states.block().p.row_mut(0)[1] = 9.0;
                lift.unwrap(&mut states.block(), 1, s, None);
                assert!((states.p().row(1)[1] - expected).abs() < 1e-14);
                // One without a period, and another sample, stay.
                assert_eq!(states.p().row(0)[1], 9.0);
                assert_eq!(states.p().row(1)[0], 0.0);
            }
        }
    }

    #[test]
    fn a_momentum_on_a_segment_is_taken_between_its_ends() {
        let (samples, coordinates) = samples();
        let lift = Lift::new(&samples, &coordinates);
        let ends: [&[f64]; 2] = [&[0.0, 0.0, 0.0, 10.0], &[0.0, 0.0, 0.0, 10.8]];
        for (part, expected) in [(0.0, 10.0), (0.25, 10.2), (1.0, 10.8)] {
            let mut states = Ensemble::zeros(2, 1);
            states.block().p.row_mut(1)[0] = expected - 8.0;
            lift.unwrap(&mut states.block(), 0, part, Some(ends));
            assert!((states.p().row(1)[0] - expected).abs() < 1e-14);
        }
    }
}
