//! Tangent vectors: all unit vectors, or seeded random ones. No component is beyond ±1.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;

use crate::map::ActionGroup;
use crate::signal::unit;

/// Tangent vectors, each with the group of degrees of freedom that it belongs to.
pub(super) struct Directions {
    pub vectors: Vec<Vec<f64>>,
    pub groups: Vec<usize>,
}

impl Directions {
    /// All unit vectors.
    pub fn units(dof: usize, groups: &[ActionGroup]) -> Self {
        let mut group_of = vec![0; dof];
        for (index, group) in groups.iter().enumerate() {
            group.dofs.iter().for_each(|&i| group_of[i] = index);
        }
        Directions {
            vectors: units(dof),
            groups: group_of.repeat(2),
        }
    }

    /// So many random vectors that move all degrees of freedom, in which the first group prevails, and as many for each
    /// further group.
    pub fn random(
        dof: usize,
        groups: &[ActionGroup],
        count: usize,
        seed: u64,
        point: usize,
    ) -> Self {
        let all = random(dof, seed, point, count);
        let of_group = |group: &ActionGroup| {
            let mut vectors = vec![vec![0.0; 2 * dof]; count];
            for (vector, all) in vectors.iter_mut().zip(&all) {
                for c in group.dofs.iter().flat_map(|&i| [i, dof + i]) {
                    vector[c] = all[c];
                }
            }
            vectors
        };
        let further: Vec<Vec<f64>> = groups.iter().skip(1).flat_map(of_group).collect();
        let groups = (0..all.len() + further.len()).map(|k| k / count).collect();
        Directions {
            vectors: [all, further].concat(),
            groups,
        }
    }
}

/// The unit vectors of all 2d coordinates.
fn units(dof: usize) -> Vec<Vec<f64>> {
    let unit = |c: usize| {
        let mut direction = vec![0.0; 2 * dof];
        direction[c] = 1.0;
        direction
    };
    (0..2 * dof).map(unit).collect()
}

/// Tangent vectors at a point that move every coordinate, each pair of them with ω(u, v) of the order of the
/// product of their norms: the second of each two is conjugate to the first, v = J u, or half of it is, so that
/// forms between different degrees of freedom show.
fn random(dof: usize, seed: u64, point: usize, count: usize) -> Vec<Vec<f64>> {
    let mut generator = generator(seed, point as u64);
    let mut directions: Vec<Vec<f64>> = Vec::with_capacity(count);
    for k in 0..count {
        let mut direction = components(2 * dof, &mut generator);
        if k % 2 == 1 {
            let (q, p) = directions[k - 1].split_at(dof);
            let conjugate = p.iter().map(|p| -p).chain(q.iter().copied());
            let part = if k % 4 == 1 { 0.5 } else { 1.0 };
            for (x, conjugate) in direction.iter_mut().zip(conjugate) {
                *x = (1.0 - part) * *x + part * conjugate;
            }
        }
        directions.push(direction);
    }
    directions
}

/// A tangent vector that moves every coordinate, or coefficients none of which vanish.
pub(super) fn dense(len: usize, seed: u64) -> Vec<f64> {
    components(len, &mut generator(seed, u64::MAX))
}

fn generator(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(stream);
    generator
}

/// Numbers between ½ and 1 in size, of either sign.
fn components(len: usize, generator: &mut ChaCha8Rng) -> Vec<f64> {
    let component = |_| {
        let x = 2.0 * unit(generator) - 1.0;
        0.5 * x + 0.5f64.copysign(x)
    };
    (0..len).map(component).collect()
}
