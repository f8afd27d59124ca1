//! In which order the stages of an explicit Runge–Kutta method are evaluated.

use super::tableau::{Tableau, TableauPair};
use crate::error::ModelError;

/// The variables that the derivatives of a Hamiltonian depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dependence {
    /// Velocities on momenta only and forces on positions only.
    Separable,
    /// Both on both.
    General,
}

/// The functions that are evaluated at a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slope {
    /// ∂H/∂p, from which positions are made.
    Velocity,
    /// −∂H/∂q, from which momenta are made.
    Force,
}

/// A coefficient, and which earlier evaluation it multiplies.
pub(super) type Term = (f64, usize);

/// One evaluation at one stage.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Evaluation {
    pub slope: Slope,
    pub stage: usize,
    /// The stage's positions, as increments over those at the start; nothing where not read.
    pub q_terms: Option<Vec<Term>>,
    /// The stage's momenta, in the same form.
    pub p_terms: Option<Vec<Term>>,
}

/// The evaluations of one step, each after those it needs, and what is made of them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StagePlan {
    pub evaluations: Vec<Evaluation>,
    pub q_update: Vec<Term>,
    pub p_update: Vec<Term>,
}

/// One slope at one stage, before its place in the order is known.
type Node = (Slope, usize);

impl StagePlan {
    /// Orders the stages of `method` that have an influence on its result.
    ///
    /// # Errors
    /// If stages depend on each other in a circle: the method is implicit.
    pub(super) fn new(method: &TableauPair, dependence: Dependence) -> Result<Self, ModelError> {
        let graph = Graph { method, dependence };
        let order = graph.ordered(&graph.needed())?;
        let terms = |slope: Slope, coefficients: &[f64]| -> Vec<Term> {
            let nonzero = nonzero(coefficients);
            nonzero
                .map(|j| {
                    let place = order.iter().position(|&node| node == (slope, j));
                    (coefficients[j], place.expect("what is needed is ordered"))
                })
                .collect()
        };
        let row = |tableau: &Tableau, i: usize| -> Vec<f64> {
            (0..tableau.stages()).map(|j| tableau.a(i, j)).collect()
        };
        let evaluations = order
            .iter()
            .map(|&(slope, stage)| Evaluation {
                slope,
                stage,
                q_terms: graph
                    .reads_positions(slope)
                    .then(|| terms(Slope::Velocity, &row(method.position(), stage))),
                p_terms: graph
                    .reads_momenta(slope)
                    .then(|| terms(Slope::Force, &row(method.momentum(), stage))),
            })
            .collect();
        Ok(StagePlan {
            evaluations,
            q_update: terms(Slope::Velocity, method.position().b()),
            p_update: terms(Slope::Force, method.momentum().b()),
        })
    }
}

/// Which slope at which stage depends on which.
struct Graph<'a> {
    method: &'a TableauPair,
    dependence: Dependence,
}

