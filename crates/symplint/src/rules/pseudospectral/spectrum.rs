//! The modes of a transform, in the order in which it leaves them.

use std::slice::from_mut;

use pulp::Simd;
use pulp::bytemuck::{cast_slice, cast_slice_mut};
use rustfft::num_complex::Complex64;

/// The modes of N samples in classes: mode k is in class k mod C, at place ⌊k/C⌋ of it. C is a power of two.
pub(super) trait Modes {
    /// One class.
    type Class<'a>: Class
    where
        Self: 'a;

    /// N.
    fn modes(&self) -> usize;

    /// log₂ C.
    fn class_bits(&self) -> u32;

    /// The modes of a class.
    fn class(&self, class: usize) -> Self::Class<'_>;

    /// Mode k < N.
    #[inline(always)]
    fn mode(&self, k: usize) -> Complex64 {
        let classes = 1 << self.class_bits();
        self.class(k & (classes - 1)).at(k >> self.class_bits())
    }
}

/// Modes of one class.
pub(super) trait Class {
    /// The mode at a place.
    fn at(&self, place: usize) -> Complex64;

    /// As many modes from a place on as a register has lanes.
    fn run<S: Simd>(&self, simd: S, place: usize) -> Parts<S>;
}

/// Modes, one in each lane, in an order of the processor's: the same in all that are taken by [`Class::run`].
#[derive(Clone, Copy)]
pub(super) struct Parts<S: Simd> {
    pub re: S::f64s,
    pub im: S::f64s,
}

impl<S: Simd> Parts<S> {
    /// From two registers of modes as they stand in memory.
    #[inline(always)]
    fn of(simd: S, modes: [S::f64s; 2]) -> Self {
        let [re, im] = simd.deinterleave_shfl_f64s(modes);
        Parts { re, im }
    }

    /// The last mode first: the order of lanes is such that its reverse is that of reversed modes.
    #[inline(always)]
    pub fn reversed(self) -> Self {
        Parts {
            re: reversed::<S>(self.re),
            im: reversed::<S>(self.im),
        }
    }
}

#[inline(always)]
fn reversed<S: Simd>(mut lanes: S::f64s) -> S::f64s {
    cast_slice_mut::<_, f64>(from_mut(&mut lanes)).reverse();
    lanes
}

/// Two registers of modes, as they stand in memory.
///
/// # Panics
/// If there are not so many.
#[inline(always)]
fn registers<S: Simd>(modes: &[Complex64]) -> [S::f64s; 2] {
    let (registers, _) = S::as_simd_f64s(cast_slice(&modes[..S::F64_LANES]));
    [registers[0], registers[1]]
}

impl Class for &[Complex64] {
    #[inline(always)]
    fn at(&self, place: usize) -> Complex64 {
        self[place]
    }

    #[inline(always)]
    fn run<S: Simd>(&self, simd: S, place: usize) -> Parts<S> {
        Parts::of(simd, registers::<S>(&self[place..]))
    }
}

/// A whole transform. Its classes, each in order, stand in bit-reversed order; with C = 1 the modes are in
/// order.
#[derive(Clone, Copy)]
pub(super) struct Spectrum<'a> {
    z: &'a [Complex64],
    class_bits: u32,
}

impl<'a> Spectrum<'a> {
    /// # Panics
    /// If `classes` is no power of two, or does not divide the number of modes.
    pub fn new(z: &'a [Complex64], classes: usize) -> Self {
        assert!(
            classes.is_power_of_two() && z.len().is_multiple_of(classes),
            "{} modes in {classes} classes",
            z.len()
        );
        Spectrum {
            z,
            class_bits: classes.ilog2(),
        }
    }
}

impl Modes for Spectrum<'_> {
    type Class<'a>
        = &'a [Complex64]
    where
        Self: 'a;

    #[inline(always)]
    fn modes(&self) -> usize {
        self.z.len()
    }

    #[inline(always)]
    fn class_bits(&self) -> u32 {
        self.class_bits
    }

    #[inline(always)]
    fn class(&self, class: usize) -> &[Complex64] {
        let len = self.z.len() >> self.class_bits;
        let start = len * reverse_bits(class, self.class_bits);
        &self.z[start..start + len]
    }
}

