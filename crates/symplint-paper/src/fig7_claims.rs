//! What section 5.2 says of figure 7.

use symplint_report::number::short_power;

use super::claim::{Claim, Judgement};
use super::estimate::Estimate;
use super::pic::{Case, Curves, PLASMAS, Setup};
use super::sweep::{Record, fitted_order, order_text, worst};
use super::true_defect;

/// The claims of the paper are about this number of samples and this number of particles.
const SAMPLES: usize = 1 << 15;
const PARTICLES: usize = 2;

/// Least ratio of the largest and the smallest step size of the paper.
const MIN_STEP_RANGE: f64 = 100.0;

/// Two or three orders of magnitude above machine precision, rounded up to half an order.
const MAX_ORDERS: f64 = 3.5;

/// Largest factor of a modest reduction.
const MAX_MODEST_FACTOR: f64 = 10.0;

/// Judges figure 7.
pub fn claims(curves: &Curves, setup: &Setup, samples: usize) -> Vec<Claim> {
    let paper = samples == SAMPLES && setup.particles == PARTICLES;
    let mut claims = [breaks(curves), indistinguishable(curves)]
        .map(|claim| claim.resolved_if(paper))
        .to_vec();
    for (degree, name, digits, says) in [
        (2, "quadratic", 9.0, "about nine digits"),
        (3, "cubic", 13.0, "about 13 to 14 digits"),
    ] {
        let case = |plasma| Case {
            plasma,
            degree,
            passes: 0,
        };
        let strang = PLASMAS.map(|plasma| curves.of(case(plasma), "Strang"));
        let carried = paper && strang.iter().all(|records| covers(records));
        claims.push(digits_claim(name, says, digits, strang).resolved_if(carried));
        claims.push(above_precision(name, strang).resolved_if(carried));
        claims.push(reduction(name, strang).resolved_if(carried));
        for plasma in PLASMAS {
            let claim = trend(&case(plasma).name(), curves.of(case(plasma), "RK2"));
            claims.push(claim.resolved_if(carried));
        }
    }
    claims
}

fn claim(says: String, measured: String, judgement: Judgement) -> Claim {
    Claim::of_paper("fig7", "section 5.2", says, measured, judgement)
}

/// Whether the step sizes are those that the paper speaks of: from 1/2 over two orders of magnitude.
fn covers(records: &[Record]) -> bool {
    let sizes = || records.iter().map(|r| r.step_size);
    let (high, low) = (
        sizes().fold(0.0, f64::max),
        sizes().fold(f64::INFINITY, f64::min),
    );
    high >= 0.5 && high >= MIN_STEP_RANGE * low
}

/// The larger |E| of both plasmas at each step size, the largest step first, known to its round-off.
fn of_both(strang: [&[Record]; 2]) -> Vec<(f64, Estimate)> {
    let of = |r: &Record| Estimate {
        size: r.defect(),
        error: r.roundoff,
    };
    (strang[0].iter().zip(strang[1]))
        .map(|(a, b)| (a.step_size, of(a).max(of(b))))
        .collect()
}

/// Whether these defects are the error of the quadrature, by the piecewise rule.
fn cause(strang: [&[Record]; 2]) -> String {
    let truth = true_defect::largest(strang.into_iter().flatten());
    let of_rule = strang.into_iter().flatten();
    let of_rule = of_rule.filter(|r| r.rule_error().is_some_and(|error| error.size > error.error));
    format!(
        "by the piecewise rule the true defects are below {truth:.1e}, so that {} of {} are known quadrature errors",
        of_rule.count(),
        strang[0].len() + strang[1].len()
    )
}

fn digits_claim(name: &str, says: &str, digits: f64, strang: [&[Record]; 2]) -> Claim {
    let largest = worst(strang.into_iter().flatten());
    let measured = -largest.log10();
    // The number of digits that the rule gives says nothing about the map unless the map keeps as many.
    let truth = true_defect::largest(strang.into_iter().flatten());
    claim(
        format!("{name}: Strang conserves the loop integral to {says}"),
        format!(
            "no defect above {largest:.1e} at any step size, {measured:.1} digits; {}",
            cause(strang)
        ),
        Judgement::with_correction(measured >= digits - 0.5, measured >= digits - 2.0)
            .if_resolved(truth < 10f64.powf(0.5 - digits)),
    )
}

