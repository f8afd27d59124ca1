//! Particle-in-cell forces against differences of the field energy, and what symmetry demands.

use symplint::state::{Rows, RowsMut};
use symplint_models::systems::TwoCell;
use symplint_models::{ModelError, Separable};
use symplint_plasma::pic::{ParticleWeights, Pic, Pic1d, Pic2d, PicConfig, ShapeFamily};

fn pic<const D: usize>(
    (family, degree): (ShapeFamily, usize),
    cells: usize,
    length: f64,
    filter_passes: u32,
    weights: Vec<f64>,
) -> Pic<D> {
    Pic::new(PicConfig {
        weights: ParticleWeights::Each(weights),
        cells,
        length,
        family,
        degree,
        filter_passes,
    })
    .unwrap()
}

fn shapes() -> impl Iterator<Item = (ShapeFamily, usize)> {
    let splines = (1..=5).map(|degree| (ShapeFamily::BSpline, degree));
    splines.chain((1..=3).map(|degree| (ShapeFamily::Lagrange, degree)))
}

fn energy(system: &dyn Separable, q: &[f64]) -> f64 {
    let mut out = [0.0];
    system.potential_energy(Rows::new(q, q.len(), 1, 1), &mut out);
    out[0]
}

/// The force on the velocities, as a kick of unit time gives it.
fn kicked(system: &dyn Separable, q: &[f64]) -> Vec<f64> {
    let (dof, mut v) = (q.len(), vec![0.0; q.len()]);
    system.kick(
        1.0,
        Rows::new(q, dof, 1, 1),
        &mut RowsMut::new(&mut v, dof, 1, 1),
    );
    v
}

fn largest(values: &[f64]) -> f64 {
    values
        .iter()
        .fold(0.0, |largest, value| value.abs().max(largest))
}

/// Numbers in (0, 1) without a pattern.
fn scattered(seed: usize) -> impl FnMut() -> f64 {
    let mut k = seed as f64;
    move || {
        k += 1.0;
        (k * 0.618_033_988_749_894_9 + (k * k).sin() * 0.1).rem_euclid(1.0)
    }
}

/// Positions that stay away from cell boundaries, some of them outside the box.
fn inside_cells<const D: usize>(particles: usize, cells: usize, width: f64) -> Vec<f64> {
    let mut random = scattered(D + 10 * cells);
    (0..D * particles)
        .map(|i| {
            let turn = (i % 3) as f64 - 1.0;
            let cell = (random() * cells as f64).floor() + turn * cells as f64;
            width * (cell + 0.1 + 0.8 * random())
        })
        .collect()
}

/// The worst error of the force relative to the largest force.
fn force_error<const D: usize>(shape: (ShapeFamily, usize), cells: usize, passes: u32) -> f64 {
    const WIDTH: f64 = 0.7;
    let weights = vec![1.0, 0.3, 2.5, -0.4, 0.8];
    let system: Pic<D> = pic(shape, cells, WIDTH * cells as f64, passes, weights.clone());
    let positions = inside_cells::<D>(weights.len(), cells, WIDTH);
    let force = kicked(&system, &positions);
    assert_eq!(force, system.field(&positions));
    let scale = largest(&force);
    // Small boxes have steep fields; large ones have large energies, whose round-off counts.
    let step = WIDTH
        * match cells.pow(D as u32) {
            1..100 => 6e-4,
            100..1000 => 1e-3,
            _ => 2.5e-3,
        };
    let mut worst: f64 = 0.0;
    for (i, force) in force.iter().enumerate() {
        let at = |k: f64| {
            let mut shifted = positions.clone();
            shifted[i] += k * step;
            energy(&system, &shifted)
        };
        let slope = (at(-2.0) - at(2.0) + 8.0 * (at(1.0) - at(-1.0))) / (12.0 * step);
        worst = worst.max((force + slope / weights[i / D]).abs());
    }
    // On one cell splines have no field; two cells and a filter leave none for linear shapes.
    if scale < 1e-13 {
        assert!(worst < 1e-12, "{worst:e}");
        return 0.0;
    }
    worst / scale
}

