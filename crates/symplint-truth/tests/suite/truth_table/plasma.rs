//! Particle-in-cell.

use std::sync::Arc;

use symplint_models::Model;
use symplint_plasma::pic::{Landau, ParticleWeights, Pic, PicConfig, ShapeFamily, TwoStream};

use crate::truth_table::case::{
    BROKEN, BROKEN_AND_CLOSED, Case, NOT_SYMPLECTIC, Named, Truth, circle, circle_on, symplectic_to,
};

const TORN: &str = "the force of C⁰ shapes jumps at cell boundaries";
const SMOOTH: &str = "the force of B-splines of degree 2 and above is continuous, and exactly −∇H";
const RK2: &str = "explicit midpoint, not symplectic in any potential";

/// A box of 16 cells.
fn config(family: ShapeFamily, degree: usize) -> PicConfig {
    PicConfig {
        family,
        degree,
        cells: 16,
        length: 12.0,
        ..PicConfig::default()
    }
}

fn two_stream<const D: usize>(config: &PicConfig) -> (Model, Vec<f64>, Vec<f64>) {
    let pic = Pic::<D>::new(config.clone()).unwrap();
    let (x, v) = TwoStream::default().sample(&pic, 5).unwrap();
    (Arc::new(pic).into(), x, v)
}

fn case<const D: usize>(
    config: &PicConfig,
    step: &str,
    truth: Truth,
    because: &'static str,
) -> Case {
    let (model, x, v) = two_stream::<D>(config);
    on::<D>(config, &model, step, circle(&x, &v, 1.0), truth, because)
}

fn on<const D: usize>(
    config: &PicConfig,
    model: &Model,
    step: &str,
    on: Named,
    truth: Truth,
    because: &'static str,
) -> Case {
    let filter = match config.filter_passes {
        0 => String::new(),
        passes => format!(", filter {passes}"),
    };
    let weights = match config.weights {
        ParticleWeights::Equal { .. } => "",
        ParticleWeights::Each(_) => ", unequal weights",
    };
    let name = format!(
        "PIC {D}d, {:?} {}{filter}{weights}",
        config.family, config.degree
    );
    Case::built(name, model, step, on, truth, because).steps(-1, -4)
}

pub fn lines() -> Vec<Case> {
    use ShapeFamily::{BSpline, Lagrange};
    let mut cases = Vec::new();
    for degree in 2..=5 {
        let config = config(BSpline, degree);
        cases.push(case::<1>(&config, "strang", symplectic_to(8.0), SMOOTH));
        cases.push(case::<1>(&config, "rk2", NOT_SYMPLECTIC, RK2));
    }
    for (family, degree) in [(BSpline, 1), (Lagrange, 1), (Lagrange, 2), (Lagrange, 3)] {
        let config = config(family, degree);
        cases.push(case::<1>(
            &config,
            "strang position-first",
            BROKEN_AND_CLOSED,
            TORN,
        ));
        cases.push(case::<1>(
            &config,
            "strang momentum-first",
            BROKEN_AND_CLOSED,
            TORN,
        ));
        cases.push(case::<1>(&config, "rk2", BROKEN, TORN));
    }
    for (degree, passes) in [(3, 1), (3, 4), (2, 2)] {
        let config = PicConfig {
            filter_passes: passes,
            ..config(BSpline, degree)
        };
        let because = "the filtered force is that of the filtered energy";
        cases.push(case::<1>(&config, "strang", symplectic_to(8.0), because));
    }
    let filtered = PicConfig {
        filter_passes: 2,
        ..config(BSpline, 1)
    };
    cases.push(case::<1>(&filtered, "strang", BROKEN_AND_CLOSED, TORN));
    let unequal = |degree| PicConfig {
        weights: ParticleWeights::Each(vec![6.0, 3.0, 1.0]),
        ..config(BSpline, degree)
    };
    let canonical = "canonical momenta are w_a v_a, and the map states its weights";
    cases.push(case::<1>(
        &unequal(3),
        "strang",
        symplectic_to(8.0),
        canonical,
    ));
    cases.push(case::<1>(
        &unequal(3),
        "mclachlan4",
        symplectic_to(8.0),
        canonical,
    ));
    cases.push(case::<1>(&unequal(3), "rk2", NOT_SYMPLECTIC, RK2));
    cases.push(case::<1>(&unequal(1), "strang", BROKEN_AND_CLOSED, TORN));
    cases
}

pub fn more_particles() -> Vec<Case> {
    let many = |degree, particles| PicConfig {
        weights: ParticleWeights::Equal {
            particles,
            density: 1.0,
        },
        ..config(ShapeFamily::BSpline, degree)
    };
    let mut cases = Vec::new();
    for particles in [8, 16] {
        let config = many(3, particles);
        cases.push(case::<1>(&config, "strang", symplectic_to(8.0), SMOOTH).steps(-1, -3));
        cases.push(case::<1>(&config, "rk2", NOT_SYMPLECTIC, RK2).steps(-1, -3));
        cases.push(case::<1>(&many(1, particles), "strang", BROKEN, TORN).steps(-1, -3));
    }
    // One particle moves, seven feel it.
    let config = many(3, 8);
    let pic = Pic::<1>::new(config.clone()).unwrap();
    let (x, v) = Landau::default().sample(&pic, 3).unwrap();
    let model: Model = Arc::new(pic).into();
    let one = circle_on(&[4], &x, &v, 1.0);
    cases.push(on::<1>(
        &config,
        &model,
        "strang",
        one,
        symplectic_to(8.0),
        SMOOTH,
    ));
    cases
}

pub fn planes() -> Vec<Case> {
    use ShapeFamily::{BSpline, Lagrange};
    let mut cases = Vec::new();
    for degree in [2, 3] {
        let config = config(BSpline, degree);
        cases.push(case::<2>(&config, "strang", symplectic_to(6.5), SMOOTH));
        cases.push(case::<2>(&config, "rk2", NOT_SYMPLECTIC, RK2));
    }
    for (family, degree) in [(BSpline, 1), (Lagrange, 1), (Lagrange, 2), (Lagrange, 3)] {
        cases.push(case::<2>(&config(family, degree), "strang", BROKEN, TORN));
    }
    cases
}
