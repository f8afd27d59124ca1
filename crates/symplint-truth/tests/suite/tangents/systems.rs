//! The systems of the library, with a state and a step size at which nothing is special.

use std::sync::Arc;

use symplint_models::integrators::catalogue::{self, CATALOGUE};
use symplint_models::systems::{
    AbsoluteValue, Chain, ChargedParticle, DoublePendulum, Ends, FputBond, HarmonicOscillator,
    HenonHeiles, InterpolatedPendulum, Kepler, Pendulum, PendulumArray, PendulumPotential,
    RotationalForce, TodaBond, TwoCell,
};
use symplint_models::{DriftKick, Hamiltonian, Model};
use symplint_plasma::pic::{ParticleWeights, Pic1d, Pic2d, PicConfig, ShapeFamily};

use crate::common::State;

/// A system with a state off all kinks of its force.
pub struct Subject {
    pub name: String,
    pub model: Model,
    pub at: State,
    /// Whether the force is more than piecewise linear.
    pub nonlinear: bool,
    /// Whether it is continuous.
    pub continuous: bool,
    /// Size of steps that stay off all kinks.
    pub step: f64,
}

impl Subject {
    fn new(name: impl Into<String>, model: impl Into<Model>, q: &[f64], p: &[f64]) -> Self {
        Subject {
            name: name.into(),
            model: model.into(),
            at: (q.to_vec(), p.to_vec()),
            nonlinear: true,
            continuous: true,
            step: 0.5,
        }
    }

    fn in_small_steps(self) -> Self {
        Subject { step: 0.1, ..self }
    }

    fn with_jumps(self) -> Self {
        Subject {
            continuous: false,
            ..self
        }
    }

    fn piecewise_linear(self) -> Self {
        Subject {
            nonlinear: false,
            ..self
        }
    }

    /// Every integrator for the system, with its catalogue entry and the name of the pair.
    pub fn maps(
        &self,
    ) -> impl Iterator<
        Item = (
            String,
            &'static catalogue::IntegratorInfo,
            Box<dyn symplint::TimeAdvance>,
        ),
    > + '_ {
        // The discrete gradient has no tangent map: its derivative would need those of H between the ends of a step.
        let entries = CATALOGUE
            .iter()
            .filter(|info| info.is_for(&self.model) && info.name != "discrete-gradient");
        let forms = entries.flat_map(|info| {
            let variants: Vec<Option<&str>> = match info.variants {
                [] => vec![None],
                variants => variants.iter().copied().map(Some).collect(),
            };
            variants.into_iter().map(move |variant| (info, variant))
        });
        // Stages across a jump of the force have no solution to be found.
        let forms = forms.filter(|(info, _)| self.continuous || !info.is_implicit());
        forms.map(|(info, variant)| {
            let map = catalogue::build(info.name, variant, self.model.clone()).unwrap();
            let name = format!("{}, {} {}", self.name, info.name, variant.unwrap_or(""));
            (name, info, map)
        })
    }
}

fn plasma(family: ShapeFamily, degree: usize) -> PicConfig {
    PicConfig {
        weights: ParticleWeights::Each(vec![1.3, 0.7, 1.1]),
        cells: 8,
        length: 6.0,
        family,
        degree,
        filter_passes: 1,
    }
}