fn above_precision(name: &str, strang: [&[Record]; 2]) -> Claim {
    let both = of_both(strang);
    let orders = |defect: f64| (defect / f64::EPSILON).max(1.0).log10();
    let most = (both.iter().map(|p| orders(p.1.size))).fold(0.0, f64::max);
    // From the small steps up, as far as the claim holds.
    let within = (both.iter().rev()).take_while(|p| orders(p.1.size) <= MAX_ORDERS);
    let within: Vec<&(f64, Estimate)> = within.collect();
    let from = within.last().map_or("no step size".into(), |p| {
        format!("h = {} down", short_power(p.0))
    });
    let truth = true_defect::largest(strang.into_iter().flatten());
    claim(
        format!(
            "{name}: Strang conserves the loop integral to within two or three orders of magnitude of machine \
             precision"
        ),
        format!(
            "up to {most:.1} orders above 2.2e-16 at the largest steps; within {MAX_ORDERS} from {from}; the true defects \
             are below {truth:.1e}"
        ),
        Judgement::with_correction(within.len() == both.len(), 2 * within.len() >= both.len())
            .if_resolved(orders(truth) <= MAX_ORDERS),
    )
}

fn reduction(name: &str, strang: [&[Record]; 2]) -> Claim {
    let both = of_both(strang);
    let says =
        format!("{name}: the defect of Strang is only modestly reduced as the step is refined");
    let Some((first, last)) = both.first().zip(both.last()) else {
        return claim(says, "nothing".into(), Judgement::Unresolved);
    };
    let factor = first.1.factor_over(last.1);
    claim(
        says,
        format!(
            "from {:.1e} at h = {} to {:.1e} at h = {}, by a factor of {:.0} to {:.0}; {}",
            first.1.size,
            short_power(first.0),
            last.1.size,
            short_power(last.0),
            factor.0,
            factor.1,
            cause(strang)
        ),
        Judgement::of_interval(factor, (0.0, MAX_MODEST_FACTOR)),
    )
}

fn trend(case: &str, rk2: &[Record]) -> Claim {
    let fit = fitted_order(rk2);
    let clear = rk2
        .iter()
        .filter(|r| r.defect() > 50.0 * r.uncertainty())
        .count();
    claim(
        format!("{case}: RK2 clearly follows a convergence trend"),
        format!("its defect goes as {}", order_text(fit.as_ref())),
        match fit {
            Some(fit) => Judgement::of((2.5..6.5).contains(&fit.slope)),
            // Clear defects without a law are no trend; defects that are not clear say nothing.
            None => Judgement::DoesNotHold.if_resolved(clear >= 4),
        },
    )
}

/// Linear splines: the points of both integrators that exceed their uncertainty clearly, if it is known.
fn clear_pairs(curves: &Curves) -> Vec<(&Record, &Record)> {
    let clear = |r: &Record| r.defect() > 3.0 * r.uncertainty();
    (PLASMAS.into_iter())
        .flat_map(|plasma| {
            let case = Case {
                plasma,
                degree: 1,
                passes: 0,
            };
            (curves.of(case, "Strang").iter()).zip(curves.of(case, "RK2"))
        })
        .filter(|(strang, rk2)| clear(strang) && clear(rk2))
        .collect()
}

/// Least number of step sizes, over both plasmas, for a claim on linear splines.
const MIN_STEP_SIZES: usize = 4;

fn breaks(curves: &Curves) -> Claim {
    let pairs = clear_pairs(curves);
    let text = match (pairs.iter()).max_by(|a, b| a.0.defect().total_cmp(&b.0.defect())) {
        Some((strang, _)) => format!(
            "defect of Strang {:.1e} at h = {}, quadrature error {:.1e}; above three times its uncertainty at {} \
             pairs of plasma and step size",
            strang.defect(),
            short_power(strang.step_size),
            strang.uncertainty(),
            pairs.len()
        ),
        None => "no defect stands clear of the quadrature error".into(),
    };
    let largest = worst(pairs.iter().map(|pair| pair.0));
    claim(
        "linear: Strang fails to be symplectic".into(),
        text,
        Judgement::of(largest > 1e-3).if_resolved(pairs.len() >= MIN_STEP_SIZES),
    )
}

fn indistinguishable(curves: &Curves) -> Claim {
    let pairs = clear_pairs(curves);
    let (low, high) = (pairs.iter())
        .map(|(strang, rk2)| strang.defect() / rk2.defect())
        .fold((f64::INFINITY, 0.0f64), |(l, h), ratio| {
            (l.min(ratio), h.max(ratio))
        });
    claim(
        "linear: no discernible difference between Strang and RK2".into(),
        match pairs.len() {
            0 => "no defect stands clear of the quadrature error".into(),
            count => format!(
                "defect of Strang over that of RK2 between {low:.2} and {high:.2} at the {count} pairs of plasma \
                 and step size where both exceed three times their uncertainty"
            ),
        },
        Judgement::of(low > 0.5 && high < 2.0).if_resolved(pairs.len() >= MIN_STEP_SIZES),
    )
}
