//! Sine and cosine of a few numbers at once, without a branch. This file needs no other.
//!
//! |x| is reduced to y = |x| − n π/2, |y| ≤ π/4, with π/2 in three parts (W. Cody & W. Waite, "Software
//! Manual for the Elementary Functions", 1980), y and what it lacks apart. Sine and cosine of y are
//! the polynomials of fdlibm (Sun Microsystems, 1993, `k_sin.c` and `k_cos.c`).
//!
//! Loops over the lanes are written for the compiler to vectorise, which it does as they stand:
//! `benches/elementary.rs` shows whether it still does.

/// Numbers worked on at once: one vector of AVX-512, two of AVX2.
pub const LANES: usize = 8;

/// Arguments up to this are reduced here, by n of at most 20 bits; larger ones are left to the
/// `libm` crate, one by one.
pub const MAX_REDUCED: f64 = 1_048_576.0;

/// How a product is added to a number.
pub trait Arithmetic {
    /// a b + c, rounded once or twice.
    fn mul_add(a: f64, b: f64, c: f64) -> f64;

    /// y and tail with y + tail = x − n π/2, |tail| far below |y|, for the n next to 2x/π and
    /// 0 ≤ x ≤ [`MAX_REDUCED`].
    fn remainder(x: f64, n: f64) -> (f64, f64);
}

/// Rounded once: for processors with fused multiply-adds. Others would call a library for each.
pub struct FusedArithmetic;

/// Rounded twice.
pub struct SeparateArithmetic;

/// π/2 = A + B + C to 2^-141. B has 33 bits, so n B is exact.
const A: f64 = std::f64::consts::FRAC_PI_2;
const B: f64 = 6.123_233_995_384_61e-17;
const C: f64 = 3.521_559_865_183_2e-27;

/// The leading 33 bits of A, and the others.
const A_HEAD: f64 = f64::from_bits(A.to_bits() & !((1 << 20) - 1));
const A_REST: f64 = A - A_HEAD;

// In both ways of reduction:
// · u = x − n A is exact: for n ≠ 0 it is below 1 and, as x and n A, a multiple of 2^-53.
// · y = u − n B loses exactly (u − y) − n B. That is so if u is the larger one; if it is not, both
//   are below 2^-34 and multiples of 2^-86, and so few bits lose nothing.
// · The rounding error of n C, below 2^-120, is what remains: no double in question is closer to a
//   multiple of π/2 than 2^-61.

impl Arithmetic for FusedArithmetic {
    #[inline(always)]
    fn mul_add(a: f64, b: f64, c: f64) -> f64 {
        a.mul_add(b, c)
    }

    #[inline(always)]
    fn remainder(x: f64, n: f64) -> (f64, f64) {
        let u = (-n).mul_add(A, x);
        let y = (-n).mul_add(B, u);
        let lost = (-n).mul_add(B, u - y);
        (y, (-n).mul_add(C, lost))
    }
}

impl Arithmetic for SeparateArithmetic {
    #[inline(always)]
    fn mul_add(a: f64, b: f64, c: f64) -> f64 {
        a * b + c
    }

    #[inline(always)]
    fn remainder(x: f64, n: f64) -> (f64, f64) {
        let u = (x - n * A_HEAD) - n * A_REST;
        let y = u - n * B;
        let lost = (u - y) - n * B;
        (y, lost - n * C)
    }
}

/// |x| = y + tail + quadrant π/2, where all bits but the last two of the quadrant are without meaning.
struct ReducedArgument {
    y: f64,
    tail: f64,
    quadrant: u64,
}

#[inline(always)]
fn reduced<M: Arithmetic>(x: f64) -> ReducedArgument {
    // A number added to this has its units in the last bit.
    const ROUNDER: f64 = 6_755_399_441_055_744.0;
    let x = x.abs();
    let shifted = M::mul_add(x, std::f64::consts::FRAC_2_PI, ROUNDER);
    let (y, tail) = M::remainder(x, shifted - ROUNDER);
    ReducedArgument {
        y,
        tail,
        quadrant: shifted.to_bits(),
    }
}

