//! Which cell's force a particle gets at the nodes, at the ends of the box, and far outside of it.

use proptest::prelude::*;
use symplint_plasma::pic::{ParticleWeights, Pic, Pic1d, Pic2d, PicConfig, ShapeFamily};

type ShapeOf = (ShapeFamily, usize);

/// Equal weights that make the density 1.
fn pic<const D: usize>(
    (family, degree): ShapeOf,
    cells: usize,
    length: f64,
    particles: usize,
) -> Pic<D> {
    let density = 1.0;
    Pic::new(PicConfig {
        weights: ParticleWeights::Equal { particles, density },
        cells,
        length,
        family,
        degree,
        filter_passes: 0,
    })
    .unwrap()
}

fn shapes() -> impl Iterator<Item = ShapeOf> {
    let splines = (1..=5).map(|degree| (ShapeFamily::BSpline, degree));
    splines.chain((1..=3).map(|degree| (ShapeFamily::Lagrange, degree)))
}

/// Two particles have their force pair by pair, many by way of the mesh.
const PARTICLES: [usize; 2] = [2, 30];

/// The field at `x`, the other particles staying where they are.
fn field_at(system: &Pic1d, x: f64) -> f64 {
    let (particles, length) = (system.weights().len(), system.length());
    let mut positions = vec![x];
    positions.extend((1..particles).map(|a| length * ((0.3 + 0.618 * (a - 1) as f64) % 1.0)));
    system.field(&positions)[0]
}

#[test]
fn both_ends_of_the_box_have_the_force_of_the_first_cell() {
    for shape in shapes() {
        for (length, cells) in [
            (49.0, 8),
            (49.0, 4),
            (49.0, 128),
            (12.566, 7),
            (12.566, 127),
            (628.0 / 100.0, 500),
            (1.0, 100),
            (50.0, 128),
        ] {
            for particles in PARTICLES {
                let system: Pic1d = pic(shape, cells, length, particles);
                let field = field_at(&system, 0.0);
                for turns in [1.0, -1.0, 2.0, -1024.0, 2.0_f64.powi(30)] {
                    assert_eq!(
                        field_at(&system, turns * length),
                        field,
                        "{shape:?}, {cells} cells of {length}, {particles} particles, {turns} turns"
                    );
                }
                // That cell, and not the last: forces are continuous from above.
                let above = field_at(&system, 1e-13 * length);
                assert!((above - field).abs() < 1e-6 * length, "{above} for {field}");
            }
        }
    }
}

/// Figures of the linear finite-element equations, solved in rational numbers by another code.
#[test]
fn linear_splines_at_the_ends_of_the_box() {
    let system: Pic1d = pic((ShapeFamily::BSpline, 1), 8, 49.0, 2);
    for x in [0.0, 49.0, -49.0] {
        let field = system.field(&[x, 0.3 * 49.0])[0];
        assert!((field - 4.2875).abs() < 1e-12, "{x}: {field}");
    }
    let below = system.field(&[49.0_f64.next_down(), 0.3 * 49.0])[0];
    assert!((below + 14.0875).abs() < 1e-12, "{below}");
}

/// Figures as above.
#[test]
fn all_nodes_are_alike() {
    let system: Pic1d = pic((ShapeFamily::BSpline, 1), 100, 1.0, 2);
    for i in 0..=100 {
        let other = (f64::from(i) + 5.3) / 100.0;
        let node = f64::from(i) / 100.0;
        let field = system.field(&[node, other])[0];
        assert!((field - 0.0215).abs() < 1e-13, "node {i}: {field}");
        let below = system.field(&[node.next_down(), other])[0];
        assert!((below + 0.4685).abs() < 1e-12, "below node {i}: {below}");
    }
}

#[test]
fn forces_at_nodes_are_continuous_from_above() {
    for shape in shapes() {
        for (length, cells) in [(1.0, 100), (12.566, 7), (628.0 / 100.0, 37), (49.0, 49)] {
            let system: Pic1d = pic(shape, cells, length, 30);
            for i in 0..cells {
                let node = i as f64 * length / cells as f64;
                let off =
                    (field_at(&system, node) - field_at(&system, node + 1e-10 * length)).abs();
                assert!(
                    off < 1e-7 * length,
                    "{shape:?}, node {i} of {cells} cells of {length}: {off:e}"
                );
            }
        }
    }
}

#[test]
fn the_force_is_as_good_far_away() {
    for shape in shapes() {
        for (length, cells) in [
            (49.0, 128),
            (628.0 / 100.0, 50),
            (std::f64::consts::TAU, 16),
        ] {
            for particles in PARTICLES {
                let system: Pic1d = pic(shape, cells, length, particles);
                for turns in [3.0, 1e3, 1.6e7, 1.7e7, 1e9, 1e12, 1e15, 1e100] {
                    for part in [-0.93, -0.41, 0.13, 0.77] {
                        let x = (turns + part) * length;
                        for x in [x, -x] {
                            // The remainder is exact in floating point.
                            let (far, near) = (field_at(&system, x), field_at(&system, x % length));
                            assert!(
                                (far - near).abs() < 1e-13 * length * cells as f64,
                                "{shape:?}, {cells} cells of {length}, x = {x}: {far} for {near}"
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn a_plane_has_the_force_of_the_same_cells() {
    for shape in shapes() {
        for (length, cells) in [(49.0, 8), (12.566, 7), (1.0, 29)] {
            let system: Pic2d = pic(shape, cells, length, 2);
            let other = [0.3 * length, 0.4 * length];
            let field = |x: f64, y: f64| system.field(&[x, y, other[0], other[1]]);
            let corner = field(0.0, 0.0);
            for (right, up) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 1024.0)] {
                assert_eq!(field(right * length, up * length), corner, "{shape:?}");
            }
            let y = 0.77 * length;
            let x = (1e9 + 0.3) * length;
            let (far, near) = (field(x, y), field(x % length, y));
            for (far, near) in far.iter().zip(near) {
                assert!((far - near).abs() < 1e-11 * length, "{far} for {near}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Where x and x + 2^k L are both floating-point numbers, they are the same place.
    #[test]
    fn whole_periods_change_nothing(
        shape in prop::sample::select(shapes().collect::<Vec<_>>()),
        cells in 1_usize..200,
        length in 0.1_f64..100.0,
        part in 0.0_f64..1.0,
        at_node: bool,
        exponent in 0_i32..40,
        sign in prop_oneof![Just(1.0), Just(-1.0)],
        particles in prop::sample::select(PARTICLES.to_vec()),
    ) {
        let system: Pic1d = pic(shape, cells, length, particles);
        let periods = sign * length * 2.0_f64.powi(exponent);
        let x = if at_node {
            (part * cells as f64).floor() * length / cells as f64
        } else {
            part * length
        };
        // The nearest position that is.
        let far = x + periods;
        let near = far - periods;
        prop_assume!(near + periods == far && far - near == periods);
        let (a, b) = (field_at(&system, near), field_at(&system, far));
        prop_assert!((a - b).abs() < 1e-13 * length * cells as f64, "{} for {}", a, b);
    }
}
