//! One degree of freedom: what is kept of it while its samples pass by.

use crate::breaks::{Coordinate, GROUP, REACH, Residuals, Suspect, Window};
use crate::rules::stencil::{ALIASING_FACTOR, Stencil};
use crate::signal::{CompensatedSum, Extent, UNIT_ROUNDOFF};

/// Half widths of a stencil at most.
pub(super) const MAX_HALF_WIDTH: usize = 16;

/// A group of samples and what comes before it.
type Span = [f64; MAX_HALF_WIDTH + GROUP];

/// One value for each sample of a group.
type Lanes = [f64; GROUP];

/// Sums over the samples of one coordinate.
#[derive(Clone, Copy, Debug, Default)]
struct CoordinateSums {
    /// The first sample. All others are counted from it: far from the origin that spares digits, and it
    /// changes no loop integral.
    first: f64,
    /// Least and greatest, from the first.
    extent: Extent,
    /// Largest |x'| Δs.
    steepest: f64,
    /// Sum of the squares of the m-th differences.
    rough: f64,
    residuals: Residuals,
}

/// Sums over the samples of one degree of freedom.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Row {
    q: CoordinateSums,
    p: CoordinateSums,
    value: CompensatedSum,
    /// Sum of the absolute terms.
    scale: f64,
    /// Square of what one unit of relative noise in all samples does to the sum.
    stored: f64,
}

/// ∮ p dq of one degree of freedom, without its weight.
pub(super) struct RowIntegral {
    pub value: f64,
    /// `None` where momenta are periodic and the loop winds.
    pub quadrature_error: Option<f64>,
    pub roundoff: f64,
    pub scale: f64,
}

/// Adds whole periods to the samples from `from` on, each to come near the one before it.
fn unwrap(row: &mut [f64], from: usize, period: f64) {
    if period > 0.0 {
        for k in from.max(1)..row.len() {
            row[k] -= period * ((row[k] - row[k - 1]) / period).round();
        }
    }
}

impl Row {
    /// Begins with the first samples of the loop.
    pub fn begin(&mut self, q: &mut [f64], p: &mut [f64], periods: [f64; 2]) {
        (self.q.first, self.p.first) = (q[0], p[0]);
        unwrap(q, 1, periods[0]);
        unwrap(p, 1, periods[1]);
    }

    /// Adds the new samples, which come after `old` ones, at least as many as the half width of the stencil and
    /// [`REACH`]; the first of them is sample `next`.
    ///
    /// Returns the largest |Δq| from one sample to the next.
    pub fn add(
        &mut self,
        stencil: &Stencil,
        [old, next]: [usize; 2],
        q: &mut [f64],
        p: &mut [f64],
        periods: [f64; 2],
    ) -> f64 {
        unwrap(q, old, periods[0]);
        unwrap(p, old, periods[1]);
        let mut furthest: f64 = 0.0;
        for start in (old..q.len()).step_by(GROUP) {
            let end = (start + GROUP).min(q.len());
            let span = |row: &[f64], first: f64| {
                // Beyond the last sample it stands still.
                let mut span = [row[end - 1] - first; MAX_HALF_WIDTH + GROUP];
                let row = &row[start - old..end];
                for (to, from) in span[MAX_HALF_WIDTH - old..].iter_mut().zip(row) {
                    *to = from - first;
                }
                span
            };
            let (q, p) = (span(q, self.q.first), span(p, self.p.first));
            furthest =
                furthest.max(self.add_group(stencil, next + start - old, end - start, &q, &p));
        }
        furthest
    }

    /// Adds `count` samples, counted from the first of the loop, that begin at `MAX_HALF_WIDTH` with sample `next`.
    ///
    /// Σ_k p_k (D q)_k = Σ_n Σ_j c_j (p_{n−j} q_n − q_{n−j} p_n) round the loop: in this form no sample needs
    /// its successors. The differences p_{n−j} − p_n and q_{n−j} − q_n, which give the same sum, keep the
    /// terms small.
    fn add_group(
        &mut self,
        stencil: &Stencil,
        next: usize,
        count: usize,
        q: &Span,
        p: &Span,
    ) -> f64 {
        let (p_slope, q_slope) = (half_slope(stencil, p), half_slope(stencil, q));
        let (mut terms, mut sizes, mut squares) = ([0.0; GROUP], [0.0; GROUP], [0.0; GROUP]);
        let mut steps = [0.0; GROUP];
        for k in 0..GROUP {
            let (of_q, of_p) = (
                q[MAX_HALF_WIDTH + k] * p_slope[k],
                p[MAX_HALF_WIDTH + k] * q_slope[k],
            );
            terms[k] = of_q - of_p;
            sizes[k] = of_q.abs() + of_p.abs();
            let q_noise = 2.0 * (self.q.first + q[MAX_HALF_WIDTH + k]) * p_slope[k];
            let p_noise = 2.0 * (self.p.first + p[MAX_HALF_WIDTH + k]) * q_slope[k];
            squares[k] = q_noise * q_noise + p_noise * p_noise;
            steps[k] = (q[MAX_HALF_WIDTH + k] - q[MAX_HALF_WIDTH + k - 1]).abs();
        }
        for lanes in [&mut terms, &mut sizes, &mut squares] {
            lanes[count..].fill(0.0);
        }
        self.value.add(sum(&terms));
        self.scale += sum(&sizes);
        self.stored += sum(&squares);
        self.q.add(stencil, next, count, q, &q_slope);
        self.p.add(stencil, next, count, p, &p_slope);
        most(&steps)
    }