pub fn all() -> Vec<Subject> {
    let wave = |count: usize, shift: f64| -> Vec<f64> {
        (0..count).map(|i| (1.3 * i as f64 + shift).sin()).collect()
    };
    let mut all = vec![
        Subject::new(
            "oscillators",
            Arc::new(HarmonicOscillator::new(vec![1.0, 0.0, 1.7]).unwrap()),
            &wave(3, 0.2),
            &wave(3, 0.9),
        )
        .piecewise_linear(),
        Subject::new(
            "cosine",
            Arc::new(Pendulum::new(PendulumPotential::Cos)),
            &[0.7],
            &[0.9],
        ),
        Subject::new(
            "sine",
            Arc::new(Pendulum::new(PendulumPotential::Sin)),
            &[0.7],
            &[0.9],
        ),
        Subject::new(
            "wedge",
            Arc::new(AbsoluteValue::new(0.0).unwrap()),
            &[1.7],
            &[0.4],
        )
        .piecewise_linear(),
        Subject::new(
            "rounded wedge",
            Arc::new(AbsoluteValue::new(0.4).unwrap()),
            &[0.3],
            &[0.4],
        ),
        Subject::new(
            "pendulum array",
            Arc::new(PendulumArray::new(5, 0.9, 0.6).unwrap()),
            &wave(5, 0.1),
            &wave(5, 0.7),
        ),
        Subject::new(
            "Hénon–Heiles",
            Arc::new(HenonHeiles),
            &[0.2, -0.3],
            &[0.4, 0.1],
        ),
        Subject::new(
            "Kepler",
            Arc::new(Kepler::new(1.2, 0.0).unwrap()),
            &[1.1, 0.4],
            &[-0.3, 0.9],
        ),
        Subject::new(
            "softened Kepler",
            Arc::new(Kepler::new(1.2, 0.3).unwrap()),
            &[0.6, 0.4],
            &[-0.3, 0.9],
        ),
        Subject::new(
            "FPUT",
            Arc::new(Chain::new(FputBond::new(0.3, 0.5).unwrap(), 4, Ends::Fixed).unwrap()),
            &wave(4, 0.4),
            &wave(4, 0.8),
        ),
        Subject::new(
            "Toda",
            Arc::new(Chain::new(TodaBond, 4, Ends::Periodic).unwrap()),
            &wave(4, 0.4),
            &wave(4, 0.8),
        ),
        Subject::new(
            "double pendulum",
            Model::General(
                Arc::new(DoublePendulum::new([1.0, 0.7], [0.8, 1.1], 0.9).unwrap())
                    as Arc<dyn Hamiltonian>,
            ),
            &[0.8, -0.5],
            &[0.4, 0.3],
        ),
        Subject::new(
            "charge",
            Model::Charged(ChargedParticle::new(0.8, 0.5, 0.6).unwrap()),
            &[0.4, -0.2],
            &[0.6, 0.5],
        ),
        Subject::new(
            "rotational force",
            Model::Forced(Arc::new(RotationalForce::new(0.3).unwrap()) as Arc<dyn DriftKick>),
            &[0.2, -0.3],
            &[0.4, 0.1],
        ),
        Subject::new(
            "two cells",
            Arc::new(TwoCell::new(3.0).unwrap()),
            &[1.2],
            &[0.3],
        )
        .piecewise_linear(),
    ];
    for degree in 0..=5 {
        let system = InterpolatedPendulum::new(degree, 25).unwrap();
        let subject = Subject::new(
            format!("spline {degree}"),
            Arc::new(system),
            &[0.63],
            &[0.2],
        );
        all.push(match degree {
            0 => subject,
            1 => subject.piecewise_linear().with_jumps().in_small_steps(),
            2 => subject.piecewise_linear().in_small_steps(),
            _ => subject.in_small_steps(),
        });
    }
    let shapes = [
        (ShapeFamily::BSpline, 1..=5),
        (ShapeFamily::Lagrange, 1..=3),
    ];
    for (family, degrees) in shapes {
        for degree in degrees {
            let smooth = family == ShapeFamily::BSpline && degree > 1;
            let mut push = |subject: Subject| {
                let subject = subject.in_small_steps();
                all.push(if smooth {
                    subject
                } else {
                    subject.with_jumps()
                });
            };
            let name = format!("{} {degree}", family.name());
            let line = Pic1d::new(plasma(family, degree)).unwrap();
            push(Subject::new(
                format!("line, {name}"),
                Arc::new(line),
                &[0.41, 2.62, 3.31],
                &[0.3, -0.2, 0.1],
            ));
            let plane = Pic2d::new(plasma(family, degree)).unwrap();
            push(Subject::new(
                format!("plane, {name}"),
                Arc::new(plane),
                &[0.41, 1.0, 2.62, 5.1, 3.31, 0.2],
                &[0.3, -0.2, 0.1, 0.15, -0.25, 0.05],
            ));
        }
    }
    all
}