/// c_0 + c_1 z + … + c_5 z⁵ in pairs, a shorter chain than Horner's.
#[inline(always)]
fn quintic<M: Arithmetic>(z: f64, z2: f64, c: [f64; 6]) -> f64 {
    let pair = |k: usize| M::mul_add(z, c[k + 1], c[k]);
    M::mul_add(z2, M::mul_add(z2, pair(4), pair(2)), pair(0))
}

/// (sin y − y)/y³ as a polynomial in y².
const SIN: [f64; 6] = [
    -1.666_666_666_666_663_2e-1,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];

/// (cos y − 1 + y²/2)/y⁴ as a polynomial in y².
const COS: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

/// sin(y + tail) and cos(y + tail), to first order in the tail.
#[inline(always)]
fn polynomials<M: Arithmetic>(y: f64, tail: f64) -> (f64, f64) {
    let z = y * y;
    let z2 = z * z;
    let head = M::mul_add(-0.5, z, 1.0);
    let lost = M::mul_add(-0.5, z, 1.0 - head);
    let cos = M::mul_add(z2, quintic::<M>(z, z2, COS), M::mul_add(-y, tail, lost));
    let sin = M::mul_add(y * z, quintic::<M>(z, z2, SIN), tail * head);
    (y + sin, head + cos)
}

const SIGN: u64 = 1 << 63;

/// The bits of `even` or `odd` as the last bit of `quadrant` says, by a mask: a jump would keep the
/// loop from being vectorised.
#[inline(always)]
fn chosen(quadrant: u64, even: f64, odd: f64) -> u64 {
    let mask = (quadrant & 1).wrapping_neg();
    even.to_bits() ^ ((even.to_bits() ^ odd.to_bits()) & mask)
}

#[inline(always)]
fn lane<M: Arithmetic>(x: f64) -> (f64, f64) {
    let ReducedArgument { y, tail, quadrant } = reduced::<M>(x);
    let (sin, cos) = polynomials::<M>(y, tail);
    // The sine turns with the sign of x, and −0 keeps its own.
    let sin_sign = (quadrant << 62 ^ x.to_bits()) & SIGN;
    let cos_sign = quadrant.wrapping_add(1) << 62 & SIGN;
    (
        f64::from_bits(chosen(quadrant, sin, cos) ^ sin_sign),
        f64::from_bits(chosen(quadrant, cos, sin) ^ cos_sign),
    )
}

/// Whether all arguments are reduced here: none is large or not a number.
#[inline(always)]
fn all_reduced(x: &[f64; LANES]) -> bool {
    (x.iter()).fold(true, |fine, x| fine & (x.abs() <= MAX_REDUCED))
}

#[cold]
#[inline(never)]
fn large_replaced(x: [f64; LANES], out: [f64; LANES], function: fn(f64) -> f64) -> [f64; LANES] {
    std::array::from_fn(|k| {
        if x[k].abs() <= MAX_REDUCED {
            out[k]
        } else {
            function(x[k])
        }
    })
}

/// Sines.
#[inline(always)]
pub fn sin<M: Arithmetic>(x: [f64; LANES]) -> [f64; LANES] {
    let mut out = [0.0; LANES];
    for k in 0..LANES {
        out[k] = lane::<M>(x[k]).0;
    }
    if all_reduced(&x) {
        out
    } else {
        large_replaced(x, out, libm::sin)
    }
}

/// Cosines.
#[inline(always)]
pub fn cos<M: Arithmetic>(x: [f64; LANES]) -> [f64; LANES] {
    let mut out = [0.0; LANES];
    for k in 0..LANES {
        out[k] = lane::<M>(x[k]).1;
    }
    if all_reduced(&x) {
        out
    } else {
        large_replaced(x, out, libm::cos)
    }
}
