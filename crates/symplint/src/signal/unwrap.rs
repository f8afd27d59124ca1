//! Undoing the wrap of periodic positions.

use multiversion::multiversion;

/// Adds whole periods to the samples of one position so that neighbours differ by at most half a
/// period, in place; returns the winding, the periods gained once round the loop.
///
/// The first sample stays. A period of 0 means not periodic: nothing changes and the winding is 0.
/// Neighbouring samples of the loop must lie less than half a period apart.
///
/// ```
/// let mut q = [0.1, 0.5, 0.9, 0.3, 0.7];
/// assert_eq!(symplint::signal::unwrap_row(&mut q, 1.0), 2);
/// let expected = [0.1, 0.5, 0.9, 1.3, 1.7];
/// assert!(q.iter().zip(expected).all(|(q, e)| (q - e).abs() < 1e-15));
/// ```
pub fn unwrap_row(row: &mut [f64], period: f64) -> i64 {
    let Some(&first) = row.first().filter(|_| period > 0.0) else {
        return 0;
    };
    let mut previous = first;
    let mut periods = 0.0;
    for value in row.iter_mut() {
        let wrapped = *value;
        periods -= ((wrapped - previous) / period).round();
        previous = wrapped;
        *value = wrapped + periods * period;
    }
    periods -= ((first - previous) / period).round();
    periods as i64
}

/// Unwraps a run of values one by one, as [`unwrap_row`] does a row.
#[derive(Clone, Copy)]
pub(crate) struct Turns {
    /// Not a number before the first value.
    previous: f64,
    /// Periods gained so far.
    pub turns: f64,
}

impl Default for Turns {
    fn default() -> Self {
        Turns {
            previous: f64::NAN,
            turns: 0.0,
        }
    }
}

impl Turns {
    pub fn unwrap(&mut self, wrapped: f64, period: f64) -> f64 {
        if period > 0.0 && !self.previous.is_nan() {
            self.turns -= ((wrapped - self.previous) / period).round();
        }
        self.previous = wrapped;
        wrapped + self.turns * period
    }

    /// The last value, unwrapped.
    pub fn last(&self, period: f64) -> Option<f64> {
        let last = self.previous + self.turns * period;
        (!last.is_nan()).then_some(last)
    }
}

/// Whether neighbouring samples of a position, round the loop, lie about half a period apart or more
/// somewhere. Where they do not, [`unwrap_row`] would change nothing. A period of 0 means
/// not periodic.
#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+avx2", "x86_64+avx2"))]
pub(crate) fn wraps(row: &[f64], period: f64) -> bool {
    if period == 0.0 {
        return false;
    }
    // A little less than half, for the rounding of the division there.
    let limit = 0.499 * period;
    let closing = row[0] - row[row.len() - 1];
    row.iter()
        .zip(&row[1..])
        .fold(closing.abs() > limit, |wraps, (a, b)| {
            wraps | ((b - a).abs() > limit)
        })
}

/// `difference` less whole periods, as near to 0 as can be.
pub(crate) fn nearest(difference: f64, period: f64) -> f64 {
    // Most are within half a period, and to round is slow.
    let is_nearest = difference.abs() < 0.5 * period;
    if period > 0.0 && !is_nearest {
        difference - period * (difference / period).round()
    } else {
        difference
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_unwrapped_as_rows_are() {
        for period in [0.0, 1.0, 0.37] {
            let row: Vec<f64> = (0..100).map(|k| f64::from(k * k % 17) * 0.083).collect();
            let mut unwrapped = row.clone();
            unwrap_row(&mut unwrapped, period);
            let mut turns = Turns::default();
            let one_by_one: Vec<f64> = row.iter().map(|&x| turns.unwrap(x, period)).collect();
            assert_eq!(one_by_one, unwrapped);
        }
    }

    #[test]
    fn rows_that_do_not_wrap_are_those_that_unwrapping_leaves_alone() {
        let period = 3.0;
        for n in 3..40 {
            for step in [0.1, 1.4, 1.496, 1.5, 1.6, 2.9] {
                let mut row: Vec<f64> = (0..n).map(|k| (step * k as f64) % period).collect();
                row[n - 1] = row[0];
                let before = row.clone();
                let wrapped = wraps(&row, period);
                let winding = unwrap_row(&mut row, period);
                assert!(wrapped || (row == before && winding == 0), "{n}, {step}");
            }
        }
        assert!(!wraps(&[0.0, 1e9, -1e9], 0.0));
        assert!(wraps(&[0.0, 0.4, 0.8], 1.0), "the closing cell counts");
    }
}
