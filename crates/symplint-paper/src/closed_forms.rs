//! Section 4.2: the closed forms for splitting on H = p²/2 + |q|.

use std::f64::consts::PI;
use std::sync::Arc;

use serde::Serialize;
use symplint::rules::{Cutoff, Cutoffs};
use symplint::{Circle, Rule, TimeAdvance};
use symplint_models::Separable;
use symplint_models::systems::AbsoluteValue;
use symplint_report::figure::{Figure, Panel, Scale, Series, Style};
use symplint_report::plot::{axis, series};
use symplint_report::run_folder::RunFolder;

use super::accumulation::{NamedMap, accumulated, break_line};
use super::claim::{Claim, Judgement, Origin};
use super::error::PaperError;
use super::item::Item;
use super::settings::{Key, Settings};
use super::sweep::{Record, Sweep, step_of, worst};

pub const ITEM: Item = Item {
    id: "closed-forms",
    title: "|q|: closed forms of the four splittings, many steps, and the mollified form (section 4.2)",
    cost: "2 s",
    keys: &[
        Key::whole("samples", 1 << 20, 3, "samples for |q|"),
        Key::whole(
            "accumulated_samples",
            1 << 18,
            3,
            "samples for |q| over many steps",
        ),
        Key::positive("epsilon", 0.1, "of the mollified form"),
        Key::whole(
            "mollified_samples",
            1 << 14,
            3,
            "samples for the mollified form",
        ),
    ],
    check: None,
    run,
};

/// A splitting with its closed form of I(h).
struct Form {
    integrator: &'static str,
    variant: &'static str,
    formula: &'static str,
    value: fn(f64) -> f64,
}

const FORMS: [Form; 4] = [
    Form {
        integrator: "lie-trotter",
        variant: "position-first",
        formula: "π",
        value: |_| PI,
    },
    Form {
        integrator: "lie-trotter",
        variant: "momentum-first",
        formula: "π + 4h²",
        value: |h| PI + 4.0 * h * h,
    },
    Form {
        integrator: "strang",
        variant: "position-first",
        formula: "π + 4h²/√(h² + 4)",
        value: |h| PI + 4.0 * h * h / (h * h + 4.0).sqrt(),
    },
    Form {
        integrator: "strang",
        variant: "momentum-first",
        formula: "π + 2h² − h³",
        value: |h| PI + 2.0 * h * h - h * h * h,
    },
];

/// τ_q well above the slope of smooth q, at most 2π√(1 + h²) here, and below that of the smallest jump,
/// h² N; none on p, whose jumps alone do no harm (appendix B, remark).
const CUTOFFS: Cutoffs = Cutoffs {
    q: Cutoff::Absolute(50.0),
    p: Cutoff::Absolute(f64::INFINITY),
};

/// Step sizes at which the forms are compared.
const STEPS: [f64; 8] = [1.9, 1.5, 1.0, 0.75, 0.5, 0.25, 0.1, 0.01];

#[derive(Serialize)]
struct Row {
    integrator: &'static str,
    variant: &'static str,
    step_size: f64,
    closed_form: f64,
    measured: f64,
    difference: f64,
    omitted_cells: Option<usize>,
}

