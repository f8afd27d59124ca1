//! How large and how exact each coordinate is.

use super::curves::PointImage;
use super::limits::{MAX_ERROR_IN_GRAINS, MIN_PART_OF_LARGEST, MIN_SIZE, ROUNDING_OF_OPERATIONS};
use crate::map::Grain;
use crate::signal::{Extent, unwrap_row};
use crate::state::{Coordinates, period};

/// Sizes and tolerances of the 2d coordinates, positions first.
pub(super) struct Scales {
    /// Half the range of each coordinate along the loop.
    pub size: Vec<f64>,
    /// The reference from which momenta are counted: those of the loop at s = 0, advanced.
    pub p_reference: Vec<f64>,
    /// What an interpolant may be off.
    pub tolerance: Vec<f64>,
    /// Its error because of the noise that the map has all along the loop.
    pub noise: Vec<f64>,
    /// The grain of the map, if it is known.
    pub grain: Option<Grain>,
    /// Largest absolute value of each coordinate.
    pub magnitude: Vec<f64>,
    /// How far along the loop the rounding of a state is, as a part of one revolution.
    pub input_rounding: f64,
}

impl Scales {
    /// From a few points of the advanced loop, in their order.
    pub fn new(
        images: &[&PointImage],
        coordinates: &Coordinates,
        tolerance: f64,
        grain: Option<&Grain>,
    ) -> Self {
        let dof = coordinates.dof();
        let mut size: Vec<f64> = Vec::with_capacity(2 * dof);
        let mut magnitude: Vec<f64> = Vec::with_capacity(2 * dof);
        for c in 0..2 * dof {
            let mut row: Vec<f64> = images.iter().map(|image| image.after()[c]).collect();
            magnitude.push(Extent::of(&row).magnitude());
            unwrap_row(&mut row, period(coordinates, c));
            size.push(0.5 * Extent::of(&row).length());
        }
        let kinds = size.chunks_exact_mut(dof.max(1));
        for (sizes, magnitudes) in kinds.zip(magnitude.chunks_exact(dof.max(1))) {
            let largest = Extent::of(sizes).magnitude();
            for (size, magnitude) in sizes.iter_mut().zip(magnitudes) {
                let least = (MIN_PART_OF_LARGEST * largest).max(ROUNDING_OF_OPERATIONS * magnitude);
                *size = size.max(least).max(MIN_SIZE);
            }
        }
        let sizes = || size.iter().zip(&magnitude);
        Scales {
            tolerance: sizes()
                .map(|(size, magnitude)| tolerance * size + ROUNDING_OF_OPERATIONS * magnitude)
                .collect(),
            noise: (0..2 * dof)
                .map(|c| MAX_ERROR_IN_GRAINS * grain.map_or(0.0, |grain| grain.of_coordinate(c)))
                .collect(),
            grain: grain.cloned(),
            p_reference: images[0].after()[dof..].to_vec(),
            input_rounding: sizes().fold(ROUNDING_OF_OPERATIONS, |most: f64, (size, magnitude)| {
                most.max(ROUNDING_OF_OPERATIONS * magnitude / size)
            }),
            size,
            magnitude,
        }
    }

    /// Weight of a coordinate compared with the others.
    pub fn weight(&self, c: usize) -> f64 {
        1.0 / self.size[c]
    }
}
