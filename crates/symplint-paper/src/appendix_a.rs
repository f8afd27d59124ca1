//! Appendix A: how fast the pseudospectral rule converges on loops of limited smoothness.

use std::f64::consts::{PI, TAU};

use serde::Serialize;
use symplint::{Ensemble, LoopIntegral, Rule};
use symplint_report::figure::{Figure, Panel, Scale, Style};
use symplint_report::plot::{axis, reference_slope, series};
use symplint_report::run_folder::RunFolder;

use super::claim::{Claim, Judgement, Origin};
use super::error::PaperError;
use super::item::Item;
use super::settings::{Key, Settings};
use super::sweep::{doublings, power_law, trend_text};

pub const ITEM: Item = Item {
    id: "appendix-a",
    title: "convergence of the pseudospectral rule on loops in H^r",
    cost: "1 s",
    keys: &[
        Key::whole("from", 1 << 4, 3, "fewest samples, made odd"),
        Key::whole("to", 1 << 16, 3, "most samples, made odd"),
    ],
    check: None,
    run,
};

/// Offset between the kinks of q and those of p, in turns: not on any grid.
pub(super) const OFFSET: f64 = 0.297_531_4;

/// The places of the kinks of q.
pub(super) const START: f64 = 0.123_456_7;

/// The Bernoulli polynomials of degree m on [0, 1): their periodic continuation has Fourier coefficients
/// −m!/(2πik)^m, so it lies in H^r for every r < m − 1/2.
pub(super) fn bernoulli(degree: usize, x: f64) -> f64 {
    let x = x - x.floor();
    let y = x - 0.5;
    let y2 = y * y;
    // In powers of x − 1/2 they are even or odd, and small terms do not cancel.
    match degree {
        1 => y,
        2 => y2 - 1.0 / 12.0,
        3 => y * (y2 - 0.25),
        4 => y2 * (y2 - 0.5) + 7.0 / 240.0,
        5 => y * (y2 * (y2 - 5.0 / 6.0) + 7.0 / 48.0),
        7 => y * (y2 * (y2 * (y2 - 1.75) + 49.0 / 48.0) - 31.0 / 192.0),
        _ => unreachable!("only these degrees are asked for"),
    }
}

/// ∮ p dq for q(s) = B_m(s + a), p(s) = B_m(s + b): (−1)^{m+1} (m!)²/(2m − 1)! B_{2m−1}(a − b).
pub(super) fn exact(degree: usize) -> f64 {
    let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
    let sign = if degree.is_multiple_of(2) { -1.0 } else { 1.0 };
    let factor = factorial(degree).powi(2) / factorial(2 * degree - 1);
    sign * factor * bernoulli(2 * degree - 1, -OFFSET)
}

#[derive(Serialize)]
struct Row {
    curve: String,
    samples: usize,
    measured: f64,
    exact: f64,
    error: f64,
    estimate: Option<f64>,
}

/// A loop of limited smoothness, with its integral in closed form.
pub(super) enum Curve {
    /// Bernoulli polynomials of this degree.
    Bernoulli(usize),
    /// q(s) = Σ_j 2^(−αj) sin(2π 2^j s + φ_j) and p(s) the same sum of cosines, continuous and nowhere smooth: in H^r for every
    /// r < α. ∮ p dq = π Σ_j 2^((1 − 2α)j).
    Lacunary(f64),
}

impl Curve {
    /// Its name in the data, and the r below which it lies in H^r.
    fn smoothness(&self) -> (String, f64) {
        match self {
            Curve::Bernoulli(degree) => (format!("bernoulli {degree}"), *degree as f64 - 0.5),
            Curve::Lacunary(alpha) => (format!("lacunary {alpha}"), *alpha),
        }
    }

    pub(super) fn exact(&self) -> f64 {
        match self {
            Curve::Bernoulli(degree) => exact(*degree),
            Curve::Lacunary(alpha) => PI / (1.0 - 2f64.powf(1.0 - 2.0 * alpha)),
        }
    }

    /// q and p at s = k/samples.
    pub(super) fn at(&self, k: usize, samples: usize) -> (f64, f64) {
        match *self {
            Curve::Bernoulli(degree) => {
                let s = k as f64 / samples as f64;
                (
                    bernoulli(degree, s + START),
                    bernoulli(degree, s + START + OFFSET),
                )
            }
            Curve::Lacunary(alpha) => {
                let (mut q, mut p) = (0.0, 0.0);
                // 2^j k modulo the samples, exactly.
                let mut place = k;
                for j in 0.. {
                    let size = 2f64.powf(-alpha * f64::from(j));
                    if size < MIN_TERM {
                        break;
                    }
                    // Phases that no two terms share.
                    let phase = f64::from(j) * OFFSET;
                    let turns = place as f64 / samples as f64 + phase - phase.floor();
                    q += size * (TAU * turns).sin();
                    p += size * (TAU * turns).cos();
                    place = 2 * place % samples;
                }
                (q, p)
            }
        }
    }

    fn says(&self) -> String {
        match self {
            Curve::Bernoulli(degree) => {
                let r = *degree as f64 - 0.5;
                let rate = (2.0 * r - 1.0).min(r);
                format!("loops in H^r, r < {r}, converge at least as N^-min(2r − 1, r) = N^-{rate}")
            }
            Curve::Lacunary(alpha) => {
                let rate = 2.0 * alpha - 1.0;
                format!(
                    "loops in H^r, r < {alpha}, converge at least as N^-(2r − 1) = N^-{rate:.1} where ½ < r ≤ 1"
                )
            }
        }
    }
}

/// Least term of a lacunary series that is kept.
const MIN_TERM: f64 = 1e-17;

