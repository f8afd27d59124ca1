//! Circles in the (q_i, p_i) planes: the loop of the paper.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::SeedableRng;

use super::Loop;
use super::turn::sin_cos_turn;
use crate::error::Error;
use crate::signal::{GOLDEN_RATIO, unit};
use crate::state::Block;
use crate::state::scratch;

/// q_i = q0_i + a_i sin 2π(s + φ_i), p_i = p0_i + b_i cos 2π(s + φ_i), with ∮ p·dq = π Σ a_i b_i.
///
/// The phases φ_i are staggered by default. With one radius a_i = b_i = r and [equal phases](Phases::Equal) it is the loop
/// of Barham & Burby, section 4.
///
/// ```
/// use symplint::{Circle, Ensemble, LoopIntegral, Rule};
///
/// let circle = Circle::new(vec![3.0, -1.0], vec![0.5, 0.0], 0.1)?;
/// let ensemble = Ensemble::sample(&circle, 64)?;
/// let integral = LoopIntegral::of(&ensemble, &Rule::Pseudospectral)?;
/// assert!((integral.value - 2.0 * std::f64::consts::PI * 0.01).abs() < 1e-15);
/// # Ok::<(), symplint::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Circle {
    q0: Vec<f64>,
    p0: Vec<f64>,
    /// a_i.
    radii_q: Vec<f64>,
    /// b_i, if they differ from a_i.
    radii_p: Option<Vec<f64>>,
    phases: Phases,
    /// (sin 2πφ_i, cos 2πφ_i) of random phases. Others are computed when they are needed.
    random: Vec<(f64, f64)>,
}

/// Where on its circle each degree of freedom starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Phases {
    /// φ_i is the fractional part of i φ, with the golden ratio φ = 0.618…: no two degrees of freedom move in phase.
    #[default]
    Staggered,
    /// φ_i = 0: the loop of the paper. All degrees of freedom move in phase. With equal radii, the loop is a translation of
    /// the system as a whole: the distances between its particles do not change, and forces between pairs are not tested.
    Equal,
    /// Random phases.
    Random {
        /// The phases depend on this number only.
        seed: u64,
    },
}

impl Phases {
    /// The names of all, as configurations have them.
    pub const NAMES: [&'static str; 3] = ["staggered", "equal", "random"];

    /// The phases of this name; `seed` is for random phases.
    ///
    /// ```
    /// use symplint::Phases;
    ///
    /// assert_eq!(Phases::named("random", 3), Some(Phases::Random { seed: 3 }));
    /// assert_eq!(Phases::named("golden", 3), None);
    /// ```
    pub fn named(name: &str, seed: u64) -> Option<Self> {
        let all = [Phases::Staggered, Phases::Equal, Phases::Random { seed }];
        let position = Self::NAMES.iter().position(|&known| known == name)?;
        Some(all[position])
    }
}

impl Circle {
    /// A circle of radius `radius` round (q0_i, p0_i) in every degree of freedom.
    ///
    /// # Errors
    /// If `q0` and `p0` differ in length, a centre is not finite, or the radius is not
    /// positive and finite.
    pub fn new(q0: Vec<f64>, p0: Vec<f64>, radius: f64) -> Result<Self, Error> {
        let radii = vec![radius; q0.len()];
        if radius <= 0.0 {
            return Err(out_of_range(radius));
        }
        Self::checked(q0, p0, radii, None)
    }

    /// An ellipse in every degree of freedom, of radius `radii_q[i]` in q_i and `radii_p[i]` in p_i: units of
    /// positions and momenta differ, and so do degrees of freedom. One whose radii are 0 stays at its centre.
    ///
    /// [`balanced_radii`](crate::map::balanced_radii) finds radii that fit a map.
    ///
    /// # Errors
    /// If the lists differ in length, a centre is not finite, or a radius is negative or not finite.
    pub fn with_radii(
        q0: Vec<f64>,
        p0: Vec<f64>,
        radii_q: Vec<f64>,
        radii_p: Vec<f64>,
    ) -> Result<Self, Error> {
        Self::checked(q0, p0, radii_q, Some(radii_p))
    }

