//! The modes of a transform, in the order in which it leaves them.

use std::array::from_fn;

use rustfft::num_complex::Complex64;

/// The modes of N samples in classes: mode k is in class k mod C, at place ⌊k/C⌋ of it. C is a power of two.
pub(super) trait Modes {
    /// N.
    fn modes(&self) -> usize;

    /// log₂ C.
    fn class_bits(&self) -> u32;

    /// The modes of a class from a place on.
    fn run<const COUNT: usize>(&self, class: usize, place: usize) -> [Complex64; COUNT];

    /// Mode k < N.
    #[inline(always)]
    fn mode(&self, k: usize) -> Complex64 {
        let classes = 1 << self.class_bits();
        let [mode] = self.run(k & (classes - 1), k >> self.class_bits());
        mode
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

    #[inline(always)]
    fn class(&self, class: usize) -> &[Complex64] {
        let len = self.z.len() >> self.class_bits;
        let start = len * reverse_bits(class, self.class_bits);
        &self.z[start..start + len]
    }
}

impl Modes for Spectrum<'_> {
    #[inline(always)]
    fn modes(&self) -> usize {
        self.z.len()
    }

    #[inline(always)]
    fn class_bits(&self) -> u32 {
        self.class_bits
    }

    #[inline(always)]
    fn run<const COUNT: usize>(&self, class: usize, place: usize) -> [Complex64; COUNT] {
        *first_of(&self.class(class)[place..])
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
    #[inline(always)]
    fn modes(&self) -> usize {
        self.0.modes() / 2
    }

    #[inline(always)]
    fn class_bits(&self) -> u32 {
        self.0.class_bits
    }

    #[inline(always)]
    fn run<const COUNT: usize>(&self, class: usize, place: usize) -> [Complex64; COUNT] {
        let class = self.0.class(class);
        let (lower, upper) = class.split_at(class.len() / 2);
        let lower: &[Complex64; COUNT] = first_of(&lower[place..]);
        let upper: &[Complex64; COUNT] = first_of(&upper[place..]);
        from_fn(|i| lower[i] + upper[i])
    }
}

/// # Panics
/// If there are not so many.
#[inline(always)]
fn first_of<const COUNT: usize>(modes: &[Complex64]) -> &[Complex64; COUNT] {
    modes
        .first_chunk()
        .expect("runs end where their class does")
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
                let [mode] = spectrum.run(k % classes, k / classes);
                assert_eq!(mode.re, k as f64);
            }
        }
    }
}
