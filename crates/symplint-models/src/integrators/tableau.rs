//! Butcher tableaus, alone and in pairs, and the conditions under which they are symplectic.

use crate::error::ModelError;

/// A Runge–Kutta method: k_i = f(y + h Σ_j a_ij k_j), y_1 = y + h Σ_i b_i k_i.
///
/// Stages are counted from 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Tableau {
    name: String,
    order: u32,
    a: Vec<Vec<f64>>,
    b: Vec<f64>,
    reference: String,
}

/// How far a condition on a pair of stages is from being met, where it is met worst.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Left side minus right side of the condition.
    pub value: f64,
    /// The first stage, counted from 0.
    pub i: usize,
    /// The second stage.
    pub j: usize,
}

impl Residual {
    /// Rounding errors of coefficients of order 1.
    const ROUNDOFF: f64 = 1e-14;

    /// Whether the condition is met up to rounding errors.
    pub fn vanishes(&self) -> bool {
        self.value.abs() <= Self::ROUNDOFF
    }

    /// The largest residual over all pairs of stages; the first one where several are equal.
    fn worst(stages: usize, residual: impl Fn(usize, usize) -> f64) -> Self {
        let pairs = (0..stages).flat_map(|i| (0..stages).map(move |j| (i, j)));
        let start = Residual {
            value: 0.0,
            i: 0,
            j: 0,
        };
        pairs.fold(start, |worst, (i, j)| {
            let value = residual(i, j);
            if value.abs() > worst.value.abs() {
                Residual { value, i, j }
            } else {
                worst
            }
        })
    }
}

impl Tableau {
    /// A tableau with the rows `a` and the weights `b`.
    ///
    /// The order is taken on trust; the reference says where the method is from.
    ///
    /// # Errors
    /// If `a` is not a square matrix of the length of `b`, the number of stages is 0, or an entry is not
    /// finite.
    pub fn new(
        name: impl Into<String>,
        order: u32,
        a: &[&[f64]],
        b: &[f64],
        reference: impl Into<String>,
    ) -> Result<Self, ModelError> {
        let (name, stages) = (name.into(), b.len());
        if stages == 0 {
            return Err(ModelError::Empty {
                system: "a tableau",
                parts: "stages",
            });
        }
        let shape = |what, got| {
            if got == stages {
                return Ok(());
            }
            Err(ModelError::TableauShape {
                tableau: name.clone(),
                what,
                stages,
                got,
            })
        };
        shape("the column of rows", a.len())?;
        for row in a {
            shape("a row", row.len())?;
        }
        for &entry in a.iter().copied().flatten().chain(b) {
            ModelError::check_finite("an entry of a tableau", entry)?;
        }
        Ok(Tableau {
            name,
            order,
            a: a.iter().map(|row| row.to_vec()).collect(),
            b: b.to_vec(),
            reference: reference.into(),
        })
    }

    /// Name of the method.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Order of accuracy.
    pub fn order(&self) -> u32 {
        self.order
    }

    /// Number of stages s.
    pub fn stages(&self) -> usize {
        self.b.len()
    }

    /// Coefficient a_ij.
    ///
    /// # Panics
    /// If the method has fewer stages.
    pub fn a(&self, i: usize, j: usize) -> f64 {
        self.a[i][j]
    }

    /// Weights b, one for each stage.
    pub fn b(&self) -> &[f64] {
        &self.b
    }

    /// Node c_i = Σ_j a_ij, the time of stage i in units of h.
    ///
    /// # Panics
    /// If the method has fewer stages.
    pub fn c(&self, i: usize) -> f64 {
        self.a[i].iter().sum()
    }

    /// The source of the method.
    pub fn reference(&self) -> &str {
        &self.reference
    }

    /// The worst residual of b_i a_ij + b_j a_ji = b_i b_j, the condition for the method to be
    /// symplectic (HLW, section VI.4, theorem 4.3). No explicit method meets it.
    pub fn symplecticity_residual(&self) -> Residual {
        coupled_residual(self, self)
    }

    /// Whether the method meets the condition for being symplectic, up to rounding errors.
    ///
    /// The condition is necessary, too, if no two stages coincide for every problem.
    pub fn is_symplectic(&self) -> bool {
        self.symplecticity_residual().vanishes()
    }