    fn checked(
        q0: Vec<f64>,
        p0: Vec<f64>,
        radii_q: Vec<f64>,
        radii_p: Option<Vec<f64>>,
    ) -> Result<Self, Error> {
        let of_p = radii_p.as_ref().unwrap_or(&radii_q);
        Error::check_length("centre p0", q0.len(), p0.len())?;
        Error::check_length("radii in q", q0.len(), radii_q.len())?;
        Error::check_length("radii in p", q0.len(), of_p.len())?;
        check_centre("q", &q0)?;
        check_centre("p", &p0)?;
        let wrong = |&&radius: &&f64| !(radius.is_finite() && radius >= 0.0);
        if let Some(&radius) = radii_q.iter().chain(of_p).find(wrong) {
            return Err(out_of_range(radius));
        }
        Ok(Circle {
            q0,
            p0,
            radii_q,
            radii_p,
            phases: Phases::default(),
            random: Vec::new(),
        })
    }

    /// Keeps the circle on the degrees of freedom named; the others stay at their centres.
    ///
    /// # Errors
    /// If one does not exist or none is named.
    pub fn on(mut self, dofs: &[usize]) -> Result<Self, Error> {
        if dofs.is_empty() {
            return Err(Error::OutOfRange {
                what: "number of degrees of freedom that the loop moves",
                value: 0.0,
                remedy: "name one or more",
            });
        }
        let count = self.q0.len();
        if let Some(&dof) = dofs.iter().find(|&&dof| dof >= count) {
            return Err(Error::NoSuchDof { dof, count });
        }
        for dof in (0..count).filter(|dof| !dofs.contains(dof)) {
            self.radii_q[dof] = 0.0;
            if let Some(radii) = &mut self.radii_p {
                radii[dof] = 0.0;
            }
        }
        Ok(self)
    }

    /// The same circles with other phases.
    ///
    /// ```
    /// use symplint::{Circle, Phases};
    ///
    /// // The loop of the paper in three degrees of freedom.
    /// let circle = Circle::new(vec![0.0; 3], vec![0.5; 3], 1.0)?.with_phases(Phases::Equal);
    /// # Ok::<(), symplint::Error>(())
    /// ```
    pub fn with_phases(mut self, phases: Phases) -> Self {
        self.phases = phases;
        self.random = match phases {
            Phases::Random { seed } => {
                let mut random = ChaCha8Rng::seed_from_u64(seed);
                let turns = self.q0.iter().map(|_| sin_cos_turn(unit(&mut random)));
                turns.collect()
            }
            _ => Vec::new(),
        };
        self
    }

    /// (sin 2πφ_i, cos 2πφ_i).
    fn phase(&self, i: usize) -> (f64, f64) {
        match self.phases {
            Phases::Staggered => sin_cos_turn(i as f64 * GOLDEN_RATIO),
            Phases::Equal => (0.0, 1.0),
            Phases::Random { .. } => self.random[i],
        }
    }
}

fn out_of_range(radius: f64) -> Error {
    Error::OutOfRange {
        what: "radius of the loop",
        value: radius,
        remedy: "give a positive finite radius",
    }
}

fn check_centre(coordinate: &'static str, values: &[f64]) -> Result<(), Error> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(dof) => Err(Error::BadCentre {
            coordinate,
            dof,
            value: values[dof],
        }),
    }
}

impl Loop for Circle {
    fn dof(&self) -> usize {
        self.q0.len()
    }

