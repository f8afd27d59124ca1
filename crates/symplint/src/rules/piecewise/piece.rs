//! A stretch of a curve, and its part of the integral.

use std::sync::Arc;

use super::curves::{CurvePoint, PointImage};
use super::limits::{
    CHECKS, DEGREES, FULL_LEVEL, MAX_STRAIGHT_LENGTH, SAMPLES_PER_ESTIMATE, TOLERANCE_BELOW_FULL,
};
use super::lobatto::{DEGREE, LOBATTO, NODES, POINTS};
use super::scales::Scales;

/// Which points belong to each of [`DEGREES`]: its nodes, and the checks.
const IS_OF_LEVEL: [[bool; POINTS]; DEGREES.len()] = {
    let mut is_of_level = [[true; POINTS]; DEGREES.len()];
    let mut level = 0;
    while level < DEGREES.len() {
        let mut k = 0;
        while k < NODES {
            is_of_level[level][k] = k.is_multiple_of(DEGREE / DEGREES[level]);
            k += 1;
        }
        level += 1;
    }
    is_of_level
};

/// A stretch [a, b] of a curve.
#[derive(Clone)]
pub(super) struct Piece {
    pub curve: usize,
    pub a: f64,
    pub b: f64,
    /// Which of [`DEGREES`] is tried.
    pub level: usize,
    /// Images of its nodes, then of the checks, as far as they are known.
    pub images: [Option<PointImage>; POINTS],
    /// What each coordinate may be off because of the noise that the map has here, and not everywhere.
    pub noise: Option<Arc<[f64]>>,
}

impl Piece {
    /// A part of a curve, of which the images of the ends may be known.
    pub fn new(
        curve: usize,
        [a, b]: [f64; 2],
        level: usize,
        ends: [Option<PointImage>; 2],
    ) -> Self {
        let mut images = [const { None }; POINTS];
        let [first, last] = ends;
        (images[0], images[DEGREE]) = (first, last);
        let level = if b - a < MAX_STRAIGHT_LENGTH {
            FULL_LEVEL
        } else {
            level
        };
        Piece {
            curve,
            a,
            b,
            level,
            images,
            noise: None,
        }
    }

    /// A part of it: what is known of its noise holds there, too.
    pub fn part(&self, ends: [f64; 2], images: [Option<PointImage>; 2]) -> Self {
        Piece {
            noise: self.noise.clone(),
            ..Piece::new(self.curve, ends, 0, images)
        }
    }

    /// The parts between rising parameters: two halves if none of them is inside.
    pub fn cut(&self, at: &[f64]) -> Vec<Piece> {
        let mut edges = vec![self.a];
        edges.extend(at.iter().copied().filter(|&s| s > self.a && s < self.b));
        if edges.len() == 1 {
            edges.push(self.s(0.0));
        }
        edges.push(self.b);
        edges.dedup();
        (edges.windows(2))
            .map(|ends| {
                self.part(
                    [ends[0], ends[1]],
                    [self.image_at(ends[0]), self.image_at(ends[1])],
                )
            })
            .collect()
    }

    /// The image at a parameter, if it is known.
    fn image_at(&self, s: f64) -> Option<PointImage> {
        let mut points = (0..POINTS).filter(|&k| self.point(k) == s);
        points.find_map(|k| self.images[k].clone())
    }

    /// The allowed error of a coordinate: the tolerance, or the noise here.
    pub fn allowance(&self, c: usize, scales: &Scales) -> f64 {
        let part = if self.level < FULL_LEVEL {
            TOLERANCE_BELOW_FULL
        } else {
            1.0
        };
        let noise = self.noise.as_ref().map_or(0.0, |noise| noise[c]);
        (part * scales.tolerance[c]).max(scales.noise[c]).max(noise)
    }

    /// Whether it lies within a stretch.
    pub fn lies_in(&self, [a, b]: &[f64; 2]) -> bool {
        self.a >= *a && self.b <= *b
    }

