//! Figure 4: the interpolated pendulum against the step size.

use symplint::Rule;
use symplint::rules::Cutoffs;
use symplint_report::figure::{Figure, Panel};
use symplint_report::number::{raised_power_of_two, short_power};
use symplint_report::plot::{error_axis, reference_slope, step_axis};
use symplint_report::run_folder::RunFolder;

use super::claim::{Claim, Judgement, Origin};
use super::error::PaperError;
use super::interpolated::{CASES, Case, circle_round, pendulum, sweep_case};
use super::item::Item;
use super::settings::{Key, Settings};
use super::sweep::{
    Record, Sweep, chosen_halvings, fitted_order, halvings, halvings_to, order_text, step_of, worst,
};

pub const ITEM: Item = Item {
    id: "fig4",
    title: "interpolated pendulum: defect against the step size",
    cost: "5 s",
    keys: &[
        Key::whole(
            "samples_smooth",
            1 << 16,
            3,
            "samples without interpolation and for degree 3",
        ),
        Key::whole("samples_rough", 1 << 20, 3, "samples for degrees 1 and 2"),
        halvings_to(14),
        Key::number("p0", 0.0, "centre of the loop, momentum"),
        Key::positive("cutoff", 10.0, "λ_q = λ_p of the finite-difference rule"),
    ],
    check: None,
    run,
};

/// The paper's samples: without interpolation and for degree 3, and for degrees 1 and 2.
const PAPER_SMOOTH: usize = 1 << 16;
const PAPER_ROUGH: usize = 1 << 20;

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let smooth = settings.count("samples_smooth");
    let rough = settings.count("samples_rough");
    let steps = chosen_halvings(settings);
    let p0 = settings.number("p0");
    let circle = circle_round(p0)?;
    let cutoffs = Cutoffs::relative(settings.number("cutoff"));
    let mut records: Vec<Record> = Vec::new();
    let mut panels = Vec::new();
    for case in &CASES {
        let samples = if matches!(case.degree, 1 | 2) {
            rough
        } else {
            smooth
        };
        let swept = sweep_case(
            case,
            &circle,
            cutoffs,
            |sweep| sweep.over_steps(samples, &steps),
            Record::over_step,
        )?;
        records.extend(swept.records);
        let mut drawn = swept.curves;
        let rk2 = drawn[1].points.clone();
        drawn.push(reference_slope(
            &rk2,
            if case.broken { 2.0 } else { 4.0 },
            "h",
        ));
        drawn.push(swept.uncertainty);
        panels.push(Panel {
            title: format!(
                "{} (Nₛ = {})",
                case.title,
                raised_power_of_two(samples as f64)
            ),
            x: step_axis(),
            y: error_axis(),
            series: drawn,
            equal_aspect: false,
        });
    }
    Figure::new(panels, 2).save(&folder.figures(), "fig4")?;
    folder.write_csv("fig4.csv", &records)?;
    let mut claims = claims(&records, p0);
    claims.push(expected_slope()?);
    Ok(claims)
}

fn claims(records: &[Record], p0: f64) -> Vec<Claim> {
    let curve = |case: &Case, integrator: &str| curve(records, case, integrator);
    let mut claims = Vec::new();
    for case in CASES.iter().filter(|case| !case.broken) {
        let strang = curve(case, "Strang");
        let largest = worst(strang.iter().copied());
        let bound = strang.iter().map(|r| r.uncertainty()).fold(0.0, f64::max);
        claims.push(Claim {
            item: "fig4",
            origin: Origin::Paper,
            place: "section 4.3",
            says: format!(
                "{}: Strang conserves the loop integral at every step size",
                case.title
            ),
            measured: format!("no defect above {largest:.1e}, uncertainty below {bound:.1e}"),
            judgement: if bound > 1e-6 {
                Judgement::Unresolved
            } else {
                Judgement::of(strang.iter().all(|r| r.defect() <= r.uncertainty()))
            },
        });
        // The paper's loop; round another centre the order is 3.
        if p0 == 0.0 {
            let fit = fitted_order(curve(case, "RK2"));
            claims.push(Claim {
                item: "fig4",
                origin: Origin::Paper,
                place: "section 4.3",
                says: format!("{}: RK2 goes as h⁴", case.title),
                measured: format!(
                    "the midpoint rule goes as {}; its h³ term is odd in p and cancels on a loop centred at p = 0",
                    order_text(fit.as_ref())
                ),
                judgement: fit.map_or(Judgement::Unresolved, |fit| {
                    Judgement::of((fit.slope - 4.0).abs() < 0.1)
                }),
            });
        }
    }
    claims.push(quadrature_below_trends(records));
    claims.extend(linear_resolution(records));
    let linear = &CASES[1];
    let trusted = |r: &&Record| r.step_size >= 2f64.powi(-6);
    let ratio = (curve(linear, "Strang").into_iter().filter(trusted))
        .zip(curve(linear, "RK2").into_iter().filter(trusted))
        .map(|(strang, rk2)| strang.defect() / rk2.defect())
        .fold((f64::INFINITY, 0.0f64), |(low, high), r| {
            (low.min(r), high.max(r))
        });
    claims.push(Claim {
        item: "fig4",
        origin: Origin::Paper,
        place: "section 4.3",
        says: "piecewise linear: Strang and RK2 are largely indistinguishable for h ≥ 2^-6".into(),
        measured: format!(
            "defect of Strang over that of RK2 between {:.2} and {:.2}",
            ratio.0, ratio.1
        ),
        judgement: Judgement::of(ratio.0 > 0.5 && ratio.1 < 2.0),
    });
    claims
}