#[test]
fn forces_are_gradients_of_the_energy() {
    for shape in shapes() {
        for passes in [0, 2, 3] {
            for cells in [1, 2, 3, 8, 128] {
                let error = force_error::<1>(shape, cells, passes);
                assert!(
                    error < 1e-9,
                    "{shape:?}, {cells} cells, {passes} passes: {error:e}"
                );
            }
            for cells in [1, 2, 3, 8] {
                let error = force_error::<2>(shape, cells, passes);
                assert!(
                    error < 1e-9,
                    "{shape:?}, {cells}² cells, {passes} passes: {error:e}"
                );
            }
        }
    }
}

#[test]
fn forces_are_gradients_on_a_large_plane() {
    for shape in [(ShapeFamily::BSpline, 3), (ShapeFamily::Lagrange, 2)] {
        let error = force_error::<2>(shape, 128, 2);
        assert!(error < 1e-9, "{shape:?}: {error:e}");
    }
}

/// Total force Σ w_a E(x_a) along an axis.
fn total_force<const D: usize>(system: &Pic<D>, positions: &[f64]) -> f64 {
    largest(&system.momentum(&system.field(positions)))
}

/// H is invariant under a shift by a cell, so the total force, integrated over such a shift of all
/// particles together, does nothing. It does not vanish by itself.
#[test]
fn the_total_force_vanishes_on_average_over_a_cell() {
    // Gauss–Legendre, exact for degree 11: the highest is 2 · 5 − 1, all particles being at the same
    // fraction of their cells.
    let half = [
        (0.238_619_186_083_196_9, 0.467_913_934_572_691_04),
        (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
        (0.932_469_514_203_152, 0.171_324_492_379_170_36),
    ];
    let points = half.into_iter().flat_map(|(x, w)| [(-x, w), (x, w)]);
    let points: Vec<(f64, f64)> = points.map(|(x, w)| (0.5 + 0.5 * x, 0.5 * w)).collect();
    let weights = vec![1.0, 0.3, 2.5];
    let cells_of = [1.0, 6.0, 4.0];
    for shape in shapes() {
        for passes in [0, 2] {
            let system: Pic1d = pic(shape, 9, 9.0, passes, weights.clone());
            let (mut sum, mut size): (f64, f64) = (0.0, 0.0);
            for &(fraction, weight) in &points {
                let positions = cells_of.map(|cell| cell + fraction);
                let force = system.momentum(&system.field(&positions))[0];
                sum += weight * force;
                size = size.max(force.abs());
            }
            assert!(sum.abs() < 1e-13, "{shape:?}, {passes} passes: {sum:e}");
            assert!(size > 1e-7, "{shape:?}: nothing to average");
        }
    }
}

/// Mirrored about a node, forces are mirrored, too.
#[test]
fn mirror_images_push_each_other_equally() {
    for shape in shapes() {
        for passes in [0, 2, 3] {
            let weights = vec![1.3; 4];
            let line: Pic1d = pic(shape, 8, 8.0, passes, weights.clone());
            let force = total_force(&line, &[3.3, 2.7, 6.6, -0.6]);
            assert!(force < 1e-13, "{shape:?}, {passes} passes: {force:e}");
            let plane: Pic2d = pic(shape, 8, 8.0, passes, weights);
            let positions = [3.3, 4.2, 2.7, 3.8, 6.6, 7.1, -0.6, 0.9];
            let force = total_force(&plane, &positions);
            assert!(force < 1e-13, "{shape:?}, {passes} passes: {force:e}");
        }
    }
}

/// The remaining total force falls with the width of the filter and the degree.
#[test]
fn smooth_shapes_nearly_conserve_momentum() {
    let force = |degree, passes| {
        let weights = vec![1.0, 0.3, 2.5];
        let system: Pic1d = pic((ShapeFamily::BSpline, degree), 16, 16.0, passes, weights);
        total_force(&system, &[1.2, 6.9, 12.4])
    };
    for degree in 2..=5 {
        assert!(force(degree, 0) < 0.9 * force(degree - 1, 0));
        assert!(force(degree, 4) < 0.9 * force(degree - 1, 4));
    }
    assert!(force(5, 4) < 1e-2 * force(5, 0));
}

#[test]
fn shifts_by_whole_cells_change_nothing() {
    let weights = vec![1.0, 0.3, 2.5];
    for shape in shapes() {
        let line: Pic1d = pic(shape, 8, 4.0, 2, weights.clone());
        let positions = [0.3, 1.85, 3.1];
        let (field, h) = (line.field(&positions), energy(&line, &positions));
        // Halves are exact, so only the solver's rounding errors differ.
        for cells in [1.0, 3.0, 8.0, -8.0, 11.0] {
            let shifted = positions.map(|x| x + 0.5 * cells);
            assert!((energy(&line, &shifted) / h - 1.0).abs() < 1e-12);
            for (a, b) in line.field(&shifted).iter().zip(&field) {
                assert!((a - b).abs() < 1e-12, "{shape:?}: {a} for {b}");
            }
        }
        let plane: Pic2d = pic(shape, 8, 4.0, 2, weights.clone());
        let positions = [0.3, 0.4, 1.85, 2.6, 3.1, 0.9];
        let (field, h) = (plane.field(&positions), energy(&plane, &positions));
        for (right, up) in [(1.0, 0.0), (0.0, 5.0), (-8.0, 3.0)] {
            let mut shifted = positions;
            for x in shifted.chunks_exact_mut(2) {
                x[0] += 0.5 * right;
                x[1] += 0.5 * up;
            }
            assert!((energy(&plane, &shifted) / h - 1.0).abs() < 1e-12);
            for (a, b) in plane.field(&shifted).iter().zip(&field) {
                assert!((a - b).abs() < 1e-12, "{shape:?}: {a} for {b}");
            }
        }
    }
}

#[test]
fn the_ends_of_the_box_are_one_place() {
    for shape in shapes() {
        let system: Pic1d = pic(shape, 16, 2.0, 0, vec![1.0, 0.7]);
        let other = 0.84;
        let field = system.field(&[0.0, other]);
        // 1e6 boxes of length 2 are exact.
        for x in [-0.0, 2.0, -2.0, 2e6, -2e6, 2.0 * 2.0_f64.powi(40)] {
            assert_eq!(system.field(&[x, other]), field, "{shape:?}, x = {x}");
        }
        // Continuous force: just below the boundary it is the same; a jump otherwise.
        let below = system.field(&[-1e-12, other])[0] - field[0];
        let smooth = shape.0 == ShapeFamily::BSpline && shape.1 > 1;
        assert_eq!(below.abs() < 1e-9, smooth, "{shape:?}: {below:e}");
        // A position below 0 by less than a rounding error does not fall out of the box.
        let grazing = system.field(&[-1e-300, other]);
        assert!(grazing.iter().all(|e| e.is_finite()));
    }
}

#[test]
fn lagrange_elements_of_degree_1_are_linear_splines() {
    for passes in [0, 1, 2] {
        for cells in [1, 2, 3, 16] {
            let weights = vec![1.0, 0.3, 2.5];
            let (spline, lagrange) = ((ShapeFamily::BSpline, 1), (ShapeFamily::Lagrange, 1));
            let a: Pic1d = pic(spline, cells, 3.0, passes, weights.clone());
            let b: Pic1d = pic(lagrange, cells, 3.0, passes, weights.clone());
            let positions = [0.1, 2.2, 3.0];
            for (a, b) in a.field(&positions).iter().zip(b.field(&positions)) {
                assert!((a - b).abs() < 1e-13);
            }
            let a: Pic2d = pic(spline, cells, 3.0, passes, weights.clone());
            let b: Pic2d = pic(lagrange, cells, 3.0, passes, weights);
            let positions = [0.1, 0.4, 2.2, 1.3, 3.0, 0.0];
            assert!((energy(&a, &positions) - energy(&b, &positions)).abs() < 1e-13);
            for (a, b) in a.field(&positions).iter().zip(b.field(&positions)) {
                assert!((a - b).abs() < 1e-13);
            }
        }
    }
}

/// A plane in which every particle is spread over a column of cells is a stack of lines: with one
/// copy in each cell across, the splines across sum to 1.
#[test]
fn a_plane_without_dependence_on_y_is_a_line() {
    const CELLS: usize = 6;
    const LENGTH: f64 = 4.5;
    let line_weights = [1.0, 0.3, 2.5];
    let line_positions = [0.2, 1.9, 3.3];
    for degree in 1..=5 {
        for passes in [0, 2] {
            let shape = (ShapeFamily::BSpline, degree);
            let line: Pic1d = pic(shape, CELLS, LENGTH, passes, line_weights.to_vec());
            let (mut weights, mut positions) = (Vec::new(), Vec::new());
            for (weight, x) in line_weights.iter().zip(line_positions) {
                for cell in 0..CELLS {
                    // Charge per length across: so much that densities agree.
                    weights.push(weight * LENGTH / CELLS as f64);
                    positions.extend([x, (cell as f64 + 0.37) * LENGTH / CELLS as f64]);
                }
            }
            let plane: Pic2d = pic(shape, CELLS, LENGTH, passes, weights);
            let (on_line, in_plane) = (line.field(&line_positions), plane.field(&positions));
            for (a, field) in in_plane.chunks_exact(2).enumerate() {
                let expected = on_line[a / CELLS];
                assert!((field[0] - expected).abs() < 1e-12, "degree {degree}");
                assert!(field[1].abs() < 1e-12, "degree {degree}");
            }
            let ratio = energy(&plane, &positions) / energy(&line, &line_positions);
            assert!((ratio / LENGTH - 1.0).abs() < 1e-12, "degree {degree}");
        }
    }
}

#[test]
fn axes_of_a_plane_are_alike() {
    let weights = vec![1.0, 0.3, 2.5];
    for shape in shapes() {
        let plane: Pic2d = pic(shape, 5, 5.0, 2, weights.clone());
        let (a, b) = (
            [0.3, 1.1, 2.8, 4.6, 3.3, 0.2],
            [1.1, 0.3, 4.6, 2.8, 0.2, 3.3],
        );
        let (force, swapped) = (plane.field(&a), plane.field(&b));
        for i in 0..6 {
            assert!((force[i] - swapped[i ^ 1]).abs() < 1e-13, "{shape:?}");
        }
    }
}

#[test]
fn two_cells_and_one_particle_are_the_closed_form() {
    for length in [1.0, 0.3, 25.0] {
        let closed = TwoCell::new(length).unwrap();
        let weight = 1.0 / length;
        let shape = (ShapeFamily::BSpline, 1);
        let system: Pic1d = pic(shape, 2, 2.0 * length, 0, vec![weight]);
        let constant = energy(&system, &[0.0]) / weight - energy(&closed, &[0.0]);
        assert!((constant - 1.0 / 16.0).abs() < 1e-15);
        for step in -40..=40 {
            let x = f64::from(step) / 20.0 * length;
            let (force, expected) = (kicked(&system, &[x])[0], kicked(&closed, &[x])[0]);
            assert!(
                (force - expected).abs() * length < 1e-15,
                "x = {x}: {force}, {expected}"
            );
            let difference = energy(&system, &[x]) / weight - energy(&closed, &[x]);
            assert!((difference - constant).abs() < 1e-15, "x = {x}");
        }
    }
}

/// Samples of a block, and rows of a table, do not mix.
#[test]
fn a_block_is_its_samples() {
    let system: Pic2d = pic((ShapeFamily::Lagrange, 2), 4, 2.0, 2, vec![1.0, 0.4]);
    let mut random = scattered(1);
    let q: Vec<f64> = (0..4 * 5).map(|_| 2.0 * random()).collect();
    let mut v = vec![0.25; 20];
    system.kick(
        0.5,
        Rows::new(&q, 4, 5, 3),
        &mut RowsMut::new(&mut v, 4, 5, 3),
    );
    for sample in 0..5 {
        let own: Vec<f64> = (0..4).map(|i| q[5 * i + sample]).collect();
        let field = system.field(&own);
        for i in 0..4 {
            let expected = 0.25 + if sample < 3 { 0.5 * field[i] } else { 0.0 };
            assert_eq!(v[5 * i + sample], expected);
        }
    }
    let weights: Vec<f64> = (0..4).map(|i| system.coordinates().weight(i)).collect();
    assert_eq!(weights, [1.0, 1.0, 0.4, 0.4]);
    let mut kinetic = [0.0];
    system.kinetic_energy(Rows::new(&[1.0, 2.0, 3.0, -4.0], 4, 1, 1), &mut kinetic);
    assert!((kinetic[0] - (0.5 * 5.0 + 0.2 * 25.0)).abs() < 1e-14);
}

#[test]
fn equal_weights_make_the_density() {
    let weights = ParticleWeights::Equal {
        particles: 8,
        density: 2.0,
    };
    let config = PicConfig {
        weights,
        length: 3.0,
        ..PicConfig::default()
    };
    assert_eq!(Pic1d::new(config.clone()).unwrap().weights(), [0.75; 8]);
    assert_eq!(Pic2d::new(config).unwrap().weights(), [2.25; 8]);
}

#[test]
fn what_makes_no_system_is_refused_with_the_reason() {
    let refused = |change: &dyn Fn(&mut PicConfig)| -> ModelError {
        let mut config = PicConfig::default();
        change(&mut config);
        let error = Pic1d::new(config.clone()).err().expect("a line");
        assert!(Pic2d::new(config).is_err());
        error
    };
    let empty = refused(&|config| config.weights = ParticleWeights::Each(vec![]));
    assert!(empty.to_string().contains("0 particles"), "{empty}");
    let none = refused(&|config| {
        config.weights = ParticleWeights::Equal {
            particles: 0,
            density: 1.0,
        };
    });
    assert_eq!(none, empty);
    for weight in [0.0, f64::NAN, f64::INFINITY] {
        let error = refused(&|config| config.weights = ParticleWeights::Each(vec![1.0, weight]));
        assert!(
            error.to_string().contains("weight of a particle"),
            "{error}"
        );
        let error = refused(&|config| {
            config.weights = ParticleWeights::Equal {
                particles: 3,
                density: weight,
            };
        });
        assert!(error.to_string().contains("density"), "{error}");
    }
    let error = refused(&|config| config.weights = ParticleWeights::Each(vec![1e308; 2]));
    assert!(error.to_string().contains("total weight"), "{error}");
    let error = refused(&|config| config.cells = 0);
    assert!(matches!(error, ModelError::Empty { .. }));
    let error = refused(&|config| config.cells = usize::MAX);
    assert!(matches!(error, ModelError::TooManyCells { .. }));
    for length in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = refused(&|config| config.length = length);
        assert!(error.to_string().contains("length"), "{error}");
    }
    for (family, degree) in [
        (ShapeFamily::BSpline, 0),
        (ShapeFamily::BSpline, 6),
        (ShapeFamily::Lagrange, 0),
        (ShapeFamily::Lagrange, 4),
    ] {
        let error = refused(&|config| (config.family, config.degree) = (family, degree));
        assert!(matches!(error, ModelError::ShapeDegree { .. }));
    }
}

