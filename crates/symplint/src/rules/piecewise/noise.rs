//! The noise of a map on a stretch of a curve.

use super::curves::{CurvePoint, PointImage};
use super::limits::{
    MARGIN_OF_NOISE, NOISE_POINTS, NOISE_SITES, NOISE_SPACING, NOISE_SPACING_OF_PIECE,
};
use crate::signal::nearest;
use crate::signal::noise::SixthDifference;
use crate::state::{Coordinates, period};

/// States that are asked for.
pub(super) const STATES: usize = NOISE_SITES.len() * NOISE_POINTS.len();

/// Where they are on the stretch [a, b] of a curve.
pub(super) fn points(curve: usize, [a, b]: [f64; 2]) -> impl Iterator<Item = CurvePoint> {
    let length = b - a;
    let spacing = if length < 1.0 {
        NOISE_SPACING_OF_PIECE * length
    } else {
        NOISE_SPACING
    };
    NOISE_SITES.into_iter().flat_map(move |site| {
        let first = a + site * length;
        NOISE_POINTS
            .into_iter()
            .map(move |x| CurvePoint::on(curve, first + spacing * x))
    })
}

/// What each coordinate may be off because of noise, from the images at those points.
pub(super) fn allowance(images: &[PointImage], coordinates: &Coordinates) -> Vec<f64> {
    let difference = SixthDifference::at(NOISE_POINTS);
    (0..2 * coordinates.dof())
        .map(|c| {
            let period = period(coordinates, c);
            let of_site = |site: &[PointImage]| {
                let first = site[0].after()[c];
                let values = site
                    .iter()
                    .map(|image| nearest(image.after()[c] - first, period));
                difference.of(&values.collect::<Vec<f64>>()).abs()
            };
            let mut noise: Vec<f64> = images
                .chunks_exact(NOISE_POINTS.len())
                .map(of_site)
                .collect();
            noise.sort_by(f64::total_cmp);
            MARGIN_OF_NOISE * noise[NOISE_SITES.len() / 2]
        })
        .collect()
}