    /// The integral after one revolution; `q` and `p` are the samples that follow the last one, which are the first
    /// ones again.
    pub fn integral(
        &self,
        stencil: &Stencil,
        q: &[f64],
        p: &[f64],
        periods: [f64; 2],
    ) -> RowIntegral {
        let mut value = self.value;
        let (mut scale, mut roundoff) = (self.scale, 0.0);
        let gained = |distance: f64, period: f64| match period > 0.0 {
            true => period * (distance / period).round(),
            false => 0.0,
        };
        let gain = gained(q[0] - self.q.first, periods[0]);
        let has_value =
            periods[1] == 0.0 || (gain == 0.0 && gained(p[0] - self.p.first, periods[1]) == 0.0);
        if gain != 0.0 {
            // Where q has gained whole periods, products across the end of the loop miss them.
            for (j, c) in (1..).zip(&stencil.centred) {
                for p in &p[p.len() - j..] {
                    value.add(gain * c * (p - self.p.first));
                }
            }
            let base = gain * self.p.first;
            value.add(base);
            scale += base.abs();
            roundoff += 2.0 * UNIT_ROUNDOFF * gain.abs() * self.p.magnitude();
        }
        roundoff += UNIT_ROUNDOFF * (self.stored.sqrt() + 4.0 * scale);
        let (q_rough, p_rough) = (self.q.rough.sqrt(), self.p.rough.sqrt());
        let folded = ALIASING_FACTOR * (q_rough * self.p.steepest + p_rough * self.q.steepest);
        RowIntegral {
            value: value.total(),
            quadrature_error: has_value.then(|| stencil.miss(q_rough, p_rough) + folded),
            roundoff,
            scale,
        }
    }

    /// Ranges of q and p on the loop.
    pub fn ranges(&self) -> [f64; 2] {
        [self.q, self.p].map(|of| of.extent.length())
    }

    /// Cells that look discontinuous after one revolution of samples, the first of which came as `old` ones.
    pub fn suspects(
        &self,
        dof: usize,
        samples: usize,
        old: usize,
    ) -> impl Iterator<Item = Suspect> {
        let q = (Coordinate::Q, self.q);
        let p = (Coordinate::P, self.p);
        let groups = (samples - old) / GROUP + old / GROUP;
        [q, p].into_iter().filter_map(move |(coordinate, of)| {
            of.residuals
                .suspect(dof, coordinate, [samples, groups], of.magnitude())
        })
    }
}

impl CoordinateSums {
    fn add(&mut self, stencil: &Stencil, next: usize, count: usize, x: &Span, half_slope: &Lanes) {
        let mut squares = difference(stencil, x);
        let (mut slopes, mut up, mut down) = ([0.0; GROUP], [0.0; GROUP], [0.0; GROUP]);
        for k in 0..GROUP {
            let n = MAX_HALF_WIDTH + k;
            squares[k] *= squares[k];
            slopes[k] = 2.0 * half_slope[k].abs();
            (up[k], down[k]) = (x[n], -x[n]);
        }
        for lanes in [&mut squares, &mut slopes] {
            lanes[count..].fill(0.0);
        }
        self.extent.include(most(&up));
        self.extent.include(-most(&down));
        self.steepest = self.steepest.max(most(&slopes));
        self.rough += sum(&squares);
        let window: &Window =
            (x[MAX_HALF_WIDTH - REACH..].try_into()).expect("the span goes back further");
        self.residuals.add(window, next, count);
    }

    /// No sample is larger in size.
    fn magnitude(&self) -> f64 {
        self.first.abs() + self.extent.magnitude()
    }
}

/// Σ c_j (x_{n−j} − x_n) for each sample of a group: about −x' Δs/2, from what came before.
fn half_slope(stencil: &Stencil, x: &Span) -> Lanes {
    let mut slope = [0.0; GROUP];
    for (j, c) in (1..).zip(&stencil.centred) {
        let earlier = &x[MAX_HALF_WIDTH - j..][..GROUP];
        for k in 0..GROUP {
            slope[k] += c * (earlier[k] - x[MAX_HALF_WIDTH + k]);
        }
    }
    slope
}

/// The m-th difference that ends with each sample of a group.
fn difference(stencil: &Stencil, x: &Span) -> Lanes {
    let mut difference = [0.0; GROUP];
    for (l, w) in stencil.difference.iter().enumerate() {
        let earlier = &x[MAX_HALF_WIDTH - l..][..GROUP];
        for k in 0..GROUP {
            difference[k] += w * earlier[k];
        }
    }
    difference
}

/// The sum by halves, the same on every machine.
fn sum(lanes: &Lanes) -> f64 {
    by_halves(lanes, |a, b| a + b)
}

/// The largest.
fn most(lanes: &Lanes) -> f64 {
    by_halves(lanes, |a, b| if a > b { a } else { b })
}

fn by_halves(lanes: &Lanes, join: impl Fn(f64, f64) -> f64) -> f64 {
    let mut lanes = *lanes;
    let mut half = GROUP / 2;
    while half > 0 {
        for k in 0..half {
            lanes[k] = join(lanes[k], lanes[k + half]);
        }
        half /= 2;
    }
    lanes[0]
}
