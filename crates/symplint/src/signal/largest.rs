//! The largest of many numbers.

use multiversion::multiversion;

/// The largest absolute value of a row; 0 of an empty one.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
pub(crate) fn largest(row: &[f64]) -> f64 {
    // Absolute values are ordered as their bits are, and the largest integer is found in vector registers.
    let bits = row.iter().fold(0, |m: u64, x| m.max(x.abs().to_bits()));
    f64::from_bits(bits)
}

#[cfg(test)]
mod tests {
    use super::largest;

    #[test]
    fn signs_do_not_count() {
        for n in 0..40 {
            let row: Vec<f64> = (0..n).map(|k| (1.7 * k as f64).sin()).collect();
            let expected = row.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            assert_eq!(largest(&row), expected, "{n}");
        }
        assert_eq!(largest(&[-3.0, 2.0, -0.0]), 3.0);
        assert_eq!(largest(&[0.0, -5e-324]), 5e-324);
    }
}