    /// The adjoint method, (Φ_{−h})^{-1}: a*_ij = b_{s+1−j} − a_{s+1−i,s+1−j} and
    /// b*_j = b_{s+1−j}, stages counted from 1 (HLW, section V.2, theorem 2.3).
    ///
    /// The adjoint of an explicit method is implicit.
    pub fn adjoint(&self) -> Tableau {
        let last = self.stages() - 1;
        let b = |j: usize| self.b[last - j];
        Tableau {
            name: format!("adjoint of {}", self.name),
            order: self.order,
            a: (0..=last)
                .map(|i| {
                    (0..=last)
                        .map(|j| b(j) - self.a[last - i][last - j])
                        .collect()
                })
                .collect(),
            b: (0..=last).map(b).collect(),
            reference: self.reference.clone(),
        }
    }
}

/// A partitioned Runge–Kutta method: one tableau (a, b) for positions and one (â, b̂) for momenta.
///
/// With velocities k and forces ℓ, stage i takes its positions from q + h Σ_j a_ij k_j and its
/// momenta from p + h Σ_j â_ij ℓ_j (Barham & Burby, appendix D; HLW, section II.2.1).
#[derive(Clone, Debug, PartialEq)]
pub struct TableauPair {
    name: String,
    position: Tableau,
    momentum: Tableau,
}

impl TableauPair {
    /// The method with the tableau `position` for q and `momentum` for p.
    ///
    /// # Errors
    /// If the tableaus have different numbers of stages.
    pub fn new(
        name: impl Into<String>,
        position: Tableau,
        momentum: Tableau,
    ) -> Result<Self, ModelError> {
        let name = name.into();
        if position.stages() != momentum.stages() {
            return Err(ModelError::PairStages {
                pair: name,
                position: position.stages(),
                momentum: momentum.stages(),
            });
        }
        Ok(TableauPair {
            name,
            position,
            momentum,
        })
    }

    /// Name of the method.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Number of stages s.
    pub fn stages(&self) -> usize {
        self.position.stages()
    }

    /// The tableau (a, b) for positions.
    pub fn position(&self) -> &Tableau {
        &self.position
    }

    /// The tableau (â, b̂) for momenta.
    pub fn momentum(&self) -> &Tableau {
        &self.momentum
    }

    /// The worst residual of b_i â_ij + b̂_j a_ji = b_i b̂_j (Barham & Burby, appendix D; HLW,
    /// section VI.4, theorem 4.6).
    pub fn symplecticity_residual(&self) -> Residual {
        coupled_residual(&self.position, &self.momentum)
    }

    /// The worst residual of b_i = b̂_i, also needed unless the Hamiltonian is separable; i = j.
    pub fn weights_residual(&self) -> Residual {
        Residual::worst(self.stages(), |i, j| {
            if i == j {
                self.position.b[i] - self.momentum.b[i]
            } else {
                0.0
            }
        })
    }

    /// Whether the method meets the condition for being symplectic on separable Hamiltonians
    /// T(p) + V(q), up to rounding errors.
    ///
    /// The condition is necessary, too, if no two stages coincide for every problem.
    pub fn is_symplectic_if_separable(&self) -> bool {
        self.symplecticity_residual().vanishes()
    }

    /// Whether the method meets both conditions for being symplectic on all Hamiltonians.
    pub fn is_symplectic(&self) -> bool {
        self.is_symplectic_if_separable() && self.weights_residual().vanishes()
    }

    /// The adjoint method: the pair of the adjoint tableaus.
    pub fn adjoint(&self) -> TableauPair {
        TableauPair {
            name: format!("adjoint of {}", self.name),
            position: self.position.adjoint(),
            momentum: self.momentum.adjoint(),
        }
    }
}

/// An ordinary Runge–Kutta method treats positions and momenta alike.
impl From<Tableau> for TableauPair {
    fn from(tableau: Tableau) -> Self {
        TableauPair {
            name: tableau.name.clone(),
            position: tableau.clone(),
            momentum: tableau,
        }
    }
}

/// The worst residual of b_i â_ij + b̂_j a_ji − b_i b̂_j.
fn coupled_residual(position: &Tableau, momentum: &Tableau) -> Residual {
    let (b, b_hat) = (&position.b, &momentum.b);
    Residual::worst(b.len(), |i, j| {
        b[i] * momentum.a[i][j] + b_hat[j] * position.a[j][i] - b[i] * b_hat[j]
    })
}

#[cfg(test)]
mod tests {
    use super::super::tableaus;
    use super::*;

    impl Tableau {
        /// The largest coefficient, at least 1: rounding errors are relative to it.
        pub(in super::super) fn largest(&self) -> f64 {
            let sizes = self.a.iter().flatten().map(|a| a.abs());
            sizes.fold(1.0, f64::max)
        }
    }

