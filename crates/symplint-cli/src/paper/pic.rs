//! Particle-in-cell, section 5: what figures 6, 7 and 9 share.

use std::sync::Arc;

use symplint::{Circle, Cutoffs, Rule, TimeAdvance};
use symplint_models::Separable;
use symplint_models::pic::{Landau, ParticleWeights, Pic1d, PicConfig, ShapeFamily, TwoStream};

use super::plot::{floor, series};
use super::sweep::{Record, Study, step_of};
use crate::commands::Failure;
use crate::config::{Accept, Key, Section};
use crate::figure::{Series, Style};

/// Settings of every particle-in-cell figure.
pub const LAMBDA: Key = Key::new(
    "cutoff",
    "1000.0",
    "λ_q = λ_p of the finite-difference rule",
);
pub const SEED: Key = Key::new("seed", "42", "of the initial states");
pub const STRANG: Key = Key::new(
    "strang",
    "\"position-first\"",
    "as in the paper's text; \"momentum-first\" as in its published code",
);
pub const RK2: Key = Key::new(
    "rk2",
    "\"heun\"",
    "as in the published code; \"midpoint\" is the other one",
);

/// Particles at most.
pub const MOST_PARTICLES: u64 = 1 << 24;

/// The paper's two plasmas.
pub const PLASMAS: [&str; 2] = ["Landau", "two-stream"];

/// Where loops go round, and the plasma they are loops of.
pub struct Plasma {
    /// The system.
    pub system: Arc<dyn Separable>,
    /// Loops of radius 1 in every particle.
    pub circle: Circle,
}

/// A plasma of the paper, section 5.2: L = 50, 128 cells, density 1.
pub fn plasma(
    name: &str,
    particles: usize,
    family: ShapeFamily,
    degree: usize,
    filter_passes: u32,
    seed: u64,
) -> Result<Plasma, Failure> {
    let pic = Pic1d::new(PicConfig {
        weights: ParticleWeights::Equal {
            particles,
            density: 1.0,
        },
        family,
        degree,
        filter_passes,
        ..PicConfig::default()
    })?;
    let (x, v) = match name {
        "Landau" => Landau::default().sample(&pic, seed)?,
        _ => TwoStream::default().sample(&pic, seed)?,
    };
    Ok(Plasma {
        system: Arc::new(pic),
        circle: Circle::new(x, v, 1.0)?,
    })
}

/// The integrators of a figure: label and step.
pub struct Steps {
    strang: &'static str,
    rk2: &'static str,
}

/// A step with the label of its curve.
type Labelled = (&'static str, Box<dyn TimeAdvance>);

impl Steps {
    /// From the settings [`STRANG`] and [`RK2`].
    pub fn read(settings: &Section) -> Result<Self, Failure> {
        Ok(Steps {
            strang: settings.choice("strang", &["position-first", "momentum-first"])?,
            rk2: settings.choice("rk2", &["heun", "midpoint"])?,
        })
    }

    /// Both for a system.
    fn of(&self, system: &Arc<dyn Separable>) -> Result<[Labelled; 2], Failure> {
        Ok([
            ("Strang", step_of("strang", self.strang, system)?),
            ("RK2", step_of("rk2", self.rk2, system)?),
        ])
    }
}

/// The paper's rule: finite differences where loops break.
pub fn rule(degree: usize, settings: &Section) -> Result<Rule, Failure> {
    let lambda = settings.number("cutoff", Accept::Positive)?;
    Ok(if degree == 1 {
        Rule::FiniteDifference(Cutoffs::relative(lambda))
    } else {
        Rule::Pseudospectral
    })
}

/// Curves and floor of one panel, with everything measured.
pub struct Swept {
    /// Strang, RK2.
    pub curves: Vec<Series>,
    /// The floor of Strang.
    pub floor: Series,
    /// The points.
    pub records: Vec<Record>,
}

/// Runs `sweep` for both integrators; `at` places a record in the panel.
pub fn sweep_plasma(
    case: &str,
    plasma: &Plasma,
    steps: &Steps,
    rule: Rule,
    sweep: impl Fn(&Study<'_>) -> Result<Vec<Record>, Failure>,
    at: fn(&Record) -> (f64, f64),
) -> Result<Swept, Failure> {
    let mut curves = Vec::new();
    let mut records = Vec::new();
    let mut of_strang = None;
    for (index, (label, map)) in steps.of(&plasma.system)?.into_iter().enumerate() {
        let points = sweep(&Study {
            case,
            integrator: label,
            map: &*map,
            phase_loop: &plasma.circle,
            rule,
        })?;
        of_strang.get_or_insert_with(|| floor(&points, at));
        let curve = points.iter().map(at).collect();
        curves.push(series(label, curve, Style::LineAndPoints, index));
        records.extend(points);
    }
    Ok(Swept {
        curves,
        floor: of_strang.unwrap_or_else(|| series("", Vec::new(), Style::Floor, 0)),
        records,
    })
}

/// The spline degrees of the figures with their names.
pub const DEGREES: [(usize, &str); 3] = [(1, "linear"), (2, "quadratic"), (3, "cubic")];
