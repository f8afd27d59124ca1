//! The push of Boris with leapfrog fields, part by part.

use super::Substep;
use super::coupling::{Coupling, Place};
use super::orbit::along;
use crate::gempic::electromagnetic::{Gempic, difference};
use crate::gempic::physical::PhysicalState;

/// What Boris codes differ in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Boris1d2v {
    /// Whether velocities are half a step behind positions, as codes store them.
    pub is_staggered: bool,
    /// Whether E1 and B are averaged to the nodes and weighted by the shape of the charge ("momentum-conserving"), and
    /// not by the shape one degree lower that belongs to their places on the grid ("energy-conserving", Galerkin).
    pub gathers_at_nodes: bool,
    /// Whether the current along x is q v1 times the shape in the middle of the way, and not what the law of charge
    /// conservation says: T. Z. Esirkepov, Comput. Phys. Commun. 135 (2001) 144; on a line and for linear shapes that is the
    /// current along x of the zigzag scheme of T. Umeda et al., Comput. Phys. Commun. 156 (2003) 73. The law says nothing of
    /// the current across, which is q v2 times the shape in the middle of the way in either case; Esirkepov takes the mean of
    /// both ends, Umeda the middles of the segments between nodes.
    pub deposits_directly: bool,
}

/// The parts of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// Half of Boris' rotation of a step.
    HalfRotation,
    /// All of it.
    Rotation,
    /// v += (h/2) (q/m) E.
    Kick,
    /// a −= (h/2) e.
    Faraday,
    /// Both. Fields gathered by the shapes of the grid change m v and −q A by the same: canonical momenta stay, and this is
    /// H_E. Neither of the two alone is symplectic.
    KickAndFaraday,
    /// Positions by velocities, and the current meanwhile.
    Drift,
    /// M0 e2 += h Cᵀ M1 b.
    Ampere,
}

/// One part of a step.
pub(super) struct BorisPart<const N: usize> {
    gempic: Gempic,
    coupling: Coupling<N>,
    scheme: Boris1d2v,
    part: Part,
}

impl<const N: usize> BorisPart<N> {
    pub(super) fn new(gempic: &Gempic, scheme: Boris1d2v, part: Part) -> Self {
        BorisPart {
            coupling: Coupling::new(gempic.grid),
            gempic: gempic.clone(),
            scheme,
            part,
        }
    }

    fn rotate(&self, h: f64, state: &mut PhysicalState) {
        let half_charge = self.half_charge(h);
        let mut b = state.a2.clone();
        difference(&mut b);
        self.to_where_it_is_gathered(&mut b);
        for a in 0..state.x.len() {
            let t = half_charge * self.of_edges(&self.coupling.at(state.x[a]), &b);
            let mut v = half_rotation([state.v1[a], state.v2[a]], t);
            if self.part == Part::Rotation {
                v = half_rotation(v, t);
            }
            [state.v1[a], state.v2[a]] = v;
        }
    }

    fn kick(&self, h: f64, state: &mut PhysicalState) {
        let half_charge = self.half_charge(h);
        let mut e1 = state.e1.clone();
        self.to_where_it_is_gathered(&mut e1);
        for a in 0..state.x.len() {
            let place = self.coupling.at(state.x[a]);
            state.v1[a] += half_charge * self.of_edges(&place, &e1);
            state.v2[a] += half_charge * place.zero().sum(&state.e2);
        }
    }

    fn faraday(h: f64, state: &mut PhysicalState) {
        for j in 0..state.e1.len() {
            state.a1[j] -= 0.5 * h * state.e1[j];
            state.a2[j] -= 0.5 * h * state.e2[j];
        }
    }

    /// h q/2m.
    fn half_charge(&self, h: f64) -> f64 {
        0.5 * h * self.gempic.charge / self.gempic.mass
    }

    /// E1 or B from integrals over edges to what is weighted to particles.
    fn to_where_it_is_gathered(&self, edges: &mut [f64]) {
        if self.scheme.gathers_at_nodes {
            to_nodes(edges, self.coupling.per_length());
        }
    }

    /// E1 or B at a particle.
    fn of_edges(&self, place: &Place<'_, N>, values: &[f64]) -> f64 {
        match self.scheme.gathers_at_nodes {
            true => place.zero().sum(values),
            false => place.one().sum(values),
        }
    }

    fn drift(&self, h: f64, state: &mut PhysicalState) -> Result<(), String> {
        let (cells, coupling) = (self.coupling.cells(), &self.coupling);
        let (mut along_x, mut across) = (vec![0.0; cells], vec![0.0; cells]);
        for a in 0..state.x.len() {
            let charge = self.gempic.charge * self.gempic.weights[a];
            let (x, v1, v2) = (state.x[a], state.v1[a], state.v2[a]);
            let way = h * v1;
            let passable = coupling.check_way(x, way);
            passable.map_err(|failure| format!("particle {a} {failure}"))?;
            along(
                coupling,
                !self.scheme.deposits_directly,
                x,
                way,
                |x, weight| {
                    coupling
                        .at(x)
                        .one()
                        .deposit(charge * way * weight, &mut along_x);
                },
            );
            let middle = coupling.at(x + 0.5 * way);
            middle.zero().deposit(charge * h * v2, &mut across);
            state.x[a] += way;
            state.y[a] += h * v2;
        }
        self.gempic.masses.solve(&mut along_x, &mut across);
        for j in 0..cells {
            state.e1[j] -= along_x[j];
            state.e2[j] -= across[j];
        }
        Ok(())
    }

    fn ampere(&self, h: f64, state: &mut PhysicalState) {
        let mut potential = state.a2.clone();
        let mut curl = vec![0.0; potential.len()];
        self.gempic.curl_of_field(&mut potential, &mut curl);
        // Ampère's law across does not involve the other field.
        potential.fill(0.0);
        self.gempic.masses.solve(&mut potential, &mut curl);
        for (e2, curl) in state.e2.iter_mut().zip(curl) {
            *e2 += h * curl;
        }
    }
}

impl<const N: usize> Substep for BorisPart<N> {
    fn advance(&self, h: f64, state: &mut PhysicalState) -> Result<(), String> {
        match self.part {
            Part::HalfRotation | Part::Rotation => self.rotate(h, state),
            Part::Kick => self.kick(h, state),
            Part::Faraday => Self::faraday(h, state),
            Part::KickAndFaraday => {
                self.kick(h, state);
                Self::faraday(h, state);
            }
            Part::Drift => return self.drift(h, state),
            Part::Ampere => self.ampere(h, state),
        }
        Ok(())
    }
}

/// Half of Boris' rotation by the angle 2 atan t.
fn half_rotation([v1, v2]: [f64; 2], t: f64) -> [f64; 2] {
    let cosine = 1.0 / (1.0 + t * t).sqrt();
    [cosine * (v1 + t * v2), cosine * (v2 - t * v1)]
}

/// From integrals over edges to values at nodes, node j between edges j and j + 1.
fn to_nodes(edges: &mut [f64], per_length: f64) {
    let first = edges[0];
    let last = edges.len() - 1;
    for j in 0..last {
        edges[j] = 0.5 * per_length * (edges[j] + edges[j + 1]);
    }
    edges[last] = 0.5 * per_length * (edges[last] + first);
}
