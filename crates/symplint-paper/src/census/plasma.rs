//! The plasmas of the census and their invariants.

use std::sync::Arc;

use symplint::state::Rows;
use symplint_models::Hamiltonian;
use symplint_plasma::gempic::Gempic;
use symplint_plasma::pic::{MomentumConservingPic, Pic1d};

/// A discretised plasma.
pub enum Plasma {
    /// The textbook's, with a force that conserves the momentum.
    MomentumConserving(MomentumConservingPic),
    /// Electrostatic and variational.
    Variational(Arc<Pic1d>),
    /// Electromagnetic.
    Electromagnetic(Box<Gempic>),
}

/// The invariants of a state.
#[derive(Clone, Copy, Debug)]
pub struct Invariants {
    /// The energy.
    pub energy: f64,
    /// How far Gauss' law is from being satisfied, if the field is not computed from it in every step.
    pub gauss: Option<f64>,
    /// The momentum along x.
    pub momentum: f64,
}

impl Plasma {
    /// The invariants of one state.
    pub fn invariants(&self, q: &[f64], p: &[f64]) -> Invariants {
        let energy_of = |system: &dyn Hamiltonian| {
            let mut energy = [0.0];
            let rows = |values| Rows::new(values, q.len(), 1, 1);
            system.energy(rows(q), rows(p), &mut energy);
            energy[0]
        };
        match self {
            Plasma::MomentumConserving(pic) => Invariants {
                energy: pic.energy(q, p),
                gauss: None,
                momentum: pic.momentum(p),
            },
            Plasma::Variational(pic) => Invariants {
                energy: energy_of(&**pic),
                gauss: None,
                momentum: pic.momentum(p)[0],
            },
            Plasma::Electromagnetic(gempic) => Invariants {
                energy: energy_of(&**gempic),
                gauss: Some(gempic.gauss_residual(q, p)),
                momentum: gempic.momentum(q, p)[0],
            },
        }
    }
}
