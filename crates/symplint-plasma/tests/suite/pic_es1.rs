//! The textbook electrostatic scheme: against sums over Fourier modes, what it conserves, and that it is not symplectic.

use std::f64::consts::TAU;
use std::sync::Arc;

use symplint::loops::FourierLoop;
use symplint::map::TimeAdvance;
use symplint::state::{Rows, RowsMut};
use symplint::{Block, Diagnosis, Diagnostic, Ensemble, LoopIntegral, Rule, VerdictKind};
use symplint_models::integrators::catalogue;
use symplint_models::{DriftKick, DriftKickTangent, Model, ModelError};
use symplint_plasma::pic::{
    MomentumConservingConfig, MomentumConservingPic, ParticleWeights, Pic1d, PicConfig,
};

const CELLS: usize = 9;
const LENGTH: f64 = 6.3;
const WEIGHTS: [f64; 4] = [1.0, 0.3, 2.5, 0.8];
/// The first two are in neighbouring cells: far apart, every shape has the exact field of a charged sheet.
const POSITIONS: [f64; 4] = [0.41, 0.83, -7.1, 11.3];

fn plasma(degree: usize) -> MomentumConservingPic {
    MomentumConservingPic::new(MomentumConservingConfig {
        weights: ParticleWeights::Each(WEIGHTS.to_vec()),
        cells: CELLS,
        length: LENGTH,
        degree,
    })
    .unwrap()
}

/// The centred cardinal B-spline as a convolution of boxes: by the recursion of Cox and de Boor for a centred one.
fn centred_spline(degree: usize, x: f64) -> f64 {
    if degree == 0 {
        return if (-0.5..0.5).contains(&x) { 1.0 } else { 0.0 };
    }
    let (n, half) = (degree as f64, 0.5 * (degree + 1) as f64);
    ((half + x) * centred_spline(degree - 1, x + 0.5)
        + (half - x) * centred_spline(degree - 1, x - 0.5))
        / n
}

/// The field at each particle by its definition: shapes as functions of the distance, periodic images, and the potential
/// of every Fourier mode.
fn field_by_modes(degree: usize, x: &[f64]) -> Vec<f64> {
    let width = LENGTH / CELLS as f64;
    let offset = if degree.is_multiple_of(2) { 0.5 } else { 0.0 };
    let shape = |x: f64, node: usize| -> f64 {
        let distance = x / width - (node as f64 + offset);
        (-6..=6)
            .map(|image| centred_spline(degree, distance + f64::from(image) * CELLS as f64))
            .sum()
    };
    let charge: Vec<f64> = (0..CELLS)
        .map(|node| {
            let sum: f64 = x
                .iter()
                .zip(WEIGHTS)
                .map(|(&x, w)| w * shape(x, node))
                .sum();
            sum / width
        })
        .collect();
    let mut potential = [0.0; CELLS];
    for mode in 1..CELLS {
        let angle = TAU * mode as f64 / CELLS as f64;
        let eigenvalue = (2.0 - 2.0 * angle.cos()) / (width * width);
        for (i, potential) in potential.iter_mut().enumerate() {
            for (j, charge) in charge.iter().enumerate() {
                let cosine = (angle * (i as f64 - j as f64)).cos();
                *potential += charge * cosine / eigenvalue / CELLS as f64;
            }
        }
    }
    let field = |j: usize| {
        (potential[(j + CELLS - 1) % CELLS] - potential[(j + 1) % CELLS]) / (2.0 * width)
    };
    x.iter()
        .map(|&x| (0..CELLS).map(|j| field(j) * shape(x, j)).sum())
        .collect()
}

#[test]
fn the_field_is_that_of_the_modes() {
    for degree in 0..=5 {
        let found = plasma(degree).field(&POSITIONS);
        for (found, expected) in found.iter().zip(field_by_modes(degree, &POSITIONS)) {
            assert!(
                (found - expected).abs() < 1e-13,
                "degree {degree}: {found} for {expected}"
            );
        }
    }
}

#[test]
fn momentum_is_conserved_and_no_particle_acts_on_itself() {
    for degree in 0..=5 {
        let pic = plasma(degree);
        let change = pic.momentum(&pic.field(&POSITIONS));
        assert!(change.abs() < 1e-14, "degree {degree}: {change:e}");
        let weights = ParticleWeights::Each(vec![2.0]);
        let alone = MomentumConservingConfig {
            weights,
            cells: CELLS,
            length: LENGTH,
            degree,
        };
        let alone = MomentumConservingPic::new(alone).unwrap();
        let itself = alone.field(&[0.37])[0];
        assert!(itself.abs() < 1e-15, "degree {degree}: {itself:e}");
    }
}