fn run(settings: &Settings, folder: &RunFolder) -> Result<Vec<Claim>, PaperError> {
    let samples = settings.count("samples");
    let epsilon = settings.number("epsilon");
    let mollified_samples = settings.count("mollified_samples");
    let circle = Circle::new(vec![0.0], vec![0.0], 1.0)?;
    let sharp: Arc<dyn Separable> = Arc::new(AbsoluteValue::new(0.0)?);
    let smooth: Arc<dyn Separable> = Arc::new(AbsoluteValue::new(epsilon)?);
    let mut rows = Vec::new();
    let mut claims = Vec::new();
    let mut curves = Vec::new();
    let mut mollified = Vec::new();
    let mut maps: Vec<NamedMap> = Vec::new();
    for (index, form) in FORMS.iter().enumerate() {
        let name = format!("{} {}", form.variant, form.integrator);
        let map = step_of(form.integrator, form.variant, &sharp)?;
        let of_form = form.rows(&*map, &circle, samples)?;
        claims.push(form.claim(&name, &of_form, samples));
        curves.extend(form.curves(&name, &of_form, index));
        rows.extend(of_form);
        maps.push((name, map));

        let map = step_of(form.integrator, form.variant, &smooth)?;
        let sweep = Sweep {
            case: "√(q² + ε²)",
            integrator: form.integrator,
            map: &*map,
            phase_loop: &circle,
            rule: Rule::Pseudospectral,
        };
        mollified.extend(sweep.over_steps(mollified_samples, &STEPS)?);
    }
    claims.push(break_line(&maps[0], &circle, "q + hp = 0", 1.0)?);
    claims.push(break_line(&maps[1], &circle, "q = 0", 0.0)?);
    claims.push(accumulated(
        &maps,
        &circle,
        CUTOFFS,
        settings.count("accumulated_samples"),
        folder,
    )?);
    let largest = worst(mollified.iter());
    claims.push(Claim {
        item: "closed-forms",
        origin: Origin::Paper,
        place: "section 4.2, remark",
        says: format!("with √(q² + ε²), ε = {epsilon}, all four are symplectic"),
        measured: format!(
            "no defect above {largest:.1e} (pseudospectral, {mollified_samples} samples)"
        ),
        judgement: Judgement::of(largest < 1e-12),
    });
    folder.write_csv("closed_forms.csv", &rows)?;
    folder.write_csv("closed_forms_mollified.csv", &mollified)?;
    Figure::new(
        vec![Panel {
            title: "H = p²/2 + |q|: measured (points) and closed forms (lines)".into(),
            x: axis("step size h", Scale::Linear),
            y: axis("∮ p dq without the jumps", Scale::Linear),
            series: curves,
            equal_aspect: false,
        }],
        1,
    )
    .save(&folder.figures(), "closed_forms")?;
    Ok(claims)
}

impl Form {
    /// The closed form and the measured integral at each of [`STEPS`].
    fn rows(
        &self,
        map: &dyn TimeAdvance,
        circle: &Circle,
        samples: usize,
    ) -> Result<Vec<Row>, PaperError> {
        let sweep = Sweep {
            case: "|q|",
            integrator: self.integrator,
            map,
            phase_loop: circle,
            rule: Rule::FiniteDifference(CUTOFFS),
        };
        let row = |record: &Record| {
            let closed_form = (self.value)(record.step_size);
            Row {
                integrator: self.integrator,
                variant: self.variant,
                step_size: record.step_size,
                closed_form,
                measured: record.advanced,
                difference: record.advanced - closed_form,
                omitted_cells: record.omitted_cells,
            }
        };
        Ok((sweep.over_steps(samples, &STEPS)?.iter())
            .map(row)
            .collect())
    }

    fn claim(&self, name: &str, rows: &[Row], samples: usize) -> Claim {
        let off = (rows.iter())
            .map(|row| (row.difference / row.closed_form).abs())
            .fold(0.0, f64::max);
        Claim {
            item: "closed-forms",
            origin: Origin::Paper,
            place: "section 4.2",
            says: format!("{name} on |q| gives {}", self.formula),
            measured: format!(
                "within {off:.1e} of it for h = 0.01 … 1.9 (finite differences, {samples} samples)"
            ),
            judgement: Judgement::of(off < 1e-5),
        }
    }

    /// The closed form as a line, the measured integrals as points.
    fn curves(&self, name: &str, rows: &[Row], color: usize) -> [Series; 2] {
        let exact = (1..=95)
            .map(|k| 0.02 * f64::from(k))
            .map(|h| (h, (self.value)(h)))
            .collect();
        let points = rows
            .iter()
            .map(|row| (row.step_size, row.measured))
            .collect();
        [
            series("", exact, Style::Line, color),
            series(name, points, Style::Points, color),
        ]
    }
}
