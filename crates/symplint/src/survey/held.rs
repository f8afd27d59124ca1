//! Whether a step sets a coordinate to one value, as a clip does.

use crate::evidence::HeldCoordinate;
use crate::state::Ensemble;

/// Neighbouring samples with the same result, at least. A smooth function takes a value at two neighbours at most.
const FEWEST: usize = 3;

/// The longest runs of neighbouring samples that have the same value of a coordinate after the step, to the last bit, though both
/// coordinates of the degree of freedom differ before it.
pub(super) struct Held {
    runs: Vec<[Run; 2]>,
    samples: usize,
}

#[derive(Clone, Copy, Default)]
struct Run {
    /// The position and the momentum of the last sample before the step, and the value after it.
    last: Option<[f64; 3]>,
    length: usize,
    longest: usize,
    value: f64,
}

impl Run {
    fn add(&mut self, [q, p, value]: [f64; 3]) {
        let goes_on =
            (self.last).is_some_and(|last| last[0] != q && last[1] != p && last[2] == value);
        self.length = if goes_on { self.length + 1 } else { 1 };
        self.last = Some([q, p, value]);
        if self.length > self.longest {
            (self.longest, self.value) = (self.length, value);
        }
    }
}

impl Held {
    /// No samples yet.
    pub fn new(dof: usize) -> Self {
        Held {
            runs: vec![[Run::default(); 2]; dof],
            samples: 0,
        }
    }

    /// Takes in samples before and after the step, in the order of the loop.
    pub fn add(&mut self, before: &Ensemble, after: &Ensemble) {
        self.samples += before.samples();
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
            .filter(|(.., run)| (FEWEST..self.samples).contains(&run.longest))
            .max_by_key(|(.., run)| run.longest)?;
        Some(HeldCoordinate {
            coordinate,
            dof,
            value: run.value,
            part: run.longest as f64 / self.samples as f64,
        })
    }
}