impl Graph<'_> {
    fn reads_positions(&self, slope: Slope) -> bool {
        self.dependence == Dependence::General || slope == Slope::Force
    }

    fn reads_momenta(&self, slope: Slope) -> bool {
        self.dependence == Dependence::General || slope == Slope::Velocity
    }

    fn dependencies(&self, (slope, i): Node) -> Vec<Node> {
        let mut dependencies = Vec::new();
        let stages = 0..self.method.stages();
        if self.reads_positions(slope) {
            let used = stages
                .clone()
                .filter(|&j| self.method.position().a(i, j) != 0.0);
            dependencies.extend(used.map(|j| (Slope::Velocity, j)));
        }
        if self.reads_momenta(slope) {
            let used = stages.filter(|&j| self.method.momentum().a(i, j) != 0.0);
            dependencies.extend(used.map(|j| (Slope::Force, j)));
        }
        dependencies
    }

    /// Everything the result depends on, in order of stages, velocities before forces.
    fn needed(&self) -> Vec<Node> {
        let velocities = nonzero(self.method.position().b()).map(|i| (Slope::Velocity, i));
        let forces = nonzero(self.method.momentum().b()).map(|i| (Slope::Force, i));
        let mut open: Vec<Node> = velocities.chain(forces).collect();
        let mut needed: Vec<Node> = Vec::new();
        while let Some(node) = open.pop() {
            if !needed.contains(&node) {
                needed.push(node);
                open.extend(self.dependencies(node));
            }
        }
        needed.sort_by_key(|&(slope, stage)| (stage, slope == Slope::Force));
        needed
    }

    /// `needed` in an order in which each comes after its dependencies, as little changed as
    /// can be.
    fn ordered(&self, needed: &[Node]) -> Result<Vec<Node>, ModelError> {
        let mut order: Vec<Node> = Vec::with_capacity(needed.len());
        while let Some(&blocked) = needed.iter().find(|node| !order.contains(node)) {
            let ready = needed.iter().find(|&&node| {
                !order.contains(&node)
                    && self
                        .dependencies(node)
                        .iter()
                        .all(|other| order.contains(other))
            });
            order.push(*ready.ok_or_else(|| ModelError::Implicit {
                method: self.method.name().to_owned(),
                stage: blocked.1,
            })?);
        }
        Ok(order)
    }
}

fn nonzero(coefficients: &[f64]) -> impl Iterator<Item = usize> {
    (0..coefficients.len()).filter(|&i| coefficients[i] != 0.0)
}

#[cfg(test)]
mod tests {
    use super::super::tableaus;
    use super::*;

    fn order(method: impl Into<TableauPair>, dependence: Dependence) -> Vec<Node> {
        let plan = StagePlan::new(&method.into(), dependence).unwrap();
        plan.evaluations
            .iter()
            .map(|e| (e.slope, e.stage))
            .collect()
    }

    #[test]
    fn strang_pairs_cost_one_force_or_two() {
        use Slope::{Force, Velocity};
        assert_eq!(
            order(tableaus::strang_position_first(), Dependence::Separable),
            [(Velocity, 0), (Force, 0), (Velocity, 1)]
        );
        assert_eq!(
            order(tableaus::strang_momentum_first(), Dependence::Separable),
            [(Force, 0), (Velocity, 0), (Force, 1)]
        );
    }

    #[test]
    fn stages_that_nothing_needs_are_left_out() {
        let none: &[f64] = &[0.0, 0.0];
        for (needed, weights) in [[1.0, 0.0], [0.0, 1.0]].iter().enumerate() {
            let padded = Tableau::new("", 1, &[none, none], weights, "").unwrap();
            assert_eq!(
                order(padded, Dependence::General),
                [(Slope::Velocity, needed), (Slope::Force, needed)]
            );
        }
        // The midpoint rule on a separable system needs all of its first stage still.
        assert_eq!(order(tableaus::midpoint(), Dependence::Separable).len(), 4);
    }

    #[test]
    fn implicit_methods_are_refused() {
        let attempt = |pair: TableauPair, dependence| StagePlan::new(&pair, dependence).map(|_| ());
        let implicit = |stage| -> Result<(), &str> { Err(["first", "second"][stage]) };
        let outcome = |result: Result<(), ModelError>| match result {
            Ok(()) => Ok(()),
            Err(ModelError::Implicit { stage, .. }) => implicit(stage),
            Err(other) => panic!("{other}"),
        };
        use Dependence::{General, Separable};
        assert_eq!(
            outcome(attempt(tableaus::gauss4().into(), Separable)),
            implicit(0)
        );
        assert_eq!(
            outcome(attempt(tableaus::euler().adjoint().into(), General)),
            implicit(0)
        );
        assert_eq!(
            outcome(attempt(tableaus::strang_position_first(), General)),
            implicit(0)
        );
        assert_eq!(
            outcome(attempt(tableaus::lobatto3a_3b(), General)),
            implicit(0)
        );
        assert_eq!(
            outcome(attempt(tableaus::lobatto3a_3b(), Separable)),
            Ok(())
        );
    }
}
