//! Section 3.3: maps that are conjugate to symplectic ones, after one step and after many.

use std::sync::Arc;

use serde::Serialize;
use symplint::{Circle, Defect, Ensemble, LoopIntegral, Phases, Rule, TimeAdvance};
use symplint_models::Separable;
use symplint_models::integrators::catalogue::build;
use symplint_models::systems::HenonHeiles;
use symplint_report::figure::{Figure, Panel, Scale, Style};
use symplint_report::number::{raised_power_of_two, short_power};
use symplint_report::plot::{axis, error_axis, series};
use symplint_report::run_folder::RunFolder;

use super::claim::{Claim, Judgement};
use super::error::PaperError;
use super::item::Item;
use super::settings::{Key, SettingError, Settings, check_steps};
use super::sweep::{Line, halvings, line_text, power_law_line};

pub const ITEM: Item = Item {
    id: "near-symplectic",
    title: "conjugate symplectic and energy-conserving methods, one step and many (section 3.3)",
    cost: "2 s",
    keys: &[
        Key::whole("samples", 512, 32, "samples of the loop"),
        Key::positive("radius", 0.05, "radius of the loop"),
        Key::positive("time", 50.0, "how long the loop is followed"),
    ],
    check: Some(check),
    run,
};

/// Step sizes are 2^-COARSEST … 2^-FINEST.
const COARSEST: i32 = 2;
const FINEST: i32 = 5;

/// Largest rounding error of some thousand steps, relative to the integral.
const MAX_ROUNDING_ERROR: f64 = 1e-11;

/// Steps of one loop, at the largest step size and at the smallest one.
const STEPS: [f64; 2] = [10.0, 1e6];

fn check(settings: &Settings) -> Result<(), SettingError> {
    let time = ("time", settings.number("time"));
    let [fewest, most] = STEPS;
    check_steps(time, 0.5f64.powi(COARSEST), [fewest, f64::INFINITY])?;
    check_steps(time, 0.5f64.powi(FINEST), [0.0, most])
}

/// The quantities that are followed, and the section's statements about them.
const METHODS: [(&str, Option<&str>); 5] = [
    ("trapezoidal", None),
    ("averaged-vector-field", None),
    ("strang", Some("momentum-first")),
    // Positions at whole steps and momenta half a step before them.
    ("lie-trotter", Some("momentum-first")),
    ("rk2", Some("midpoint")),
];

/// The methods of the figure, with the titles of their panels. The staggered leapfrog looks as Strang's splitting does.
const DRAWN: [(&str, &str); 4] = [
    ("trapezoidal", "trapezoidal rule"),
    ("averaged-vector-field", "averaged vector field"),
    ("strang", "Strang splitting"),
    ("rk2", "RK2 (midpoint)"),
];

#[derive(Serialize)]
struct Row {
    integrator: &'static str,
    step_size: f64,
    time: f64,
    defect: f64,
}

/// The loop of one method at one step size: its defect after one step, and at about 200 times.
struct LoopHistory {
    h: f64,
    first: f64,
    /// The largest of how far off a defect may be.
    uncertainty: f64,
    over_time: Vec<(f64, f64)>,
}

impl LoopHistory {
    fn largest(&self) -> f64 {
        self.over_time
            .iter()
            .map(|point| point.1.abs())
            .fold(0.0, f64::max)
    }

    /// Whether samples resolve the loop all the time: to a part of what one step changes, or to round-off.
    fn is_resolved(&self) -> bool {
        self.uncertainty < 0.1 * self.first.max(MAX_ROUNDING_ERROR)
    }

    /// The defect at the end by the straight line through all times, over the largest: 1 where it grows steadily.
    fn growth(&self) -> f64 {
        let end = self.over_time.last().map_or(f64::NAN, |point| point.0);
        Line::through(&self.over_time).slope.abs() * end / self.largest()
    }
}

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let (samples, time) = (settings.count("samples"), settings.number("time"));
    let radius = settings.number("radius");
    let phase_loop =
        Circle::new(vec![0.1, 0.2], vec![0.3, -0.1], radius)?.with_phases(Phases::Equal);
    let system: Arc<dyn Separable> = Arc::new(HenonHeiles);
    let (mut rows, mut panels) = (Vec::new(), Vec::new());
    let mut found = Vec::new();
    for (name, variant) in METHODS {
        let map = build(name, variant, Arc::clone(&system))?;
        let mut of_method = Vec::new();
        for h in halvings(-COARSEST, -FINEST) {
            of_method.push(follow(&*map, &phase_loop, samples, (h, time))?);
        }
        for followed in &of_method {
            rows.extend(followed.over_time.iter().map(|&(time, defect)| Row {
                integrator: name,
                step_size: followed.h,
                time,
                defect,
            }));
        }
        if let Some((_, title)) = DRAWN.iter().find(|(drawn, _)| *drawn == name) {
            panels.push(panel(title, &of_method));
        }
        found.push(of_method);
    }
    folder.write_csv("near_symplectic.csv", &rows)?;
    let figure = Figure::new(panels, 2).with_shared_legend();
    figure.save(&folder.figures(), "near_symplectic")?;
    let [trapezoidal, averaged, strang, staggered, runge_kutta] = &found[..] else {
        unreachable!("five methods");
    };
    let resolved = found.iter().flatten().all(LoopHistory::is_resolved);
    let claims = [
        one_step(trapezoidal),
        bounded(
            "the trapezoidal rule, which is conjugate to the midpoint rule,",
            trapezoidal,
            runge_kutta,
        ),
        bounded("the averaged vector field method", averaged, runge_kutta),
        leapfrog(strang, staggered),
    ];
    Ok(claims.map(|claim| claim.resolved_if(resolved)).into())
}