#[test]
fn tangents_are_differences() {
    const STEP: f64 = 1e-6;
    for degree in 1..=5 {
        let pic = plasma(degree);
        for direction in 0..4 {
            let mut dq = [0.0; 4];
            dq[direction] = 1.0;
            let mut dp = [0.0; 4];
            let (q, rows) = (Rows::new(&POSITIONS, 4, 1, 1), Rows::new(&dq, 4, 1, 1));
            pic.kick_tangent(0.5, q, rows, &mut RowsMut::new(&mut dp, 4, 1, 1));
            let shifted = |by: f64| {
                let mut x = POSITIONS;
                x[direction] += by;
                pic.field(&x)
            };
            let (ahead, behind) = (shifted(STEP), shifted(-STEP));
            for a in 0..4 {
                let expected = 0.5 * (ahead[a] - behind[a]) / (2.0 * STEP);
                assert!(
                    (dp[a] - expected).abs() < 1e-8,
                    "degree {degree}: {} for {expected}",
                    dp[a]
                );
            }
        }
    }
}

/// w_a ∂E_a/∂x_b is symmetric where a force is a gradient. By how much it is not, relative to its largest entry.
fn asymmetry(weights: &[f64], field: impl Fn(&[f64]) -> Vec<f64>) -> f64 {
    const STEP: f64 = 1e-6;
    let n = weights.len();
    let mut matrix = vec![vec![0.0; n]; n];
    for b in 0..n {
        let shifted = |by: f64| {
            let mut x = POSITIONS.to_vec();
            x[b] += by;
            field(&x)
        };
        let (ahead, behind) = (shifted(STEP), shifted(-STEP));
        for a in 0..n {
            matrix[a][b] = weights[a] * (ahead[a] - behind[a]) / (2.0 * STEP);
        }
    }
    let entries = || (0..n).flat_map(|a| (0..n).map(move |b| (a, b)));
    let size = entries()
        .map(|(a, b)| matrix[a][b].abs())
        .fold(0.0, f64::max);
    let worst = entries().map(|(a, b)| (matrix[a][b] - matrix[b][a]).abs());
    worst.fold(0.0, f64::max) / size
}

#[test]
fn the_force_is_no_gradient_and_that_of_lewis_is() {
    for degree in 1..=5 {
        let pic = plasma(degree);
        let textbook = asymmetry(&WEIGHTS, |x| pic.field(x));
        let lewis = Pic1d::new(PicConfig {
            weights: ParticleWeights::Each(WEIGHTS.to_vec()),
            cells: CELLS,
            length: LENGTH,
            degree,
            ..PicConfig::default()
        });
        let lewis = lewis.unwrap();
        let gradient = asymmetry(&WEIGHTS, |x| lewis.field(x));
        println!("degree {degree}: {textbook:.1e}, Lewis {gradient:.1e}");
        assert!(
            textbook > 1e-4 && gradient < 1e-8,
            "degree {degree}: {textbook:e}, {gradient:e}"
        );
    }
}

fn diagnosis(degree: usize, integrator: &str, variant: Option<&str>) -> Diagnosis {
    let pic = plasma(degree);
    let step = catalogue::build(integrator, variant, Model::Forced(Arc::new(pic))).unwrap();
    let velocities = vec![0.5, -0.7, 0.2, 0.9];
    let phase_loop = FourierLoop::random(POSITIONS.to_vec(), velocities, &[0.8; 4], &[0.8; 4], 3);
    let diagnostic = Diagnostic {
        // A quadratic spline has kinks, which take many samples: leave some for the localisation.
        budget: Some(4_000_000),
        ..Diagnostic::halving(-1, -5)
    };
    diagnostic.run(&*step, &phase_loop.unwrap()).unwrap()
}

/// A kick changes the integral by h ∮F·dx, which is not 0 if F is not a gradient: order 1, whatever the shape.
#[test]
fn it_is_not_symplectic_whatever_the_shape() {
    for degree in 1..=4 {
        for (integrator, variant) in [("strang", None), ("lie-trotter", Some("momentum-first"))] {
            let found = diagnosis(degree, integrator, variant);
            println!(
                "degree {degree}, {integrator}: {}",
                found.verdict.headline()
            );
            assert_eq!(
                found.verdict.kind,
                VerdictKind::NotSymplectic,
                "degree {degree}"
            );
            let order = found.verdict.order.unwrap();
            assert!((order - 1.0).abs() < 0.3, "degree {degree}: {order}");
            let Some(localisation) = found.evidence.localisation else {
                panic!("{:?}", found.evidence.omissions);
            };
            let substeps = localisation.substeps;
            for substep in substeps {
                let uncertainty = substep.uncertainty.unwrap();
                let clear = substep.change.abs() > uncertainty;
                assert_eq!(clear, substep.name.starts_with("kick"), "{substep:?}");
            }
        }
    }
}

/// With the nearest grid point the force jumps as well, and the integral changes once breaks are closed.
#[test]
fn the_nearest_grid_point_breaks_loops_too() {
    let found = diagnosis(0, "strang", None);
    println!("{}", found.verdict.headline());
    assert_eq!(found.verdict.kind, VerdictKind::BrokenLoops);
    assert_ne!(found.verdict.conserved_once_closed, Some(true));
}

