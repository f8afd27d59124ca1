//! Sines and cosines of whole rows of states: the one place where systems get them from.
//!
//! Errors stay below 1 ulp for every double; the largest that the tests meet is 0.83 ulp. Infinities and
//! NaN give NaN, and sin(−0) is −0. Rows may have any length, and what becomes of a number does not
//! depend on its place in the row.
//!
//! Each function is compiled for AVX-512, for AVX2 with FMA, and for any processor, and the best
//! is chosen when it is first called. All processors with fused multiply-adds (AVX-512, FMA,
//! 64-bit Arm) give the same bits; those of others may differ in the last one.

mod dispatch;
mod kernel;
mod lanes;

pub(crate) use dispatch::dispatched;
pub(crate) use kernel::{Arithmetic, FusedArithmetic, LANES, SeparateArithmetic, cos, sin};
pub(crate) use lanes::{LaneMap, Lanes, map_lanes};

/// sin x.
struct Sin;
/// cos x.
struct Cos;
/// What there was + factor sin x.
struct AddSin(f64);
/// What there was + factor cos x.
struct AddCos(f64);

impl LaneMap<1, 1> for Sin {
    #[inline(always)]
    fn apply<M: Arithmetic>(&self, [x]: [Lanes; 1], _: [Lanes; 1]) -> [Lanes; 1] {
        [sin::<M>(x)]
    }
}

impl LaneMap<1, 1> for Cos {
    #[inline(always)]
    fn apply<M: Arithmetic>(&self, [x]: [Lanes; 1], _: [Lanes; 1]) -> [Lanes; 1] {
        [cos::<M>(x)]
    }
}

impl LaneMap<1, 1> for AddSin {
    #[inline(always)]
    fn apply<M: Arithmetic>(&self, [x]: [Lanes; 1], [out]: [Lanes; 1]) -> [Lanes; 1] {
        [added(out, self.0, sin::<M>(x))]
    }
}

impl LaneMap<1, 1> for AddCos {
    #[inline(always)]
    fn apply<M: Arithmetic>(&self, [x]: [Lanes; 1], [out]: [Lanes; 1]) -> [Lanes; 1] {
        [added(out, self.0, cos::<M>(x))]
    }
}

/// What there was + factor · term.
#[inline(always)]
fn added(mut out: Lanes, factor: f64, term: Lanes) -> Lanes {
    for k in 0..LANES {
        out[k] += factor * term[k];
    }
    out
}

dispatched! {
    /// Writes sin x of every x into `out`.
    ///
    /// # Panics
    /// If the rows differ in length.
    pub fn sin_into<M>(x: &[f64], out: &mut [f64]) {
        map_lanes::<M, 1, 1>(&Sin, [x], [out]);
    }
}

dispatched! {
    /// Writes cos x of every x into `out`.
    ///
    /// # Panics
    /// If the rows differ in length.
    pub fn cos_into<M>(x: &[f64], out: &mut [f64]) {
        map_lanes::<M, 1, 1>(&Cos, [x], [out]);
    }
}

dispatched! {
    /// Adds factor · sin x of every x to `out`: a kick in one pass.
    ///
    /// # Panics
    /// If the rows differ in length.
    pub fn add_sin<M>(factor: f64, x: &[f64], out: &mut [f64]) {
        map_lanes::<M, 1, 1>(&AddSin(factor), [x], [out]);
    }
}

dispatched! {
    /// Adds factor · cos x of every x to `out`: a kick in one pass.
    ///
    /// # Panics
    /// If the rows differ in length.
    pub fn add_cos<M>(factor: f64, x: &[f64], out: &mut [f64]) {
        map_lanes::<M, 1, 1>(&AddCos(factor), [x], [out]);
    }
}
