//! The image of a loop after a step, as a separate loop.

use super::Evaluator;
use crate::loops::Loop;
use crate::state::{Block, coordinate, coordinate_mut};

/// The image of a loop under one step of size `h`. Each of its samples is an evaluation; if the map fails it is NaN,
/// which becomes an error.
pub(crate) struct ImageLoop<'a> {
    pub inner: &'a dyn Loop,
    pub evaluator: &'a Evaluator<'a>,
    pub h: f64,
}

impl Loop for ImageLoop<'_> {
    fn dof(&self) -> usize {
        self.inner.dof()
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        let image = self.evaluator.image(self.inner, self.h, s).ok();
        for c in 0..2 * self.dof() {
            match &image {
                Some(image) => coordinate_mut(block, c).copy_from_slice(coordinate(image, c)),
                None => coordinate_mut(block, c).fill(f64::NAN),
            }
        }
    }
}