/// A state that is not finite stays one, for the diagnostic to find; it does not panic.
#[test]
fn positions_that_are_not_finite_give_no_number() {
    let system: Pic1d = pic((ShapeFamily::BSpline, 2), 8, 1.0, 0, vec![1.0, 1.0]);
    for x in [f64::NAN, f64::INFINITY] {
        assert!(system.field(&[x, 0.2]).iter().all(|field| field.is_nan()));
    }
}

/// Extreme sizes cost precision nowhere: with x and v in units of L, only the charge has a unit.
#[test]
fn forces_scale_with_the_box() {
    for shape in shapes() {
        let unit: Pic1d = pic(shape, 8, 1.0, 2, vec![1.0, 0.3]);
        let unit_plane: Pic2d = pic(shape, 8, 1.0, 2, vec![1.0, 0.3]);
        let (x, xy) = ([0.3, 0.81], [0.3, 0.1, 0.81, 0.66]);
        for length in [2.0_f64.powi(-900), 2.0_f64.powi(-30), 2.0_f64.powi(900)] {
            let line: Pic1d = pic(shape, 8, length, 2, vec![1.0, 0.3]);
            assert_eq!(line.field(&x.map(|x| x * length)), unit.field(&x));
            let plane: Pic2d = pic(shape, 8, length, 2, vec![1.0, 0.3]);
            let field = plane.field(&xy.map(|x| x * length));
            assert!(
                field
                    .iter()
                    .zip(unit_plane.field(&xy))
                    .all(|(a, b)| a * length == b)
            );
        }
    }
}
