//! Initial states.

use symplint_plasma::gempic::{Gempic, GempicConfig, InitialPlasma};
use symplint_plasma::pic::ParticleWeights;

fn plasma(initial: InitialPlasma, particles: usize, cells: usize) -> Gempic {
    let gempic = Gempic::new(GempicConfig {
        cells,
        length: initial.length(),
        weights: ParticleWeights::Equal {
            particles,
            density: 1.0,
        },
        ..GempicConfig::default()
    });
    gempic.unwrap()
}

#[test]
fn states_are_finite_and_satisfy_gauss_law() {
    for (name, initial) in InitialPlasma::ALL {
        for (particles, cells) in [(1, 1), (2, 2), (7, 3), (100, 16)] {
            let gempic = plasma(initial, particles, cells);
            for amplitude in [initial.amplitude(), 0.0, -1.0] {
                let (q, p) = initial.sample(&gempic, amplitude, 42).unwrap();
                assert!(q.iter().chain(&p).all(|value| value.is_finite()), "{name}");
                let residual = gempic.gauss_residual(&q, &p);
                assert!(
                    residual < 1e-12,
                    "{name}, {particles} particles: {residual:e}"
                );
                let mean: f64 = gempic.physical(&q, &p).e1.iter().sum();
                assert!(mean.abs() < 1e-11, "{name}: {mean:e}");
                let again = initial.sample(&gempic, amplitude, 42).unwrap();
                assert_eq!(again, (q, p));
            }
        }
    }
}

/// B = A cos kx, with the energy A² L / 4, and no transverse current.
#[test]
fn instabilities_start_with_a_wave_of_the_magnetic_field() {
    for initial in [InitialPlasma::Weibel, InitialPlasma::StreamingWeibel] {
        let gempic = plasma(initial, 1200, 32);
        let (q, p) = initial.sample(&gempic, 0.01, 7).unwrap();
        let energy = gempic.energies(&q, &p).magnetic;
        let expected = 0.25 * 1e-4 * gempic.length();
        assert!(
            (energy / expected - 1.0).abs() < 1e-6,
            "{energy:e} for {expected:e}"
        );
        let physical = gempic.physical(&q, &p);
        let current: f64 = physical.v2.iter().sum();
        assert!(current.abs() < 1e-10, "{current:e}");
        // The phase: B is largest at x = 0, where A2 rises.
        let state = |x: f64| {
            let (mut q, p) = (q.clone(), p.clone());
            q[0] = x;
            gempic.physical(&q, &p).v2[0]
        };
        let slope = (state(1e-3) - state(-1e-3)) / 2e-3;
        assert!(
            (slope - 0.01).abs() < 1e-5,
            "q = −1, so v2 rises with A2: {slope}"
        );
    }
}

/// The field of a density wave 1 + A cos kx of electrons, −A sin(kx)/k, has the energy A² L / 4k².
#[test]
fn landau_damping_starts_with_a_wave_of_the_density() {
    let initial = InitialPlasma::Landau;
    let gempic = plasma(initial, 40_000, 32);
    let (q, p) = initial.sample(&gempic, 0.1, 7).unwrap();
    let expected = 0.25 * 0.01 * gempic.length() / 0.25;
    let energy = gempic.energies(&q, &p).electric_along;
    assert!(
        (energy / expected - 1.0).abs() < 1e-3,
        "{energy} for {expected}"
    );
    assert!(initial.sample(&gempic, 1.5, 7).is_err());
    assert!(initial.sample(&gempic, f64::NAN, 7).is_err());
}
