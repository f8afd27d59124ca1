//! Knowledge about a map that checks leave to later ones.

use std::sync::{Arc, PoisonError, RwLock};

use super::{Difference, Evaluator, Grain, SamplesBefore};
use crate::loops::Loop;
use crate::signal::{BITS_OF_SINGLE, MAX_ROUNDINGS_OF_SINGLE, nearest};
use crate::state::{Ensemble, period};

/// A part of a loop, after a step of size `h`, that its samples do not resolve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Feature {
    pub s: f64,
    pub h: f64,
}

/// Knowledge about a map, and about the present loop.
#[derive(Default)]
pub(super) struct Notes {
    /// The grain of the states that were returned of the present loop, once there are enough of them.
    grain: Note<Option<Arc<Grain>>>,
    /// The rounding of each coordinate inside the map, if it works in single precision there, or is noisy.
    inside: Note<Option<Arc<Vec<f64>>>>,
    /// The noise of each coordinate, if results of one state differ at random.
    noise: Note<Option<Arc<Vec<f64>>>>,
    /// The largest difference between two results for one state that a rule has met.
    difference: Note<Option<Difference>>,
    /// Parameters of the present loop at which samples show a feature that they do not resolve.
    features: Note<Vec<Feature>>,
}

impl Notes {
    /// The knowledge about the map that holds on every loop.
    pub fn of_map(&self) -> Self {
        Notes {
            inside: Note(RwLock::new(self.inside.get())),
            noise: Note(RwLock::new(self.noise.get())),
            ..Notes::default()
        }
    }

    /// Forgets what is known of the present loop.
    pub fn begin_loop(&self) {
        self.features.set(Vec::new());
        self.grain.set(None);
    }
}

/// A value that threads read and replace.
#[derive(Default)]
struct Note<T>(RwLock<T>);

impl<T: Clone> Note<T> {
    fn get(&self) -> T {
        (self.0.read().unwrap_or_else(PoisonError::into_inner)).clone()
    }

    fn set(&self, value: T) {
        self.change(|before| *before = value);
    }

    fn change(&self, change: impl FnOnce(&mut T)) {
        change(&mut self.0.write().unwrap_or_else(PoisonError::into_inner));
    }
}

impl Evaluator<'_> {
    /// Takes note of a feature of the present loop after a step of size `h`.
    pub fn note_feature(&self, s: f64, h: f64) {
        (self.notes.features).change(|features| features.push(Feature { s, h }));
    }

    /// The features of the present loop that were noted.
    pub fn features(&self) -> Vec<Feature> {
        self.notes.features.get()
    }

    /// Takes note of coordinates c of states k round a loop that the map returned, if its grain is not known yet.
    pub fn learn_grain(
        &self,
        phase_loop: &dyn Loop,
        samples: usize,
        value: impl Fn(usize, usize) -> f64,
    ) {
        if self.grain().is_none() {
            let inside = self.rounding_inside();
            let before = |count: usize| match Ensemble::sample(phase_loop, count) {
                Ok(before) => SamplesBefore::Exact(before),
                Err(_) => SamplesBefore::Unknown,
            };
            let found = Grain::of(
                samples,
                self.coordinates(),
                inside.as_deref().map(Vec::as_slice),
                value,
                before,
            );
            self.notes.grain.set(found.map(Arc::new));
        }
    }

    /// The grain of the map on the present loop, as far as it is known.
    pub fn grain(&self) -> Option<Arc<Grain>> {
        self.notes.grain.get()
    }

    /// Takes note that the map rounds each coordinate to this inside, or is as noisy.
    pub fn note_rounding_inside(&self, mut grains: Vec<f64>) {
        if let Some(known) = self.rounding_inside() {
            (grains.iter_mut().zip(&*known)).for_each(|(grain, known)| *grain = grain.max(*known));
        }
        self.notes.inside.set(Some(Arc::new(grains)));
    }

    /// The rounding of each coordinate inside the map, if it is coarser than double precision.
    pub fn rounding_inside(&self) -> Option<Arc<Vec<f64>>> {
        self.notes.inside.get()
    }

    /// Takes note that results of one state differ at random, by this standard deviation of each coordinate.
    pub fn note_noise(&self, deviations: Vec<f64>) {
        self.notes.noise.set(Some(Arc::new(deviations)));
    }

    /// The standard deviation of each coordinate, if results of one state differ at random.
    pub fn noise(&self) -> Option<Arc<Vec<f64>>> {
        self.notes.noise.get()
    }

    /// Whether one result for a state may be another the next time, as far as is known: then an end of a break may land on either side.
    pub fn is_noisy(&self) -> bool {
        self.rounding_inside().is_some() || self.noise().is_some()
    }

    /// Compares two results for a state at an end of a `jump` of a coordinate: takes note if they differ by half of it or more, and by
    /// more than rounding.
    pub fn compare(&self, c: usize, [first, again]: [f64; 2], jump: f64) {
        let size = nearest(again - first, period(self.coordinates(), c)).abs();
        let single = MAX_ROUNDINGS_OF_SINGLE * 0.5f64.powi(BITS_OF_SINGLE as i32);
        let is_rounding = size <= single * first.abs().max(again.abs());
        if is_rounding || size < 0.5 * jump.abs() {
            return;
        }
        self.notes.difference.change(|known| {
            if known.is_none_or(|known| size > known.size) {
                let dofs = self.dof();
                *known = Some(Difference {
                    coordinate: ['q', 'p'][c / dofs],
                    dof: c % dofs,
                    size,
                });
            }
        });
    }

    /// The largest difference between two results for one state that a rule has met.
    pub fn met_difference(&self) -> Option<Difference> {
        self.notes.difference.get()
    }
}