    #[test]
    fn gauss_methods_are_symplectic_and_others_are_not() {
        assert!(tableaus::implicit_midpoint().is_symplectic());
        assert!(tableaus::gauss4().is_symplectic());
        assert!(tableaus::gauss6().is_symplectic());
        for other in [
            tableaus::trapezoidal(),
            tableaus::averaged_vector_field(),
            tableaus::rk45(),
            tableaus::dop853(),
            tableaus::euler(),
            tableaus::midpoint(),
            tableaus::heun(),
            tableaus::rk4(),
        ] {
            assert!(!other.is_symplectic(), "{}", other.name());
        }
    }

    #[test]
    fn the_residual_says_where_and_how_much() {
        // Heun: b = (1/2, 1/2), a_21 = 1. Diagonal: −1/4; off it: 1/2 − 1/4.
        let residual = tableaus::heun().symplecticity_residual();
        assert_eq!(
            residual,
            Residual {
                value: -0.25,
                i: 0,
                j: 0
            }
        );
        // Midpoint: only b_2 = 1 counts, b_2 b_2 is missing.
        let residual = tableaus::midpoint().symplecticity_residual();
        assert_eq!(
            residual,
            Residual {
                value: -1.0,
                i: 1,
                j: 1
            }
        );
    }

    #[test]
    fn strang_pairs_are_symplectic_on_separable_hamiltonians_only() {
        for pair in [
            tableaus::strang_position_first(),
            tableaus::strang_momentum_first(),
        ] {
            assert!(pair.is_symplectic_if_separable(), "{}", pair.name());
            assert!(!pair.is_symplectic());
            assert_eq!(pair.weights_residual().value.abs(), 0.5);
        }
        let lobatto = tableaus::lobatto3a_3b();
        assert!(lobatto.is_symplectic());
        assert!(TableauPair::from(tableaus::gauss4()).is_symplectic());
        assert!(!TableauPair::from(tableaus::rk4()).is_symplectic_if_separable());
    }

    #[test]
    fn the_printed_position_first_weights_miss_the_condition() {
        let pair = tableaus::strang_position_first();
        let printed = Tableau::new("", 2, &[&[0.0, 0.0], &[1.0, 0.0]], &[0.0, 1.0], "").unwrap();
        let printed = TableauPair::new("", pair.position().clone(), printed).unwrap();
        assert_eq!(
            printed.symplecticity_residual(),
            Residual {
                value: 0.5,
                i: 1,
                j: 0
            }
        );
    }

    #[test]
    fn the_adjoint_of_explicit_euler_is_implicit_euler() {
        let adjoint = tableaus::euler().adjoint();
        assert_eq!((adjoint.a(0, 0), adjoint.b()), (1.0, &[1.0][..]));
    }

    #[test]
    fn taking_the_adjoint_twice_gives_the_method_back() {
        for tableau in tableaus::all() {
            let twice = tableau.adjoint().adjoint();
            let rounding = 1e-15 * tableau.largest();
            for i in 0..tableau.stages() {
                assert!((twice.b()[i] - tableau.b()[i]).abs() < 1e-16);
                for j in 0..tableau.stages() {
                    assert!(
                        (twice.a(i, j) - tableau.a(i, j)).abs() < rounding,
                        "{}",
                        tableau.name()
                    );
                }
            }
        }
    }

    #[test]
    fn gauss_methods_are_symmetric() {
        for tableau in [
            tableaus::implicit_midpoint(),
            tableaus::gauss4(),
            tableaus::gauss6(),
        ] {
            let adjoint = tableau.adjoint();
            for i in 0..tableau.stages() {
                for j in 0..tableau.stages() {
                    assert!((adjoint.a(i, j) - tableau.a(i, j)).abs() < 1e-15);
                }
            }
        }
    }

    #[test]
    fn misshapen_tableaus_are_refused() {
        let error = Tableau::new("lopsided", 1, &[&[0.0, 1.0]], &[1.0], "").unwrap_err();
        assert_eq!(
            error.to_string(),
            "a row of tableau \"lopsided\" has 2 entries for 1 stages; give one for each"
        );
        assert!(Tableau::new("", 1, &[&[0.0], &[0.0]], &[1.0], "").is_err());
        assert!(Tableau::new("", 1, &[], &[], "").is_err());
        assert!(Tableau::new("", 1, &[&[f64::NAN]], &[1.0], "").is_err());
        assert!(TableauPair::new("", tableaus::euler(), tableaus::heun()).is_err());
    }
}