fn follow(
    map: &dyn TimeAdvance,
    phase_loop: &Circle,
    samples: usize,
    (h, time): (f64, f64),
) -> Result<LoopHistory, PaperError> {
    /// Times at which the loop is integrated.
    const TIMES: usize = 200;
    let steps = (time / h).round().max(1.0) as usize;
    let stride = steps.div_ceil(TIMES);
    let mut ensemble = Ensemble::sample(phase_loop, samples)?;
    let initial = LoopIntegral::of(&ensemble, &Rule::Pseudospectral)?;
    let (mut first, mut uncertainty, mut over_time) = (f64::NAN, 0.0f64, Vec::new());
    for step in 1..=steps {
        ensemble.advance(map, h)?;
        if step == 1 || step.is_multiple_of(stride) {
            let integral = LoopIntegral::of(&ensemble, &Rule::Pseudospectral)?;
            let defect = Defect::between(&initial, &integral)?;
            uncertainty = uncertainty.max(defect.uncertainty());
            if step == 1 {
                first = defect.magnitude();
            }
            if step.is_multiple_of(stride) {
                over_time.push((step as f64 * h, defect.signed));
            }
        }
    }
    Ok(LoopHistory {
        h,
        first,
        uncertainty,
        over_time,
    })
}

/// Order of what `of` takes of each step size.
fn order(found: &[LoopHistory], of: impl Fn(&LoopHistory) -> f64) -> Option<Line> {
    let points: Vec<(f64, f64)> = found.iter().map(|one| (one.h, of(one))).collect();
    power_law_line(&points)
}

fn one_step(found: &[LoopHistory]) -> Claim {
    let line = order(found, |one| one.first);
    Claim::of_paper(
        ITEM.id,
        "section 3.3",
        "if χ_h(z) = z + O(h^p), one step of a conjugate symplectic method is symplectic to O(h^p)",
        format!(
            "trapezoidal rule, p = 2: the loop integral changes as {} in one step, as h^(p+1)",
            line_text("h", line)
        ),
        line.map_or(Judgement::Unresolved, |line| {
            Judgement::of_interval(line.interval(), (1.9, f64::INFINITY))
        }),
    )
}

/// Bounded by h² over the whole time, where Runge–Kutta grows.
fn bounded(who: &str, found: &[LoopHistory], growing: &[LoopHistory]) -> Claim {
    let line = order(found, LoopHistory::largest);
    let (last, last_growing) = (&found[found.len() - 1], &growing[growing.len() - 1]);
    let told_apart = last_growing.growth() > 0.8;
    Claim::of_paper(
        ITEM.id,
        "section 3.3",
        format!("{who} nearly conserves loop integrals over long simulations"),
        format!(
            "up to t = {:.0} the largest defect goes as {}; at h = {} it is {:.1e}, {:.0}% of it growth along a line, \
             where RK2 has {:.1e} and {:.0}%",
            last.over_time.last().map_or(f64::NAN, |point| point.0),
            line_text("h", line),
            short_power(last.h),
            last.largest(),
            100.0 * last.growth(),
            last_growing.largest(),
            100.0 * last_growing.growth(),
        ),
        line.map_or(Judgement::Unresolved, |line| {
            let of_order = Judgement::of_interval(line.interval(), (1.7, f64::INFINITY));
            match last.growth() < 0.5 {
                true => of_order,
                false => Judgement::DoesNotHold,
            }
        })
        .if_resolved(told_apart),
    )
}

/// Staggered leapfrog is Strang splitting between two half kicks. Kicks are symplectic, and so it is itself.
fn leapfrog(strang: &[LoopHistory], staggered: &[LoopHistory]) -> Claim {
    let worst = |found: &[LoopHistory]| {
        (found.iter().map(|one| one.largest().max(one.first))).fold(0.0, f64::max)
    };
    let (strang, staggered) = (worst(strang), worst(staggered));
    Claim::of_paper(
        ITEM.id,
        "section 3.3",
        "the leapfrog method, which staggers positions and momenta in time, is conjugate symplectic, and not symplectic",
        format!(
            "it is conjugate to Strang splitting by half a kick, which is symplectic, so that it is symplectic itself: \
             the loop integral of staggered states changes by at most {staggered:.0e} up to the end, that of Strang \
             splitting by {strang:.0e}"
        ),
        Judgement::with_correction(staggered > MAX_ROUNDING_ERROR, strang < MAX_ROUNDING_ERROR),
    )
}

fn panel(name: &str, found: &[LoopHistory]) -> Panel {
    let drawn = (found.iter().enumerate()).map(|(k, followed)| {
        let curve = (followed.over_time.iter()).map(|&(time, defect)| (time, defect.abs()));
        let label = format!("h = {}", raised_power_of_two(followed.h));
        series(&label, curve.collect(), Style::Line, k)
    });
    Panel {
        title: name.to_owned(),
        x: axis("time t", Scale::Linear),
        y: error_axis(),
        series: drawn.collect(),
        equal_aspect: false,
    }
}
