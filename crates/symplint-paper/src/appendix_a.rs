//! Appendix A: how fast the pseudospectral rule converges on loops of limited smoothness.

use serde::Serialize;
use symplint::{Ensemble, LoopIntegral, Rule};
use symplint_report::figure::{Figure, Panel, Scale, Style};
use symplint_report::plot::{axis, reference_slope, series};
use symplint_report::run_folder::RunFolder;

use super::claim::{Claim, Judgement, Origin};
use super::settings::{Key, Settings};
use super::sweep::{doublings, power_law, trend_text};
use super::{Item, PaperError};

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
const OFFSET: f64 = 0.297_531_4;

/// Where the kinks of q lie.
const START: f64 = 0.123_456_7;

/// The Bernoulli polynomials of degree m on [0, 1): their periodic continuation has Fourier coefficients
/// −m!/(2πik)^m, so it lies in H^r for every r < m − 1/2.
fn bernoulli(degree: usize, x: f64) -> f64 {
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
fn exact(degree: usize) -> f64 {
    let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
    let sign = if degree.is_multiple_of(2) { -1.0 } else { 1.0 };
    let factor = factorial(degree).powi(2) / factorial(2 * degree - 1);
    sign * factor * bernoulli(2 * degree - 1, -OFFSET)
}

#[derive(Serialize)]
struct Row {
    degree: usize,
    samples: usize,
    measured: f64,
    exact: f64,
    error: f64,
    estimate: Option<f64>,
}

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let (from, to) = (settings.whole("from"), settings.whole("to"));
    let mut rows = Vec::new();
    let mut claims = Vec::new();
    let mut drawn = Vec::new();
    for degree in [2usize, 3, 4] {
        let exact = exact(degree);
        let mut curve = Vec::new();
        for count in doublings(from, to) {
            let samples = count | 1;
            let mut ensemble = Ensemble::zeros(1, samples);
            let mut block = ensemble.block();
            for k in 0..samples {
                let s = k as f64 / samples as f64;
                block.q.row_mut(0)[k] = bernoulli(degree, s + START);
                block.p.row_mut(0)[k] = bernoulli(degree, s + START + OFFSET);
            }
            let integral = LoopIntegral::of(&ensemble, &Rule::Pseudospectral)?;
            let error = (integral.value - exact).abs();
            curve.push((samples as f64, error / exact.abs()));
            rows.push(Row {
                degree,
                samples,
                measured: integral.value,
                exact,
                error,
                estimate: integral.quadrature_error,
            });
        }
        let r = degree as f64 - 0.5;
        let rate = (2.0 * r - 1.0).min(r);
        let measured = power_law(&curve);
        claims.push(Claim {
            item: "appendix-a",
            origin: Origin::Paper,
            place: "appendix A, theorem 1",
            says: format!(
                "loops in H^r, r < {r}, converge at least as N^-min(2r − 1, r) = N^-{rate}"
            ),
            measured: format!(
                "{} for Bernoulli polynomials of degree {degree}",
                trend_text("N", measured)
            ),
            judgement: measured.map_or(Judgement::Unresolved, |measured| {
                Judgement::of(-measured > rate - 0.1)
            }),
        });
        drawn.push(series(
            &format!("r < {r}"),
            curve.clone(),
            Style::LineAndPoints,
            degree - 2,
        ));
        drawn.push(reference_slope(&curve, -(degree as f64), "N"));
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
