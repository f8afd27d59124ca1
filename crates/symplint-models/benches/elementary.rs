//! Sines and cosines of a row in cache compared with those of the standard library, in one interleaved run.
//!
//! `cargo bench -p symplint-models --bench elementary [-- PART OF A NAME]`.

mod interleaved;
// The same kernel once more, to compile it for processors that would not be chosen here.
#[allow(dead_code, reason = "the bench takes sines alone")]
#[path = "../src/elementary/kernel.rs"]
mod kernel;

use std::hint::black_box;

use interleaved::{heading, report};
use kernel::{Arithmetic, FusedArithmetic, LANES, SeparateArithmetic};
use symplint_models::elementary::{add_sin, cos_into, sin_into};

/// Numbers in a row: 8 KiB, in the first cache with the result.
const ROW: usize = 1024;

fn main() {
    heading(&format!("a row of {ROW} numbers, each"));
    for largest in [0.7, std::f64::consts::PI, 1e4] {
        let name = |what: &str| format!("{what}, |x| < {largest:.1}");
        let x: Vec<f64> = (0..ROW)
            .map(|i| largest * (2.0 * (0.618_033_988_749_895 * i as f64).fract() - 1.0))
            .collect();
        against(&name("sin"), &x, sin_into, f64::sin);
        against(&name("cos"), &x, cos_into, f64::cos);
        against(&name("sin, portable"), &x, portable, f64::sin);
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            against(&name("sin, AVX2"), &x, x86::avx2, f64::sin);
        }
    }
    kick();
}

/// A function of a row compared with a function of a number.
fn against(name: &str, x: &[f64], function: fn(&[f64], &mut [f64]), control: fn(f64) -> f64) {
    let (mut out, mut control_out) = (vec![0.0; ROW], vec![0.0; ROW]);
    report(
        name,
        ROW as f64,
        ROW as f64,
        || function(black_box(x), black_box(&mut out)),
        || {
            for (out, x) in black_box(&mut control_out).iter_mut().zip(black_box(x)) {
                *out = control(*x);
            }
        },
    );
}

/// p += τ sin q, as the pendulum is kicked.
fn kick() {
    let q: Vec<f64> = (0..ROW).map(|i| 0.01 * i as f64).collect();
    let (mut p, mut control_p) = (vec![0.0; ROW], vec![0.0; ROW]);
    report(
        "p += τ sin q",
        ROW as f64,
        ROW as f64,
        || add_sin(black_box(1e-9), black_box(&q), black_box(&mut p)),
        || {
            let tau = black_box(1e-9);
            for (p, q) in black_box(&mut control_p).iter_mut().zip(black_box(&q)) {
                *p += tau * q.sin();
            }
        },
    );
}

#[inline(always)]
fn sines<M: Arithmetic>(x: &[f64], out: &mut [f64]) {
    let chunks = x.as_chunks::<LANES>().0;
    for (out, x) in out.as_chunks_mut::<LANES>().0.iter_mut().zip(chunks) {
        *out = kernel::sin::<M>(*x);
    }
}

fn portable(x: &[f64], out: &mut [f64]) {
    sines::<SeparateArithmetic>(x, out);
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{FusedArithmetic, sines};

    #[multiversion::multiversion(targets("x86_64+avx2+fma"))]
    pub fn avx2(x: &[f64], out: &mut [f64]) {
        sines::<FusedArithmetic>(x, out);
    }
}
