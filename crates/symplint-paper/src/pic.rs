//! Particle-in-cell, section 5: what figures 6, 7 and 9 share.

use std::sync::Arc;

use symplint::rules::Cutoffs;
use symplint::{Circle, Phases, Rule};
use symplint_models::Separable;
use symplint_plasma::pic::{Landau, ParticleWeights, Pic1d, PicConfig, ShapeFamily, TwoStream};

use super::error::PaperError;
use super::settings::{Key, Settings};
use super::sweep::{Record, Sweep, step_of};
use super::true_defect;

/// Settings of every particle-in-cell figure.
pub const LAMBDA: Key = Key::positive("cutoff", 1000.0, "λ_q = λ_p of the finite-difference rule");
pub const SEED: Key = Key::whole("seed", 42, 0, "of the initial states");
pub const STRANG: Key = Key::choice(
    "strang",
    &["position-first", "momentum-first"],
    "as in the paper's text; \"momentum-first\" as in its published code",
);
pub const RK2: Key = Key::choice(
    "rk2",
    &["heun", "midpoint"],
    "as in the published code; \"midpoint\" is the other one",
);

/// Most particles.
pub const MAX_PARTICLES: u64 = 1 << 24;

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
) -> Result<Plasma, PaperError> {
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
        circle: Circle::new(x, v, 1.0)?.with_phases(Phases::Equal),
    })
}

/// The spline degrees of the figures with their names.
pub const DEGREES: [(usize, &str); 3] = [(1, "linear"), (2, "quadratic"), (3, "cubic")];

/// The integrators of the figures, in the order of their curves.
pub const INTEGRATORS: [&str; 2] = ["Strang", "RK2"];

/// The settings that all simulations of a figure share.
#[derive(Clone)]
pub struct Setup {
    /// N_p.
    pub particles: usize,
    /// λ_q = λ_p of the finite-difference rule.
    pub cutoff: f64,
    seed: u64,
    variants: [String; 2],
}

/// One plasma with one kind of splines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Case {
    /// One of [`PLASMAS`].
    pub plasma: &'static str,
    /// Spline degree.
    pub degree: usize,
    /// Passes of the binary filter.
    pub passes: u32,
}

/// The step sizes or numbers of samples of a sweep.
pub enum SweepRange {
    /// The step size.
    Steps {
        /// N_s.
        samples: usize,
        /// h.
        step_sizes: Vec<f64>,
    },
    /// The number of samples.
    Samples {
        /// N_s.
        counts: Vec<usize>,
        /// h.
        step_size: f64,
    },
}

/// What one integrator did in one case.
pub struct Curve {
    /// The case.
    pub case: Case,
    /// One of [`INTEGRATORS`].
    pub integrator: &'static str,
    /// The points, in the order of the sweep.
    pub records: Vec<Record>,
}

/// All that was measured for a figure.
pub struct Curves(pub Vec<Curve>);

impl Case {
    /// Its name in titles and data: `two-stream, cubic`, with the filter if there is one.
    pub fn name(&self) -> String {
        let degree = DEGREES.iter().find(|(degree, _)| *degree == self.degree);
        let degree = degree.map_or("other", |(_, name)| name);
        match self.passes {
            0 => format!("{}, {degree}", self.plasma),
            passes => format!("{}, {degree}, s = {passes}", self.plasma),
        }
    }
}

impl Curves {
    /// The points of one curve; none where it was not measured.
    pub fn of(&self, case: Case, integrator: &str) -> &[Record] {
        (self.0.iter())
            .find(|curve| curve.case == case && curve.integrator == integrator)
            .map_or(&[], |curve| &curve.records)
    }

    /// Every point, for the data file.
    pub fn records(&self) -> Vec<&Record> {
        self.0.iter().flat_map(|curve| &curve.records).collect()
    }
}

impl Setup {
    /// From the settings `particles`, [`LAMBDA`], [`SEED`], [`STRANG`] and [`RK2`].
    pub fn read(settings: &Settings) -> Self {
        Setup {
            particles: settings.count("particles"),
            cutoff: settings.number("cutoff"),
            seed: settings.whole("seed"),
            variants: ["strang", "rk2"].map(|key| settings.choice(key).to_owned()),
        }
    }

    /// The same with another number of particles.
    pub fn with_particles(&self, particles: usize) -> Self {
        Setup {
            particles,
            ..self.clone()
        }
    }

    /// Sweeps one integrator in one case, by the paper's rule: finite differences where loops break.
    ///
    /// Where Strang splitting has kinked loops, their true defects are measured, too.
    pub fn measure(
        &self,
        case: Case,
        integrator: &'static str,
        over: &SweepRange,
    ) -> Result<Curve, PaperError> {
        let plasma = plasma(
            case.plasma,
            self.particles,
            ShapeFamily::BSpline,
            case.degree,
            case.passes,
            self.seed,
        )?;
        let (name, variant) = match integrator {
            "Strang" => ("strang", &self.variants[0]),
            _ => ("rk2", &self.variants[1]),
        };
        let map = step_of(name, variant, &plasma.system)?;
        let sweep = Sweep {
            case: &case.name(),
            integrator,
            map: &*map,
            phase_loop: &plasma.circle,
            rule: match case.degree {
                1 => Rule::FiniteDifference(Cutoffs::relative(self.cutoff)),
                _ => Rule::Pseudospectral,
            },
        };
        let mut records = match over {
            SweepRange::Steps {
                samples,
                step_sizes,
            } => sweep.over_steps(*samples, step_sizes)?,
            SweepRange::Samples { counts, step_size } => sweep.over_samples(counts, *step_size)?,
        };
        if case.degree > 1 && integrator == "Strang" {
            true_defect::measure(&*map, &plasma.circle, &mut records)?;
        }
        Ok(Curve {
            case,
            integrator,
            records,
        })
    }
}
