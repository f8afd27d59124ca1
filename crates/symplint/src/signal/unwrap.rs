//! Undoing the wrap of periodic positions.

/// Adds whole periods to the samples of one position so that neighbours differ by at most half a
/// period, in place; reperiods the winding, the periods gained once round the loop.
///
/// The first sample stays. A period of 0 means not periodic: nothing changes and the winding is 0.
/// Neighbouring samples of the loop must lie less than half a period apart.
///
/// ```
/// let mut q = [0.1, 0.5, 0.9, 0.3, 0.7];
/// assert_eq!(symplint::unwrap_row(&mut q, 1.0), 2);
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

/// `difference` less whole periods, as near to 0 as can be.
pub(crate) fn nearest(difference: f64, period: f64) -> f64 {
    if period > 0.0 {
        difference - period * (difference / period).round()
    } else {
        difference
    }
}