    pub fn length(&self) -> f64 {
        self.b - self.a
    }

    /// Whether it counts as a straight line.
    pub fn is_short(&self) -> bool {
        self.length() < MAX_STRAIGHT_LENGTH
    }

    /// Parameter at x in [−1, 1]; the ends are met exactly.
    pub fn s(&self, x: f64) -> f64 {
        if x <= -1.0 {
            self.a
        } else if x >= 1.0 {
            self.b
        } else {
            self.a + 0.5 * (1.0 + x) * self.length()
        }
    }

    pub fn x(&self, s: f64) -> f64 {
        2.0 * (s - self.a) / self.length() - 1.0
    }

    /// Parameter of a node, or of a check.
    fn point(&self, k: usize) -> f64 {
        self.s(if k < NODES {
            LOBATTO.nodes[k]
        } else {
            CHECKS[k - NODES]
        })
    }

    /// Which of its points have to be evaluated before it can be looked at.
    pub fn missing(&self) -> impl Iterator<Item = usize> {
        (0..POINTS).filter(|&k| self.is_missing(k))
    }

    fn is_missing(&self, k: usize) -> bool {
        IS_OF_LEVEL[self.level][k] && self.images[k].is_none()
    }

    /// Where they are.
    pub fn missing_points(&self) -> impl Iterator<Item = CurvePoint> {
        self.missing()
            .map(|k| CurvePoint::on(self.curve, self.point(k)))
    }

    /// Takes their images in.
    pub fn fill(&mut self, mut images: impl Iterator<Item = PointImage>) {
        for k in 0..POINTS {
            if self.is_missing(k) {
                self.images[k] = images.next();
            }
        }
    }

    /// The image of a point that was evaluated.
    pub fn image(&self, k: usize) -> &PointImage {
        self.images[k].as_ref().expect("the point was evaluated")
    }
}

/// A piece that is done, or may be taken unchanged.
#[derive(Clone)]
pub(super) struct SmoothPiece {
    pub curve: usize,
    pub a: f64,
    pub b: f64,
    /// ∫ (p − p_ref) dq of each degree of freedom.
    pub areas: Vec<f64>,
    /// q(b) − q(a) of each.
    pub gains: Vec<f64>,
    /// Largest |q| and |p − p_ref| times the motion of the other, summed: what rounding acts on.
    pub exposure: f64,
    /// Bound on the error by interpolation.
    pub error: f64,
    /// The error by interpolation as the samples on the piece have it, if there are as many as estimates.
    pub missed: Option<InterpolationMiss>,
    /// That bound if the piece hides a jump.
    pub error_of_jump: f64,
    /// The jump that noise allowed for here, and not everywhere, may hide: as large as states scatter.
    pub error_of_noise: f64,
    /// Whether it is as good as wanted.
    pub resolved: bool,
}

/// What interpolants miss samples by.
#[derive(Clone)]
pub(super) struct InterpolationMiss {
    /// Estimates of what the integral of the interpolants is off.
    pub estimates: [f64; SAMPLES_PER_ESTIMATE],
    /// The integral that the piece may hide if a jump is all that they miss.
    pub jump: f64,
}

impl SmoothPiece {
    /// The same where nothing more can be done about it.
    pub fn unresolved(self) -> Self {
        SmoothPiece {
            resolved: false,
            error: self.error_of_jump,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_piece_lies_in_a_stretch_that_holds_both_of_its_ends() {
        let piece = Piece::new(0, [0.25, 0.5], 0, [None, None]);
        assert!(piece.lies_in(&[0.25, 0.5]));
        assert!(piece.lies_in(&[0.2, 0.6]));
        assert!(!piece.lies_in(&[0.3, 0.6]));
        assert!(!piece.lies_in(&[0.2, 0.4]));
        assert!(!piece.lies_in(&[0.6, 0.7]));
    }
}
