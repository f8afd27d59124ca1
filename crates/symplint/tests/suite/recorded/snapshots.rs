//! Loops that are known by their samples alone.

use symplint::snapshots::{Snapshot, measure_snapshots};
use symplint::{Ensemble, judge};

use crate::recorded::diagnoses::write;
use crate::recorded::maps::cases;
use crate::recorded::record::check;

#[test]
fn of_samples_alone() {
    let mut text = String::new();
    for case in cases() {
        for samples in [60, 500] {
            let before = Ensemble::sample(&*case.phase_loop, samples).unwrap();
            let after = [1.0, 0.5].map(|part| {
                let mut states = before.clone();
                states.advance(&*case.map, part * case.h).unwrap();
                Snapshot::new(states).after_step(part * case.h)
            });
            let coordinates = case.map.capabilities().coordinates;
            let heading = format!("{}, {samples} samples", case.name);
            match measure_snapshots(&Snapshot::new(before), &after, &coordinates) {
                Ok(evidence) => write(&mut text, &heading, &judge(&evidence), &evidence),
                Err(error) => text += &format!("== {heading}\n{error}\n"),
            }
        }
    }
    check("snapshots", &text);
}
