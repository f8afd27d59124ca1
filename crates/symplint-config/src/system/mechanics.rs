//! Classical mechanics: planets, pendula, charges, and a force without a potential.

use std::sync::Arc;

use symplint_models::Model;
use symplint_models::systems::{ChargedParticle, DoublePendulum, Kepler, RotationalForce};

use super::{STRANG, System, SystemInfo};
use crate::ConfigError;
use crate::section::{Key, NumberRange, Section};

const fn q0(default: &'static str) -> Key {
    Key::new("q0", default, "centre of the loop, positions").numbers()
}

const fn p0(default: &'static str) -> Key {
    Key::new("p0", default, "centre of the loop, momenta").numbers()
}

pub const KEPLER: SystemInfo = SystemInfo {
    name: "kepler",
    summary: "the Kepler problem in the plane, H = |p|²/2 − μ/√(|q|² + ε²)",
    keys: &[
        Key::new("mu", "1.0", "μ, strength of the attraction"),
        Key::new(
            "softening",
            "0.0",
            "ε; if it is 0, loops must not pass through q = 0",
        ),
        q0("[3.0, 0.0]"),
        p0("[0.0, 0.6]"),
    ],
    integrator: STRANG,
    budget: None,
    build: |section, _| {
        let mu = section.number("mu", NumberRange::Finite)?;
        let softening = section.number("softening", NumberRange::NotNegative)?;
        let kepler = Kepler::new(mu, softening).map_err(|e| section.refused_by("mu", &e))?;
        space(section, "kepler", Model::Separable(Arc::new(kepler)))
    },
};

pub const DOUBLE_PENDULUM: SystemInfo = SystemInfo {
    name: "double-pendulum",
    summary: "the double pendulum in angles and canonical momenta, not separable",
    keys: &[
        Key::new(
            "masses",
            "1.0",
            "upper and lower mass: one number for both, or a list",
        )
        .numbers(),
        Key::new(
            "lengths",
            "1.0",
            "upper and lower length: one number for both, or a list",
        )
        .numbers(),
        Key::new("gravity", "1.0", "g"),
        q0("[1.0, -0.4]"),
        p0("[0.5, 0.2]"),
    ],
    integrator: MIDPOINT,
    budget: None,
    build: |section, _| {
        let masses = both(section, "masses")?;
        let lengths = both(section, "lengths")?;
        let gravity = section.number("gravity", NumberRange::Finite)?;
        let pendulum = DoublePendulum::new(masses, lengths, gravity).map_err(|error| {
            let key = if masses.iter().all(|&mass| mass > 0.0) {
                "lengths"
            } else {
                "masses"
            };
            section.refused_by(key, &error)
        })?;
        space(
            section,
            "double-pendulum",
            Model::General(Arc::new(pendulum)),
        )
    },
};

pub const CHARGED_PARTICLE: SystemInfo = SystemInfo {
    name: "charged-particle",
    summary: "a charge in the plane in a magnetic field B = b + g x, bound by ω² |q|²/2; momenta are \
              canonical, p = v + A(q)",
    keys: &[
        Key::new("field", "1.0", "b, the magnetic field at x = 0"),
        Key::new("gradient", "0.5", "g, its gradient along x"),
        Key::new(
            "omega",
            "0.0",
            "ω of the electric potential ω² |q|²/2; 0 for none",
        ),
        q0("[0.5, 0.0]"),
        p0("[0.3, 0.4]"),
    ],
    integrator: MIDPOINT,
    budget: None,
    build: |section, _| {
        let field = section.number("field", NumberRange::Finite)?;
        let gradient = section.number("gradient", NumberRange::Finite)?;
        let omega = section.number("omega", NumberRange::Finite)?;
        let particle = ChargedParticle::new(field, gradient, omega)
            .map_err(|e| section.refused_by("omega", &e))?;
        space(section, "charged-particle", Model::Charged(particle))
    },
};

pub const ROTATIONAL_FORCE: SystemInfo = SystemInfo {
    name: "rotational-force",
    summary: "Hénon–Heiles with an additional force without potential, κ (−q₂, q₁)",
    keys: &[
        Key::new(
            "strength",
            "0.1",
            "κ, half the curl of the force; 0 for Hénon–Heiles",
        ),
        q0("[0.0, 0.1]"),
        p0("[0.3, 0.0]"),
    ],
    integrator: STRANG,
    budget: None,
    build: |section, _| {
        let strength = section.number("strength", NumberRange::Finite)?;
        let force =
            RotationalForce::new(strength).map_err(|e| section.refused_by("strength", &e))?;
        space(section, "rotational-force", Model::Forced(Arc::new(force)))
    },
};

/// The default integrator of Hamiltonians that are not separable.
const MIDPOINT: &str = "\"implicit-midpoint\"";

/// One number for both pendula, or two.
fn both(section: &Section, key: &str) -> Result<[f64; 2], ConfigError> {
    let values = section.numbers(key, 2)?;
    Ok([values[0], values[1]])
}

fn space(section: &Section, name: &'static str, model: Model) -> Result<System, ConfigError> {
    let dof = model.dof();
    Ok(System {
        name,
        model,
        q0: section.numbers("q0", dof)?,
        p0: section.numbers("p0", dof)?,
        command: None,
    })
}
