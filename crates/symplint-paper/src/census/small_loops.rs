//! Defects against step sizes, by several small loops at once.

use symplint::{Defect, Ensemble, LoopIntegral, Rule};

use super::schemes::Scheme;
use crate::error::PaperError;

/// The largest advances plasma oscillations by 0.4 rad.
pub const STEP_SIZES: [f64; 5] = [0.4, 0.2, 0.1, 0.05, 0.025];

/// Defects of small loops, which break nowhere unless a particle passes a node on them.
///
/// The defect of one loop may pass through 0 as h changes. Those of several together fall as their order says.
#[derive(Clone, Debug)]
pub struct SmallLoops {
    /// The root mean square of |E| against h.
    pub defects: Vec<(f64, f64)>,
    /// The largest of how far off any may be.
    pub uncertainties: Vec<(f64, f64)>,
}

impl SmallLoops {
    /// Measures them at every step size.
    pub fn of(scheme: &Scheme) -> Result<Self, PaperError> {
        const SAMPLES: usize = 512;
        let coordinates = scheme.map.capabilities().coordinates;
        let integral = |ensemble: &Ensemble| {
            LoopIntegral::in_coordinates(ensemble, &Rule::Pseudospectral, &coordinates)
        };
        let mut squares = [0.0; STEP_SIZES.len()];
        let mut uncertainties = STEP_SIZES.map(|h| (h, 0.0f64));
        for phase_loop in &scheme.small_loops {
            let start = Ensemble::sample(phase_loop, SAMPLES)?;
            let before = integral(&start)?;
            for (k, h) in STEP_SIZES.into_iter().enumerate() {
                let mut ensemble = start.clone();
                ensemble.advance(&*scheme.map, h)?;
                let defect = Defect::between(&before, &integral(&ensemble)?)?;
                squares[k] += defect.signed.powi(2);
                let quadrature = defect.quadrature_error.unwrap_or(f64::NAN);
                uncertainties[k].1 = uncertainties[k].1.max(quadrature + defect.roundoff);
            }
        }
        let count = scheme.small_loops.len() as f64;
        let mean = |square: f64| (square / count).sqrt();
        Ok(SmallLoops {
            defects: STEP_SIZES.into_iter().zip(squares.map(mean)).collect(),
            uncertainties: uncertainties.to_vec(),
        })
    }

    /// The slope of log |E| between the two smallest step sizes.
    pub fn slope(&self) -> f64 {
        let [.., (coarse, at_coarse), (fine, at_fine)] = self.defects[..] else {
            return f64::NAN;
        };
        (at_coarse / at_fine).ln() / (coarse / fine).ln()
    }
}
