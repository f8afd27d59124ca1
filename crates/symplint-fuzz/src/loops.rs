//! Loops that were read from files.

use symplint::{Coordinates, Snapshot, measure};
use symplint_files::LoopFile;

/// Compares a loop with itself, in the coordinates that the file names.
pub fn compare_with_itself(file: &LoopFile) {
    let dof = file.states.dof();
    let of_all = |values: &Option<Vec<f64>>| match values.as_deref() {
        Some([one]) => Some(vec![*one; dof]),
        Some(values) => Some(values.to_vec()),
        None => None,
    };
    let mut coordinates = Ok(Coordinates::plain(dof));
    if let Some(periods) = of_all(&file.period) {
        coordinates = coordinates.and_then(|known| known.with_periods(periods));
    }
    if let Some(periods) = of_all(&file.momentum_period) {
        coordinates = coordinates.and_then(|known| known.with_momentum_periods(periods));
    }
    if let Some(weights) = of_all(&file.weight) {
        coordinates = coordinates.and_then(|known| known.with_weights(weights));
    }
    let Ok(coordinates) = coordinates else {
        return;
    };
    let before = Snapshot::new(file.states.clone()).with_unit_roundoff(file.unit_roundoff);
    let mut after = before.clone();
    after.step_size = file.step_size;
    if let Err(error) = measure(&before, &[after], &coordinates) {
        let _ = error.to_string();
    }
}
