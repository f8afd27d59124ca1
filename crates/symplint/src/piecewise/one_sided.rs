//! Features met by chance beside a kink or a jump.
//!
//! Samples on both sides of a stretch that has a kink do not continue each other. But those on one side tell how the
//! loop goes on as far as the kink. A feature on the way was met by chance where pieces beyond it are as they tell again.

use super::chance::{Feature, Stretch, range};
use super::curves::coordinate;
use super::lobatto::{DEGREE, LOBATTO};
use super::path::Path;
use super::scales::period;

/// A side of a stretch.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Side {
    Left,
    Right,
}

/// Fewer samples say too little of how well they tell how the loop goes on.
const FEWEST: usize = 3;

impl Stretch<'_> {
    /// What degree of freedom i has between this side and the furthest piece that is as the samples on it tell,
    /// if it is more than what they may be off on the way.
    pub fn beside_a_kink(&self, i: usize, side: Side) -> Option<Feature> {
        let beside = &self.beside[side as usize];
        if beside.len() < FEWEST {
            return None;
        }
        // Without the furthest, they tell how well they do.
        let fewer = match side {
            Side::Left => &beside[1..],
            Side::Right => &beside[..beside.len() - 1],
        };
        let [q, p] = [i, self.seen.dof() + i].map(|c| {
            let (row, period) = (coordinate(self.seen, c), period(self.queue.coordinates, c));
            let paths = [&beside[..], fewer].map(|at| self.path(row, period, at));
            (paths, self.allowance(c))
        });
        let weight = self.queue.coordinates.weight(i);
        let reference = self.queue.scales.p_reference[i];
        let count = self.pieces.len();
        let (mut area, mut gain, mut doubt) = (0.0, 0.0, 0.0);
        let mut feature = None;
        for passed in 1..=count {
            let (k, pieces) = match side {
                Side::Left => (self.pieces[passed - 1], &self.pieces[..passed]),
                Side::Right => (self.pieces[count - passed], &self.pieces[count - passed..]),
            };
            let ends = self.ends_of(k);
            let told = |([path, other], allowance): &([Path; 2], f64)| {
                let (values, others) = (path.values(ends), other.values(ends));
                let apart = values.iter().zip(&others).map(|(x, y)| (x - y).abs());
                (values, allowance + apart.fold(0.0, f64::max))
            };
            let ((q, off_q), (p, off_p)) = (told(&q), told(&p));
            let smooth = weight * LOBATTO.area(&p.map(|v| v - reference), &q.map(|v| v - q[0]));
            let piece = &self.queue.smooth[k];
            let more = piece.areas[i] - smooth;
            let further = piece.gains[i] - (q[DEGREE] - q[0]);
            (area, gain) = (area + more, gain + further);
            let may_be_off = weight.abs() * (off_p * range(&q) + off_q * range(&p));
            doubt += may_be_off;
            // Momenta count from that of the piece, as wherever it is, it contributes the same.
            let counted = |area: f64, gain: f64| area + weight * (reference - p[0]) * gain;
            let edges: Vec<f64> = (pieces.iter().map(|&k| self.ends_of(k)[0]))
                .chain(pieces.last().map(|&k| self.ends_of(k)[1]))
                .collect();
            let chords = self.chords(i, [edges[0], edges[edges.len() - 1]]);
            let closed = chords.fold((area, gain), |sum, (area, gain)| {
                (sum.0 + area, sum.1 + gain)
            });
            if counted(more, further).abs() <= may_be_off && closed.1.abs() <= off_q {
                feature = Some(Feature {
                    area: counted(closed.0, closed.1),
                    doubt,
                    edges,
                    beside: beside.clone(),
                });
            }
        }
        feature.filter(|feature| feature.area.abs() > feature.doubt)
    }
}
