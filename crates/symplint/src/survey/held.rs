//! Whether a step sets a coordinate to one value, as a clip does.

use crate::error::Error;
use crate::evidence::HeldCoordinate;
use crate::map::{LoopSize, states_at};
use crate::rules::Subject;
use crate::signal::parameter;
use crate::state::{Ensemble, coordinate, coordinate_mut};

/// Neighbouring samples with the same result, at least. A smooth function takes a value at two neighbours at most.
const MIN_EQUAL_NEIGHBOURS: usize = 3;

/// States near the loop that confirm a value, and how far they are from it, in sizes of the loop. Conventional.
const CONFIRMING_STATES: usize = 2;
const CONFIRMING_DISTANCE: f64 = 1e-3;

/// The longest runs of neighbouring samples that have the same value of a coordinate after the step, to the last bit, though both
/// coordinates of the degree of freedom differ before it.
pub(super) struct ConstantRuns {
    runs: Vec<[Run; 2]>,
}

#[derive(Clone, Copy, Default)]
struct Run {
    /// The position and the momentum of the first sample and of the last one before the step, and the value after it.
    ends: Option<[[f64; 3]; 2]>,
    samples: usize,
    /// Of the first run, and of the last one.
    first: usize,
    length: usize,
    longest: usize,
    /// The first sample of the longest run, and its value.
    start: usize,
    value: f64,
}

/// Whether neighbours have one value after the step, and differ before it.
fn are_held(a: [f64; 3], b: [f64; 3]) -> bool {
    a[0] != b[0] && a[1] != b[1] && a[2] == b[2]
}

impl Run {
    fn add(&mut self, sample: [f64; 3]) {
        let goes_on = self.ends.is_some_and(|[_, last]| are_held(last, sample));
        self.length = if goes_on { self.length + 1 } else { 1 };
        self.samples += 1;
        if self.length == self.samples {
            self.first = self.length;
        }
        self.ends = Some([self.ends.map_or(sample, |[first, _]| first), sample]);
        self.keep(self.length, self.samples - self.length, sample[2]);
    }

    fn keep(&mut self, length: usize, start: usize, value: f64) {
        if length > self.longest {
            (self.longest, self.start, self.value) = (length, start, value);
        }
    }

    /// The same with the run that goes round the end of the loop.
    fn closed(mut self) -> Self {
        if let Some([first, last]) = self.ends
            && self.length < self.samples
            && are_held(last, first)
        {
            self.keep(
                self.length + self.first,
                self.samples - self.length,
                last[2],
            );
        }
        self
    }
}

impl ConstantRuns {
    /// No samples yet.
    pub fn new(dof: usize) -> Self {
        ConstantRuns {
            runs: vec![[Run::default(); 2]; dof],
        }
    }

    /// Takes in samples before and after the step, in the order of the loop.
    pub fn add(&mut self, before: &Ensemble, after: &Ensemble) {
        for (i, runs) in self.runs.iter_mut().enumerate() {
            let [q, p] = [before.q().row(i), before.p().row(i)];
            for (run, row) in runs.iter_mut().zip([after.q().row(i), after.p().row(i)]) {
                (row.iter().zip(q).zip(p)).for_each(|((value, q), p)| run.add([*q, *p, *value]));
            }
        }
    }

    /// The coordinate with the longest run. One that has the same value at all samples does not count: a step that projects sets it.
    pub fn value(&self) -> Option<HeldCoordinate> {
        let all = self.runs.iter().enumerate();
        let found = all.flat_map(|(dof, [q, p])| [(dof, 'q', q), (dof, 'p', p)]);
        let (dof, coordinate, run) = found
            .map(|(dof, coordinate, run)| (dof, coordinate, run.closed()))
            .filter(|(.., run)| (MIN_EQUAL_NEIGHBOURS..run.samples).contains(&run.longest))
            .max_by_key(|(.., run)| run.longest)?;
        let samples = run.samples as f64;
        let middle = run.start as f64 + 0.5 * (run.longest - 1) as f64;
        Some(HeldCoordinate {
            coordinate,
            dof,
            // Not −0.
            value: run.value + 0.0,
            part: run.longest as f64 / samples,
            s: (middle / samples).rem_euclid(1.0),
        })
    }
}

/// Whether a coordinate has its value also at states near the loop: on an edge of a polygon, a smooth map can have one value, too.
///
/// # Errors
/// Those of the map.
pub(crate) fn is_set(
    subject: Subject<'_>,
    size: &LoopSize,
    h: f64,
    held: &HeldCoordinate,
) -> Result<bool, Error> {
    let dof = subject.dof();
    let mut states = states_at(subject.phase_loop, &[held.s; CONFIRMING_STATES]);
    let mut block = states.block();
    for c in 0..2 * dof {
        // In another direction for each coordinate, and for each state.
        for (k, value) in coordinate_mut(&mut block, c).iter_mut().enumerate() {
            *value += CONFIRMING_DISTANCE
                * size.radius[c / dof][c % dof]
                * (2.0 * parameter(2 * c + k) - 1.0);
        }
    }
    subject.evaluator.advance(&mut states, h)?;
    let c = if held.coordinate == 'q' {
        held.dof
    } else {
        dof + held.dof
    };
    Ok(coordinate(&states, c)
        .iter()
        .all(|value| *value == held.value))
}