const CURVES: [Curve; 6] = [
    Curve::Lacunary(0.6),
    Curve::Lacunary(0.75),
    Curve::Lacunary(1.0),
    Curve::Bernoulli(2),
    Curve::Bernoulli(3),
    Curve::Bernoulli(4),
];

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let (from, to) = (settings.whole("from"), settings.whole("to"));
    let mut rows = Vec::new();
    let mut claims = Vec::new();
    let mut drawn = Vec::new();
    for (k, loop_curve) in CURVES.iter().enumerate() {
        let exact = loop_curve.exact();
        let (name, r) = loop_curve.smoothness();
        let mut curve = Vec::new();
        for count in doublings(from, to) {
            let samples = count | 1;
            let mut ensemble = Ensemble::zeros(1, samples);
            let mut block = ensemble.block();
            for k in 0..samples {
                let (q, p) = loop_curve.at(k, samples);
                (block.q.row_mut(0)[k], block.p.row_mut(0)[k]) = (q, p);
            }
            let integral = LoopIntegral::of(&ensemble, &Rule::Pseudospectral)?;
            let error = (integral.value - exact).abs();
            curve.push((samples as f64, error / exact.abs()));
            rows.push(Row {
                curve: name.clone(),
                samples,
                measured: integral.value,
                exact,
                error,
                estimate: integral.quadrature_error,
            });
        }
        let rate = (2.0 * r - 1.0).min(r);
        let measured = power_law(&curve);
        claims.push(Claim {
            item: "appendix-a",
            origin: Origin::Paper,
            place: "appendix A, theorem 1",
            says: loop_curve.says(),
            measured: format!("{} for {name}", trend_text("N", measured)),
            judgement: measured.map_or(Judgement::Unresolved, |measured| {
                Judgement::of(-measured > rate - 0.1)
            }),
        });
        drawn.push(series(
            &format!("r < {r}"),
            curve.clone(),
            Style::LineAndPoints,
            k,
        ));
        if let Curve::Bernoulli(degree) = loop_curve {
            drawn.push(reference_slope(&curve, -(*degree as f64), "N"));
        }
    }
    folder.write_csv("appendix_a.csv", &rows)?;
    Figure::new(
        vec![Panel {
            title: "pseudospectral rule, loops in Hʳ".into(),
            x: axis("samples Nₛ", Scale::Log2),
            y: axis("relative error of ∮ p dq", Scale::Log10),
            series: drawn,
            equal_aspect: false,
        }],
        1,
    )
    .save(&folder.figures(), "appendix_a")?;
    Ok(claims)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bernoulli_polynomials_are_derivatives_of_each_other() {
        // B_m' = m B_{m−1}, B_m(0) = the Bernoulli numbers.
        for m in [2, 3, 4, 5] {
            for x in [0.1, 0.4, 0.83] {
                let e = 1e-4;
                let slope = (bernoulli(m, x + e) - bernoulli(m, x - e)) / (2.0 * e);
                assert!(
                    (slope - m as f64 * bernoulli(m - 1, x)).abs() < 1e-7,
                    "degree {m}"
                );
            }
        }
        assert!((bernoulli(4, 0.0) + 1.0 / 30.0).abs() < 1e-15);
        assert!((bernoulli(2, 0.0) - 1.0 / 6.0).abs() < 1e-15);
        assert!(bernoulli(7, 0.0).abs() < 1e-15);
        let x: f64 = 0.3;
        let b7 = x.powi(7) - 3.5 * x.powi(6) + 3.5 * x.powi(5) - 7.0 / 6.0 * x.powi(3) + x / 6.0;
        assert!((bernoulli(7, x) - b7).abs() < 1e-15);
    }

    #[test]
    fn the_integral_of_a_lacunary_series_is_that_of_its_modes() {
        // The chord sum of the first ten terms alone, which 2^16 + 1 samples resolve, and the rest in closed form.
        let alpha = 0.75;
        let terms = |f: &dyn Fn(f64) -> f64| (0..10).map(|j| f(f64::from(j))).sum::<f64>();
        let of_terms = PI * terms(&|j| 2f64.powf((1.0 - 2.0 * alpha) * j));
        let at = |s: f64, of: fn(f64) -> f64| {
            terms(&|j| 2f64.powf(-alpha * j) * of(TAU * (2f64.powf(j) * s + j * OFFSET)))
        };
        let samples = 65_537;
        let sum: f64 = (0..samples)
            .map(|k| [k, k + 1].map(|k| k as f64 / samples as f64))
            .map(|[a, b]| {
                0.5 * (at(a, f64::cos) + at(b, f64::cos)) * (at(b, f64::sin) - at(a, f64::sin))
            })
            .sum();
        assert!((sum / of_terms - 1.0).abs() < 1e-3, "{sum} {of_terms}");
        let rest = 2f64.powf(10.0 * (1.0 - 2.0 * alpha));
        let whole = Curve::Lacunary(alpha).exact();
        assert!((whole * (1.0 - rest) / of_terms - 1.0).abs() < 1e-14);
    }

    #[test]
    fn the_exact_integral_is_that_of_a_fine_sum() {
        for degree in [2, 3, 4] {
            // Midpoint rule on the pieces between kinks, p dq with q' = m B_{m−1}.
            let n = 400_000;
            let sum: f64 = (0..n)
                .map(|k| {
                    let x = (k as f64 + 0.5) / n as f64;
                    bernoulli(degree, x + OFFSET) * degree as f64 * bernoulli(degree - 1, x)
                })
                .sum::<f64>()
                / n as f64;
            assert!(
                (sum - exact(degree)).abs() < 1e-9,
                "degree {degree}: {sum} {}",
                exact(degree)
            );
        }
    }
}