/// The points of one curve by the paper's rule, the largest step first.
fn curve<'a>(records: &'a [Record], case: &Case, integrator: &str) -> Vec<&'a Record> {
    (records.iter())
        .filter(|r| {
            r.case == case.title && r.integrator == integrator && r.rule == case.rule_name()
        })
        .collect()
}

fn claim(says: &str, measured: String, judgement: Judgement) -> Claim {
    Claim::of_paper("fig4", "section 4.3", says, measured, judgement)
}

/// Judges whether the defects of RK2 stand above the quadrature error wherever it is used.
fn quadrature_below_trends(records: &[Record]) -> Claim {
    let mut texts = Vec::new();
    let (mut above, mut all) = (0, 0);
    let mut paper = true;
    for case in CASES.iter().filter(|case| !case.broken) {
        let rk2 = curve(records, case, "RK2");
        let clear: Vec<_> = rk2
            .iter()
            .take_while(|r| r.defect() > r.uncertainty())
            .collect();
        let samples = if case.degree == 2 {
            PAPER_ROUGH
        } else {
            PAPER_SMOOTH
        };
        paper &= rk2.iter().all(|r| r.samples == samples);
        above += clear.len();
        all += rk2.len();
        texts.push(match clear.last() {
            Some(last) => format!(
                "{}: down to h = {}",
                case.title,
                short_power(last.step_size)
            ),
            None => format!("{}: nowhere", case.title),
        });
    }
    claim(
        "the samples make the quadrature error smaller than the trends of RK2 (pseudospectral rule)",
        format!(
            "so for {above} of {all} defects of RK2; {}",
            texts.join("; ")
        ),
        Judgement::with_correction(above == all, 2 * above >= all).if_resolved(paper),
    )
}

/// Judges what the finite-difference rule resolves with linear splines.
fn linear_resolution(records: &[Record]) -> [Claim; 2] {
    let strang = curve(records, &CASES[1], "Strang");
    let paper = strang.first().is_some_and(|r| r.samples == PAPER_ROUGH);
    let bound = strang.iter().map(|r| r.uncertainty()).fold(0.0, f64::max);
    let digits = -bound.log10();
    // The rest of a defect without the quadrature error must exceed that.
    let trusted = (strang
        .iter()
        .take_while(|r| r.defect() > 2.0 * r.uncertainty()))
    .last();
    let reaches = strang.last().is_some_and(|r| r.step_size < 2f64.powi(-8));
    [
        claim(
            "piecewise linear: O(1/N_s) with 2^20 samples suggests about six digits",
            format!("quadrature error estimated at {bound:.1e}, {digits:.1} digits"),
            Judgement::of(digits >= 5.5).if_resolved(paper && bound.is_finite()),
        ),
        claim(
            "piecewise linear: the error in symplecticity exceeds that of the quadrature for h above about 2^-6",
            match trusted {
                Some(r) => format!(
                    "down to h = {}, where the defect is {:.1e} and the quadrature error {:.1e}",
                    short_power(r.step_size),
                    r.defect(),
                    r.uncertainty()
                ),
                None => "at no step size".into(),
            },
            Judgement::of(
                trusted.is_some_and(|r| (2f64.powi(-7)..=2f64.powi(-5)).contains(&r.step_size)),
            )
            .if_resolved(paper && reaches),
        ),
    ]
}

/// Judges the slope that the paper expects of RK2, on a loop without symmetry.
fn expected_slope() -> Result<Claim, PaperError> {
    let system = pendulum(0)?;
    let circle = circle_round(0.5)?;
    let mut fits = Vec::new();
    for variant in ["midpoint", "heun"] {
        let map = step_of("rk2", variant, &system)?;
        let sweep = Sweep {
            case: CASES[0].title,
            integrator: "RK2",
            map: &*map,
            phase_loop: &circle,
            rule: Rule::Pseudospectral,
        };
        fits.push(fitted_order(
            &sweep.over_steps(1 << 10, &halvings(-1, -10))?,
        ));
    }
    let judgement = match &fits[..] {
        [Some(midpoint), Some(heun)] => Judgement::with_correction(
            [midpoint, heun]
                .iter()
                .all(|fit| (fit.slope - 2.0).abs() < 0.1),
            (midpoint.slope - 3.0).abs() < 0.1 && (heun.slope - 4.0).abs() < 0.1,
        ),
        _ => Judgement::Unresolved,
    };
    Ok(claim(
        "the slope expected of RK2 is 2",
        format!(
            "not interpolated, round (π, ½), a loop without the symmetry: midpoint as {}, Heun as {}; one step of \
             a method of order p is off by O(h^(p+1))",
            order_text(fits[0].as_ref()),
            order_text(fits[1].as_ref())
        ),
        judgement,
    ))
}
