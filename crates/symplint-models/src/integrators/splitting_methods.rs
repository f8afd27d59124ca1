//! The splitting methods provided.
//!
//! Each comes in two variants that differ by an exchange of drifts and kicks; a variant is named
//! by the drift or kick that is applied first. HLW is E. Hairer, C. Lubich & G. Wanner, Geometric Numerical
//! Integration, 2nd edition.

use super::splitting::{SplittingMethod, Variant};

/// Lie–Trotter splitting, also called symplectic Euler: order 1.
///
/// Position first: drift h, then kick h. Momentum first: kick h, then drift h. Each is the
/// other's adjoint.
pub fn lie_trotter(variant: Variant) -> SplittingMethod {
    SplittingMethod::alternating(
        "lie-trotter",
        1,
        variant,
        &[1.0, 1.0],
        "Barham & Burby, section 4.2; HLW, section VI.3",
    )
}

/// Strang splitting, also called Störmer–Verlet or leapfrog: order 2, symmetric.
///
/// Position first: drift h/2, kick h, drift h/2. Momentum first: kick h/2, drift h, kick h/2.
pub fn strang(variant: Variant) -> SplittingMethod {
    SplittingMethod::alternating(
        "strang",
        2,
        variant,
        &[0.5, 1.0, 0.5],
        "Barham & Burby, appendix D; HLW, section II.5",
    )
}

/// McLachlan's fourth-order method: five Lie–Trotter steps and five adjoint ones, symmetric.
///
/// Its error constant is far smaller than that of [`yoshida4`].
pub fn mclachlan4(variant: Variant) -> SplittingMethod {
    let root = 19.0_f64.sqrt();
    // Fractions of the adjoint step, applied first, and of the step itself, in pairs.
    let adjoint = [
        (14.0 - root) / 108.0,
        (-23.0 - 20.0 * root) / 270.0,
        1.0 / 5.0,
        (-2.0 + 10.0 * root) / 135.0,
        (146.0 + 5.0 * root) / 540.0,
    ];
    // The adjoint begins with the variant's first flow and ends with the other, where the step
    // itself begins; the step ends with the first flow, where the next adjoint begins.
    let mut fractions = vec![adjoint[0]];
    for pair in 0..5 {
        let step = adjoint[4 - pair];
        fractions.push(adjoint[pair] + step);
        fractions.push(step + adjoint.get(pair + 1).unwrap_or(&0.0));
    }
    SplittingMethod::alternating(
        "mclachlan4",
        4,
        variant,
        &fractions,
        "R. I. McLachlan, SIAM J. Sci. Comput. 16 (1995) 151; HLW, section V.3.1",
    )
}

/// The triple jump: three Strang steps make a symmetric method of order 4.
pub fn yoshida4(variant: Variant) -> SplittingMethod {
    let outer = 1.0 / (2.0 - 2.0_f64.cbrt());
    SplittingMethod::composition(
        "yoshida4",
        4,
        &strang(variant),
        &[outer, 1.0 - 2.0 * outer, outer],
        "H. Yoshida, Phys. Lett. A 150 (1990) 262; HLW, section II.4",
    )
}

/// Yoshida's solution A: seven Strang steps make a symmetric method of order 6.
pub fn yoshida6(variant: Variant) -> SplittingMethod {
    const OUTER: [f64; 3] = [
        0.784_513_610_477_557_3,
        0.235_573_213_359_358_13,
        -1.177_679_984_178_871,
    ];
    SplittingMethod::composition(
        "yoshida6",
        6,
        &strang(variant),
        &symmetric(&OUTER),
        "H. Yoshida, Phys. Lett. A 150 (1990) 262, solution A; HLW, section V.3.2",
    )
}

/// Yoshida's solution D: fifteen Strang steps make a symmetric method of order 8.
pub fn yoshida8(variant: Variant) -> SplittingMethod {
    const OUTER: [f64; 7] = [
        0.914_844_246_229_740,
        0.253_693_336_566_229,
        -1.444_852_236_860_48,
        -0.158_240_635_368_243,
        1.938_139_137_622_76,
        -1.960_610_232_975_49,
        0.102_799_849_391_985,
    ];
    SplittingMethod::composition(
        "yoshida8",
        8,
        &strang(variant),
        &symmetric(&OUTER),
        "H. Yoshida, Phys. Lett. A 150 (1990) 262, solution D",
    )
}

/// `outer`, what is missing to a sum of 1, and `outer` backwards.
fn symmetric(outer: &[f64]) -> Vec<f64> {
    let middle = 1.0 - 2.0 * outer.iter().sum::<f64>();
    let forth = outer.iter().copied();
    forth.clone().chain([middle]).chain(forth.rev()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::splitting::Flow;
    use super::*;

    const ALL: [fn(Variant) -> SplittingMethod; 6] = [
        lie_trotter,
        strang,
        mclachlan4,
        yoshida4,
        yoshida6,
        yoshida8,
    ];
    const VARIANTS: [Variant; 2] = [Variant::PositionFirst, Variant::MomentumFirst];

    #[test]
    fn drifts_and_kicks_alternate_and_add_up_to_the_step() {
        for method in ALL {
            for variant in VARIANTS {
                let method = method(variant);
                let substeps = method.substeps();
                assert_eq!(substeps[0].flow, variant.first());
                assert!(substeps.windows(2).all(|pair| pair[0].flow != pair[1].flow));
                for flow in [Flow::Drift, Flow::Kick] {
                    let of_flow = substeps.iter().filter(|substep| substep.flow == flow);
                    let sum: f64 = of_flow.map(|substep| substep.fraction).sum();
                    assert!((sum - 1.0).abs() < 2e-15, "{}: {sum}", method.name());
                }
            }
        }
    }

    #[test]
    fn all_but_lie_trotter_are_palindromes() {
        for method in &ALL[1..] {
            let method = method(Variant::PositionFirst);
            let substeps = method.substeps();
            for (forth, back) in substeps.iter().zip(substeps.iter().rev()) {
                assert_eq!(forth.flow, back.flow);
                assert!(
                    (forth.fraction - back.fraction).abs() < 1e-15,
                    "{}",
                    method.name()
                );
            }
        }
    }

    #[test]
    fn substep_counts_do_not_grow() {
        let count = |method: fn(Variant) -> SplittingMethod| {
            VARIANTS.map(|variant| method(variant).substeps().len())
        };
        assert_eq!(
            ALL.map(count),
            [[2; 2], [3; 2], [11; 2], [7; 2], [15; 2], [31; 2]]
        );
    }

    /// Symmetric compositions of order 2k need Σ γ^(2j+1) = 0 for 0 < j < k (HLW, section V.3.2).
    /// In position-first order every second substep is one kick of fraction γ. The published
    /// fifteen digits of `yoshida8` leave 3e-12.
    #[test]
    fn odd_power_sums_of_the_compositions_vanish() {
        for (method, powers) in [
            (yoshida4 as fn(Variant) -> _, &[3][..]),
            (yoshida6, &[3, 5]),
            (yoshida8, &[3, 5, 7]),
        ] {
            let method = method(Variant::PositionFirst);
            for &power in powers {
                let kicks = method.substeps().iter().filter(|s| s.flow == Flow::Kick);
                let sum: f64 = kicks.map(|s| s.fraction.powi(power)).sum();
                assert!(
                    sum.abs() < 5e-12,
                    "{}, power {power}: {sum:e}",
                    method.name()
                );
            }
        }
    }
}
