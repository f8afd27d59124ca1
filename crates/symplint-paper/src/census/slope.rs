//! The order of a defect, by many loops at once.

use symplint::{Defect, Ensemble, LoopIntegral, Rule};

use super::schemes::Scheme;
use crate::PaperError;

/// Defects of one loop may pass through 0 as h changes. Those of all small loops together fall as their order says.
pub fn slope(scheme: &Scheme) -> Result<f64, PaperError> {
    const SAMPLES: usize = 512;
    /// Well below the time of a plasma oscillation, and well above where defects are lost in rounding.
    const STEP_SIZES: [f64; 2] = [0.1, 0.05];
    let coordinates = scheme.map.coordinates();
    let integral = |ensemble: &Ensemble| {
        LoopIntegral::in_coordinates(ensemble, &Rule::Pseudospectral, &coordinates)
    };
    let mut squares = [0.0; 2];
    for phase_loop in &scheme.small_loops {
        let start = Ensemble::sample(phase_loop, SAMPLES)?;
        let before = integral(&start)?;
        for (square, h) in squares.iter_mut().zip(STEP_SIZES) {
            let mut ensemble = start.clone();
            ensemble.advance(&*scheme.map, h)?;
            *square += Defect::between(&before, &integral(&ensemble)?)?
                .signed
                .powi(2);
        }
    }
    Ok(0.5 * (squares[0] / squares[1]).ln() / (STEP_SIZES[0] / STEP_SIZES[1]).ln())
}