/// Of an even number of samples, twice the transform of every second one: modes k and k + N/2 fold together.
#[derive(Clone, Copy)]
pub(super) struct Folded<'a>(Spectrum<'a>);

impl<'a> Folded<'a> {
    /// # Panics
    /// If classes have an odd number of modes.
    pub fn new(spectrum: Spectrum<'a>) -> Self {
        let class_len = spectrum.modes() >> spectrum.class_bits;
        assert!(class_len.is_multiple_of(2), "{class_len} modes in a class");
        Folded(spectrum)
    }
}

impl Modes for Folded<'_> {
    type Class<'a>
        = FoldedClass<'a>
    where
        Self: 'a;

    #[inline(always)]
    fn modes(&self) -> usize {
        self.0.modes() / 2
    }

    #[inline(always)]
    fn class_bits(&self) -> u32 {
        self.0.class_bits
    }

    #[inline(always)]
    fn class(&self, class: usize) -> FoldedClass<'_> {
        let class = self.0.class(class);
        let (lower, upper) = class.split_at(class.len() / 2);
        FoldedClass { lower, upper }
    }
}

/// One class of [`Folded`] modes: the sums of these.
pub(super) struct FoldedClass<'a> {
    lower: &'a [Complex64],
    upper: &'a [Complex64],
}

impl Class for FoldedClass<'_> {
    #[inline(always)]
    fn at(&self, place: usize) -> Complex64 {
        self.lower[place] + self.upper[place]
    }

    #[inline(always)]
    fn run<S: Simd>(&self, simd: S, place: usize) -> Parts<S> {
        let [lower, next_lower] = registers::<S>(&self.lower[place..]);
        let [upper, next_upper] = registers::<S>(&self.upper[place..]);
        let folded = simd.add_f64s(lower, upper);
        Parts::of(simd, [folded, simd.add_f64s(next_lower, next_upper)])
    }
}

/// The lowest `bits` bits of `class` in reverse order; there are no others.
#[inline(always)]
fn reverse_bits(class: usize, bits: u32) -> usize {
    match bits {
        0 => 0,
        _ => class.reverse_bits() >> (usize::BITS - bits),
    }
}

/// Puts modes that are in order into so many classes.
#[cfg(test)]
pub(super) fn in_classes(z: &[Complex64], classes: usize) -> Vec<Complex64> {
    (0..classes)
        .flat_map(|i| {
            let class = z.iter().skip(reverse_bits(i, classes.ilog2()));
            class.step_by(classes).copied()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use pulp::Scalar;

    use super::*;

    #[test]
    fn a_folded_transform_is_twice_that_of_every_second_sample() {
        let n = 48;
        let samples: Vec<Complex64> = (0..n)
            .map(|k| Complex64::new((1.3 * (k * k) as f64).sin(), (0.7 * k as f64).cos()))
            .collect();
        let slow = |samples: &[Complex64], k: usize| -> Complex64 {
            let turn = std::f64::consts::TAU * k as f64 / samples.len() as f64;
            (samples.iter().enumerate())
                .map(|(j, z)| z * Complex64::from_polar(1.0, -turn * j as f64))
                .sum()
        };
        let z: Vec<Complex64> = (0..n).map(|k| slow(&samples, k)).collect();
        let second: Vec<Complex64> = samples.iter().step_by(2).copied().collect();
        for classes in [1, 2, 4, 8] {
            let z = in_classes(&z, classes);
            let folded = Folded::new(Spectrum::new(&z, classes));
            assert_eq!(folded.modes(), n / 2);
            for k in 0..n / 2 {
                assert!((folded.mode(k) / 2.0 - slow(&second, k)).norm() < 1e-12);
            }
        }
    }

    #[test]
    fn classes_hold_every_mode_in_its_place() {
        let z: Vec<Complex64> = (0..32).map(|k| Complex64::new(k as f64, 0.0)).collect();
        for classes in [1, 2, 4, 8, 16] {
            let z = in_classes(&z, classes);
            let spectrum = Spectrum::new(&z, classes);
            for k in 0..32 {
                assert_eq!(spectrum.mode(k).re, k as f64);
                let run = spectrum.class(k % classes).run(Scalar, k / classes);
                assert_eq!(run.re, k as f64);
            }
        }
    }
}
