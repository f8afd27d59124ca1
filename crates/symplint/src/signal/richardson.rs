//! Richardson's extrapolation of a sequence to distance zero.

/// The table of a sequence at distances that are divided by `ratio` from level to level. Its errors are powers
/// t^`first`, t^(`first` + 2), … of the distance t: entry `[level][depth]` is free of the first `depth` of them.
pub(crate) fn extrapolate<const DEPTHS: usize, const LEVELS: usize>(
    sequence: impl Iterator<Item = f64>,
    ratio: f64,
    first: i32,
) -> [[f64; DEPTHS]; LEVELS] {
    let mut table = [[0.0; DEPTHS]; LEVELS];
    for (level, value) in sequence.enumerate() {
        table[level][0] = value;
        for depth in 1..=level.min(DEPTHS - 1) {
            let (fine, coarse) = (table[level][depth - 1], table[level - 1][depth - 1]);
            let factor = ratio.powi(first + 2 * (depth as i32 - 1));
            table[level][depth] = fine + (fine - coarse) / (factor - 1.0);
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::extrapolate;

    #[test]
    fn each_depth_removes_one_power() {
        let f = |t: f64| 3.0 - 0.7 * t.powi(2) + 0.4 * t.powi(4);
        let levels = [1.0, 0.5, 0.25].map(f);
        let table: [[f64; 3]; 3] = extrapolate(levels.into_iter(), 2.0, 2);
        assert!((table[2][2] - 3.0).abs() < 1e-14);
        // The remainder of t⁴ falls by 16 from one level to the next.
        let errors = [table[1][1] - 3.0, table[2][1] - 3.0];
        assert!((errors[0] / errors[1] - 16.0).abs() < 1e-9);
    }
}
