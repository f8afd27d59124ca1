//! How far a loop integral moved: the figure of merit.

use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::rules::LoopIntegral;

/// The relative change of a loop integral over one step, with its uncertainty.
///
/// All numbers are relative to the absolute value of the initial loop integral.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Defect {
    /// (I(h) − I(0)) / |I(0)|.
    pub signed: f64,
    /// Quadrature errors of both integrals; `None` where one is not known.
    pub quadrature_error: Option<f64>,
    /// Round-off of both integrals.
    pub roundoff: f64,
}

impl Defect {
    /// Compares the loop integrals before and after a step.
    ///
    /// # Errors
    /// If the initial loop integral is zero to round-off, so that nothing is relative to it.
    pub fn between(initial: &LoopIntegral, advanced: &LoopIntegral) -> Result<Self, Error> {
        let size = initial.value.abs();
        // Round-off is an estimate: a loop integral that it all but covers measures nothing.
        if size <= 100.0 * initial.roundoff {
            // What cancels in part has no area; what does not is drowned.
            if size > 0.1 * initial.scale {
                return Err(Error::LostInRounding {
                    integral: initial.value,
                    roundoff: initial.roundoff,
                });
            }
            return Err(Error::NoArea {
                integral: initial.value,
                scale: initial.scale,
            });
        }
        let errors = initial.quadrature_error.zip(advanced.quadrature_error);
        Ok(Defect {
            signed: (advanced.value - initial.value) / size,
            quadrature_error: errors.map(|(a, b)| (a + b) / size),
            roundoff: (initial.roundoff + advanced.roundoff) / size,
        })
    }

    /// E(h, N_s) = |I(h) − I(0)| / |I(0)|: Barham & Burby, section 3.1.
    pub fn magnitude(&self) -> f64 {
        self.signed.abs()
    }

    /// Half the width of the interval in which the true defect lies, by the estimates: quadrature error
    /// and round-off together. Infinite where the quadrature error is not known.
    pub fn uncertainty(&self) -> f64 {
        self.quadrature_error.unwrap_or(f64::INFINITY) + self.roundoff
    }
}

/// exp(log |I(h)| − log |I(0)|) − 1, the logarithmic form of the defect in section 3.1 of
/// Barham & Burby, by expm1; `None` unless both integrals are non-zero and have one sign.
///
/// In floating point it is not better than the difference that [`Defect`] takes: two nearby
/// numbers are subtracted without error, while each logarithm is rounded, in absolute
/// terms the worse the further the integral is from 1.
pub fn logarithmic_defect(initial: f64, advanced: f64) -> Option<f64> {
    // Not by their product, which may under- or overflow.
    let one_sign = (initial > 0.0 && advanced > 0.0) || (initial < 0.0 && advanced < 0.0);
    one_sign.then(|| (advanced.abs().ln() - initial.abs().ln()).exp_m1())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exactly(value: f64) -> LoopIntegral {
        LoopIntegral {
            value,
            contributions: vec![value],
            quadrature_error: Some(0.0),
            roundoff: 0.0,
            scale: value.abs(),
            omitted: None,
            regularity: None,
        }
    }

    #[test]
    fn the_sign_tells_growth_of_the_enclosed_area() {
        let defect = |a, b| Defect::between(&exactly(a), &exactly(b)).unwrap().signed;
        assert_eq!(defect(2.0, 3.0), 0.5);
        assert_eq!(defect(2.0, 1.0), -0.5);
        assert_eq!(defect(-2.0, -1.0), 0.5);
        assert_eq!(defect(2.0, -42.0), -22.0);
    }

    #[test]
    fn no_area_is_an_error() {
        let mut flat = exactly(1e-17);
        (flat.roundoff, flat.scale) = (1e-16, 1.0);
        let error = Defect::between(&flat, &exactly(1.0)).unwrap_err();
        assert!(error.to_string().contains("encloses no area"), "{error}");
    }

    #[test]
    fn a_loop_below_its_rounding_is_another() {
        let mut far = exactly(3.0);
        far.roundoff = 0.5;
        let error = Defect::between(&far, &exactly(3.0)).unwrap_err();
        assert!(
            error.to_string().contains("too small for double precision"),
            "{error}"
        );
    }

    #[test]
    fn the_logarithmic_form_agrees_but_is_not_more_accurate() {
        // A million pendula: I = 4096 π, one unit in the last place apart.
        let initial = 4096.0 * std::f64::consts::PI;
        let advanced = initial * (1.0 + 4.0 * f64::EPSILON);
        let exact = (advanced - initial) / initial;
        let logarithmic = logarithmic_defect(initial, advanced).unwrap();
        assert!((exact - 4.0 * f64::EPSILON).abs() < f64::EPSILON);
        assert!((logarithmic - exact).abs() > 0.5 * f64::EPSILON);
        let far = logarithmic_defect(2.0, 2.5).unwrap();
        assert!((far - 0.25).abs() < 1e-15);
        assert_eq!(logarithmic_defect(1.0, -1.0), None);
        assert_eq!(logarithmic_defect(0.0, 0.0), None);
        // Products of these under- and overflow.
        assert_eq!(logarithmic_defect(1e-200, 1e-200), Some(0.0));
        assert_eq!(logarithmic_defect(-1e200, -1e200), Some(0.0));
    }

    #[test]
    fn a_loop_is_measured_where_it_is_a_hundred_times_its_rounding() {
        let mut loop_integral = exactly(3.0);
        loop_integral.roundoff = 0.029;
        assert!(Defect::between(&loop_integral, &exactly(3.0)).is_ok());
        loop_integral.roundoff = 0.031;
        let error = Defect::between(&loop_integral, &exactly(3.0)).unwrap_err();
        assert!(matches!(error, Error::LostInRounding { .. }), "{error}");
        // If the terms of the integral cancel to less than a tenth, the error is that the loop has no area.
        for (scale, is_lost) in [(29.0, true), (31.0, false)] {
            loop_integral.scale = scale;
            let error = Defect::between(&loop_integral, &exactly(3.0)).unwrap_err();
            assert_eq!(
                matches!(error, Error::LostInRounding { .. }),
                is_lost,
                "{error}"
            );
        }
    }

    #[test]
    fn logarithms_of_zero_are_none() {
        for other in [1.0, -1.0] {
            assert_eq!(logarithmic_defect(0.0, other), None);
            assert_eq!(logarithmic_defect(other, 0.0), None);
        }
    }
}