    fn sample(&self, s: &[f64], block: &mut Block<'_>) {
        let n = s.len();
        scratch::with_buffer(2 * n, |buffer| {
            let (sin, cos) = buffer.split_at_mut(n);
            for (k, &s) in s.iter().enumerate() {
                (sin[k], cos[k]) = sin_cos_turn(s);
            }
            for i in 0..self.dof() {
                // sin(a + φ) and cos(a + φ) by the addition theorems.
                let (sin_phase, cos_phase) = self.phase(i);
                let of_phase = |r: f64| (r * cos_phase, r * sin_phase);
                let (along, across) = of_phase(self.radii_q[i]);
                let q = block.q.row_mut(i);
                for k in 0..n {
                    q[k] = self.q0[i] + (along * sin[k] + across * cos[k]);
                }
                let (along, across) = of_phase(self.radii_p.as_ref().unwrap_or(&self.radii_q)[i]);
                let p = block.p.row_mut(i);
                for k in 0..n {
                    p[k] = self.p0[i] + (along * cos[k] - across * sin[k]);
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rules::{LoopIntegral, Rule};
    use crate::state::Ensemble;
    use std::f64::consts::PI;

    #[test]
    fn chosen_degrees_of_freedom_move_and_the_others_rest() {
        let circle = Circle::new(vec![1.0, 2.0, 3.0], vec![0.0; 3], 0.5)
            .and_then(|circle| circle.on(&[1]))
            .unwrap();
        let ensemble = Ensemble::sample(&circle, 32).unwrap();
        assert!(ensemble.q().row(0).iter().all(|&q| q == 1.0));
        assert!(ensemble.p().row(2).iter().all(|&p| p == 0.0));
        let integral = LoopIntegral::of(&ensemble, &Rule::Pseudospectral).unwrap();
        assert!((integral.value - PI * 0.25).abs() < 1e-15);
        assert_eq!(integral.contributions[0], 0.0);
    }

    #[test]
    fn phases_keep_the_integral_and_move_the_start() {
        for phases in [Phases::Staggered, Phases::Random { seed: 7 }] {
            let circle = Circle::new(vec![0.0; 5], vec![0.0; 5], 1.0).unwrap();
            let ensemble = Ensemble::sample(&circle.with_phases(phases), 32).unwrap();
            assert!(ensemble.q().row(0)[0] != ensemble.q().row(1)[0]);
            let integral = LoopIntegral::of(&ensemble, &Rule::Pseudospectral).unwrap();
            for contribution in &integral.contributions {
                assert!((contribution - PI).abs() < 3e-15);
            }
        }
    }

    #[test]
    fn staggered_phases_are_multiples_of_the_golden_ratio() {
        let circle = Circle::new(vec![0.0; 40], vec![0.0; 40], 1.0).unwrap();
        let start = Ensemble::sample(&circle, 3).unwrap();
        let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
        for i in 0..40 {
            let (sin, cos) = (std::f64::consts::TAU * golden * i as f64).sin_cos();
            assert!((start.q().row(i)[0] - sin).abs() < 1e-13);
            assert!((start.p().row(i)[0] - cos).abs() < 1e-13);
        }
    }

    #[test]
    fn equal_phases_keep_all_distances() {
        let circle = Circle::new(vec![0.0, 1.0, 3.0], vec![0.5; 3], 0.3).unwrap();
        let spread = |circle: &Circle| {
            let ensemble = Ensemble::sample(circle, 16).unwrap();
            let (first, last) = (ensemble.q().row(0).to_vec(), ensemble.q().row(2).to_vec());
            let distances: Vec<f64> = (last.iter().zip(first)).map(|(a, b)| a - b).collect();
            distances
                .iter()
                .map(|d| (d - 3.0).abs())
                .fold(0.0, f64::max)
        };
        assert!(spread(&circle.clone().with_phases(Phases::Equal)) < 1e-15);
        assert!(spread(&circle) > 0.3);
    }

    #[test]
    fn an_ellipse_has_the_area_of_both_radii() {
        let (q, p) = (vec![1e-3, 2.0, 0.0], vec![1e6, 0.5, 0.0]);
        let ellipse = Circle::with_radii(vec![0.0; 3], vec![0.0; 3], q, p).unwrap();
        let ensemble =
            Ensemble::sample(&ellipse.with_phases(Phases::Random { seed: 3 }), 32).unwrap();
        let integral = LoopIntegral::of(&ensemble, &Rule::Pseudospectral).unwrap();
        for (found, area) in integral.contributions.iter().zip([1e3, 1.0, 0.0]) {
            assert!(
                (found - PI * area).abs() <= 1e-15 * area * PI * 4.0,
                "{found}"
            );
        }
    }

    #[test]
    fn a_radius_or_centre_that_means_nothing_is_refused() {
        assert!(Circle::new(vec![0.0], vec![0.0], -1.0).is_err());
        assert!(Circle::new(vec![0.0], vec![0.0, 1.0], 1.0).is_err());
        assert!(Circle::new(vec![f64::NAN], vec![0.0], 1.0).is_err());
        assert!(Circle::new(vec![0.0], vec![0.0], f64::NAN).is_err());
        assert!(Circle::with_radii(vec![0.0], vec![0.0], vec![1.0], vec![-1.0]).is_err());
        assert!(Circle::with_radii(vec![0.0], vec![0.0], vec![1.0, 1.0], vec![1.0]).is_err());
        let circle = Circle::new(vec![0.0], vec![0.0], 1.0).unwrap();
        assert_eq!(
            circle.on(&[1]).unwrap_err(),
            Error::NoSuchDof { dof: 1, count: 1 }
        );
    }
}
