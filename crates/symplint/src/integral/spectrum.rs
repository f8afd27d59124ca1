//! The modes of a transform, in the order in which it leaves them.

use multiversion::multiversion;
use rustfft::num_complex::Complex64;

/// The modes of N samples in classes: mode k is in class k mod C, and the C classes, each in order, stand
/// in bit-reversed order. C is a power of two; with C = 1 the modes are in order.
pub(super) struct Spectrum<'a> {
    z: &'a mut [Complex64],
    /// log₂ C.
    class_bits: u32,
    class_len: usize,
    /// From the start of one class to that of the next.
    stride: usize,
}

impl<'a> Spectrum<'a> {
    /// # Panics
    /// If `classes` is no power of two, or does not divide the number of modes.
    pub fn new(z: &'a mut [Complex64], classes: usize) -> Self {
        assert!(
            classes.is_power_of_two() && z.len().is_multiple_of(classes),
            "{} modes in {classes} classes",
            z.len()
        );
        let class_len = z.len() / classes;
        Spectrum {
            z,
            class_bits: classes.ilog2(),
            class_len,
            stride: class_len,
        }
    }

    /// N.
    #[inline(always)]
    pub fn modes(&self) -> usize {
        self.class_len << self.class_bits
    }

    /// C.
    #[inline(always)]
    pub fn classes(&self) -> usize {
        1 << self.class_bits
    }

    /// The modes k = `class`, `class` + C, `class` + 2 C, ….
    #[inline(always)]
    pub fn class(&self, class: usize) -> &[Complex64] {
        let start = self.stride * reverse_bits(class, self.class_bits);
        &self.z[start..start + self.class_len]
    }

    /// Mode k < N.
    #[inline(always)]
    pub fn mode(&self, k: usize) -> Complex64 {
        let class = k & (self.classes() - 1);
        self.z[self.stride * reverse_bits(class, self.class_bits) + (k >> self.class_bits)]
    }

    /// Of an even number of samples, twice the transform of every second one: modes k and k + N/2 fold
    /// together. The upper half of each class is left over.
    ///
    /// # Panics
    /// If classes have an odd number of modes.
    pub fn fold(self) -> Self {
        assert!(self.class_len.is_multiple_of(2), "{} modes", self.class_len);
        fold_classes(self.z, self.stride, self.class_len);
        Spectrum {
            class_len: self.class_len / 2,
            ..self
        }
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

/// Adds the upper half of each class to the lower.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
fn fold_classes(z: &mut [Complex64], stride: usize, class_len: usize) {
    for class in z.chunks_exact_mut(stride) {
        let (lower, upper) = class[..class_len].split_at_mut(class_len / 2);
        for (low, high) in lower.iter_mut().zip(&*upper) {
            *low += high;
        }
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
            let mut z = in_classes(&z, classes);
            let folded = Spectrum::new(&mut z, classes).fold();
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
            let mut z = in_classes(&z, classes);
            let spectrum = Spectrum::new(&mut z, classes);
            for k in 0..32 {
                assert_eq!(spectrum.mode(k).re, k as f64);
                assert_eq!(spectrum.class(k % classes)[k / classes].re, k as f64);
            }
        }
    }
}
