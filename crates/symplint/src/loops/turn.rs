//! Sine and cosine of a fraction of a turn.

use std::f64::consts::TAU;

/// (sin 2πs, cos 2πs) for any finite `s`, to about one unit in the last place.
///
/// The reduction to an eighth of a turn is exact, so that quarter turns give exactly 0 and ±1
/// and a loop closes to the last bit: sin(2π·1) by the product with 2π would not be 0.
pub fn sin_cos_turn(s: f64) -> (f64, f64) {
    let fraction = s - s.floor();
    // Nearest multiple of a quarter turn: the rest is at most an eighth and exact.
    let quarter = (fraction * 4.0).round();
    let (sin, cos) = (TAU * (fraction - quarter / 4.0)).sin_cos();
    match quarter as u8 % 4 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_1_SQRT_2;

    #[test]
    fn quarter_turns_are_exact() {
        assert_eq!(sin_cos_turn(0.0), (0.0, 1.0));
        assert_eq!(sin_cos_turn(0.25), (1.0, 0.0));
        assert_eq!(sin_cos_turn(0.5), (0.0, -1.0));
        assert_eq!(sin_cos_turn(0.75), (-1.0, 0.0));
        assert_eq!(sin_cos_turn(1.0), (0.0, 1.0));
        assert_eq!(sin_cos_turn(-3.0), (0.0, 1.0));
    }

    #[test]
    fn agrees_with_the_product_by_two_pi() {
        for k in 0..4000 {
            let s = f64::from(k) / 1000.0 - 1.7;
            let (sin, cos) = sin_cos_turn(s);
            assert!((sin - (TAU * s).sin()).abs() < 4e-15, "sin at {s}");
            assert!((cos - (TAU * s).cos()).abs() < 4e-15, "cos at {s}");
            assert!((sin * sin + cos * cos - 1.0).abs() < 4e-16);
        }
    }

    #[test]
    fn eighths_lie_on_the_diagonals() {
        for (k, (sin_sign, cos_sign)) in [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)]
            .into_iter()
            .enumerate()
        {
            let (sin, cos) = sin_cos_turn((2 * k + 1) as f64 / 8.0);
            assert!((sin - sin_sign * FRAC_1_SQRT_2).abs() < 2e-16);
            assert!((cos - cos_sign * FRAC_1_SQRT_2).abs() < 2e-16);
        }
    }
}