/// Between v(t − h/2) and v(t) lies half a kick at fixed positions: if the force is a gradient, the loop integral of
/// staggered states is that of synchronised ones.
#[test]
fn staggered_velocities_need_no_synchronising_where_the_force_is_a_gradient() {
    const H: f64 = 0.4;
    const SAMPLES: usize = 1024;
    let lewis = Pic1d::new(PicConfig {
        weights: ParticleWeights::Each(WEIGHTS.to_vec()),
        cells: CELLS,
        length: LENGTH,
        degree: 5,
        ..PicConfig::default()
    });
    let lewis = lewis.unwrap();
    let textbook = plasma(5);
    let systems: [(&dyn DriftKick, bool); 2] = [(&lewis, true), (&textbook, false)];
    for (system, is_gradient) in systems {
        let velocities = vec![0.5, -0.7, 0.2, 0.9];
        let radii = [0.3; 4];
        let phase_loop = FourierLoop::random(POSITIONS.to_vec(), velocities, &radii, &radii, 3);
        let mut ensemble = Ensemble::sample(&phase_loop.unwrap(), SAMPLES).unwrap();
        let coordinates = system.coordinates();
        let integral = |ensemble: &Ensemble| {
            let rule = Rule::Pseudospectral;
            LoopIntegral::in_coordinates(ensemble, &rule, &coordinates)
                .unwrap()
                .value
        };
        let synchronised = integral(&ensemble);
        let mut block = ensemble.block();
        system.kick(-0.5 * H, block.q.as_rows(), &mut block.p);
        let change = (integral(&ensemble) / synchronised - 1.0).abs();
        println!("{change:e}");
        assert_eq!(change < 1e-13, is_gradient, "{change:e}");
        assert!(is_gradient || change > 1e-6, "{change:e}");
    }
}

/// A cold plasma oscillates at ω_p = 1 where the wave is resolved.
#[test]
fn a_cold_plasma_oscillates_at_the_plasma_frequency() {
    const PARTICLES: usize = 256;
    const H: f64 = 0.05;
    let length = TAU;
    let pic = MomentumConservingPic::new(MomentumConservingConfig {
        weights: ParticleWeights::Equal {
            particles: PARTICLES,
            density: 1.0,
        },
        cells: 64,
        length,
        degree: 1,
    });
    let pic = pic.unwrap();
    let mut x: Vec<f64> = (0..PARTICLES)
        .map(|a| {
            let place = length * (a as f64 + 0.5) / PARTICLES as f64;
            place + 1e-3 * place.sin()
        })
        .collect();
    let mut v = vec![0.0; PARTICLES];
    let start = x.clone();
    let energy = pic.energy(&x, &v);
    let step = catalogue::build("strang", None, Model::Forced(Arc::new(pic.clone()))).unwrap();
    // A quarter of a period: all displacements are velocities.
    let steps = (0.25 * TAU / H).round() as usize;
    for _ in 0..steps {
        let rows = RowsMut::new(&mut x, PARTICLES, 1, 1);
        step.advance(
            H,
            &mut Block::new(rows, RowsMut::new(&mut v, PARTICLES, 1, 1)),
        )
        .unwrap();
    }
    for a in 0..PARTICLES {
        let place = length * (a as f64 + 0.5) / PARTICLES as f64;
        let time = H * steps as f64;
        let displacement = start[a] - place;
        assert!((x[a] - place - displacement * time.cos()).abs() < 1e-5);
        assert!((v[a] + displacement * time.sin()).abs() < 1e-5);
    }
    assert!((pic.energy(&x, &v) / energy - 1.0).abs() < 0.01);
}

#[test]
fn what_cannot_be_built_is_refused() {
    let config = MomentumConservingConfig::default;
    let degree = MomentumConservingPic::new(MomentumConservingConfig {
        degree: 6,
        ..config()
    });
    assert!(matches!(
        degree,
        Err(ModelError::Degree {
            degree: 6,
            lowest: 0,
            ..
        })
    ));
    let on =
        |cells: usize| MomentumConservingPic::new(MomentumConservingConfig { cells, ..config() });
    assert!(on(0).is_err());
    // Both neighbours of a node are the same one: the field would be 0, and every scheme exact.
    for cells in [1, 2] {
        assert_eq!(
            on(cells).unwrap_err(),
            ModelError::NoCentredDifference { cells }
        );
    }
    let field = on(3).unwrap().field(&[1.0, 2.1, 5.0, 5.5]);
    assert!(field.iter().any(|field| field.abs() > 0.01), "{field:?}");
    let length = MomentumConservingPic::new(MomentumConservingConfig {
        length: -1.0,
        ..config()
    });
    assert!(length.is_err());
    let dense = MomentumConservingPic::new(config()).unwrap();
    assert_eq!(DriftKick::dof(&dense), 4);
}
