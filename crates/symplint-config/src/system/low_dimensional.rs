//! Systems of a few degrees of freedom.

use std::sync::Arc;

use symplint_models::systems::{
    AbsoluteValue, HarmonicOscillator, HenonHeiles, InterpolatedPendulum, Pendulum,
    PendulumPotential, TwoCell,
};
use symplint_models::{Model, ModelError, Separable};

use super::{MAX_DOF, STRANG, System, SystemInfo};
use crate::ConfigError;
use crate::section::{Key, NumberRange, Section};

const Q0: Key = Key::new("q0", "0.0", "centre of the loop, position").numbers();
const P0: Key = Key::new("p0", "0.0", "centre of the loop, momentum").numbers();
const Q0_AT_PI: Key = Key::new("q0", "\"pi\"", "centre of the loop, position").numbers();

pub const PENDULUM: SystemInfo = SystemInfo {
    name: "pendulum",
    summary: "nonlinear pendulum, H = p²/2 + cos q (paper, section 3.2)",
    keys: &[
        Key::new(
            "potential",
            "\"cos\"",
            "\"cos\" as in the paper's figures, \"sin\" as in its text",
        )
        .choice(&["cos", "sin"]),
        Q0_AT_PI,
        Key::new("p0", "0.5", "centre of the loop, momentum").numbers(),
    ],
    integrator: STRANG,
    budget: None,
    build: |section, _| {
        let potential = match section.choice("potential", &["cos", "sin"])? {
            "cos" => PendulumPotential::Cos,
            _ => PendulumPotential::Sin,
        };
        plane(section, "pendulum", Pendulum::new(potential))
    },
};

pub const ABSOLUTE_VALUE: SystemInfo = SystemInfo {
    name: "absolute-value",
    summary: "H = p²/2 + |q|, or √(q² + ε²) instead of |q| (section 4.2)",
    keys: &[
        Key::new("epsilon", "0.0", "0 for abs(q), above 0 for √(q² + ε²)"),
        Q0,
        P0,
    ],
    integrator: STRANG,
    budget: None,
    build: |section, _| {
        let epsilon = section.number("epsilon", NumberRange::NotNegative)?;
        let system = AbsoluteValue::new(epsilon).map_err(|e| section.refused_by("epsilon", &e))?;
        plane(section, "absolute-value", system)
    },
};

pub const INTERPOLATED_PENDULUM: SystemInfo = SystemInfo {
    name: "interpolated-pendulum",
    summary: "V = sin q + cos²(2q + 1) interpolated by periodic B-splines (section 4.3)",
    keys: &[
        Key::new("degree", "3", "B-spline degree 1 to 5; 0 for V itself"),
        Key::new(
            "cells",
            "25",
            "cells in a period of 2π; odd for degrees 2 and 4",
        ),
        Q0_AT_PI,
        P0,
    ],
    integrator: STRANG,
    budget: None,
    build: |section, _| {
        let degree = section.whole("degree", 0)? as usize;
        let cells = section.whole("cells", 1)? as usize;
        let system = InterpolatedPendulum::new(degree, cells).map_err(|error| {
            let key = if matches!(error, ModelError::Degree { .. }) {
                "degree"
            } else {
                "cells"
            };
            section.refused_by(key, &error)
        })?;
        plane(section, "interpolated-pendulum", system)
    },
};

pub const HARMONIC_OSCILLATOR: SystemInfo = SystemInfo {
    name: "harmonic-oscillator",
    summary: "independent oscillators, H = Σ (p² + ω² q²)/2",
    keys: &[
        Key::new("dof", "1", "number of oscillators"),
        Key::new(
            "omega",
            "1.0",
            "angular frequencies: one number for all, or a list",
        )
        .numbers(),
        Q0,
        P0,
    ],
    integrator: STRANG,
    budget: None,
    build: |section, _| {
        let dof = section.whole_between("dof", 1, MAX_DOF)? as usize;
        let omega = section.numbers("omega", dof)?;
        let system = HarmonicOscillator::new(omega).map_err(|e| section.refused_by("omega", &e))?;
        space(section, "harmonic-oscillator", system)
    },
};

pub const HENON_HEILES: SystemInfo = SystemInfo {
    name: "henon-heiles",
    summary: "H = |p|²/2 + |q|²/2 + q₁² q₂ − q₂³/3, two degrees of freedom",
    keys: &[
        Key::new("q0", "[0.0, 0.1]", "centre of the loop, positions").numbers(),
        Key::new("p0", "[0.3, 0.0]", "centre of the loop, momenta").numbers(),
    ],
    integrator: STRANG,
    budget: None,
    build: |section, _| space(section, "henon-heiles", HenonHeiles),
};

pub const TWO_CELL: SystemInfo = SystemInfo {
    name: "two-cell",
    summary: "one particle in its own field, on two cells with linear shapes (appendix F)",
    keys: &[
        Key::new(
            "length",
            "4.0",
            "L, the length of a cell; the box is [-L, L]",
        ),
        Q0,
        P0,
    ],
    integrator: STRANG,
    budget: None,
    build: |section, _| {
        let length = section.number("length", NumberRange::Positive)?;
        let system = TwoCell::new(length).map_err(|e| section.refused_by("length", &e))?;
        plane(section, "two-cell", system)
    },
};

/// A system of one degree of freedom.
fn plane(
    section: &Section,
    name: &'static str,
    hamiltonian: impl Separable + 'static,
) -> Result<System, ConfigError> {
    Ok(System {
        name,
        model: Model::Separable(Arc::new(hamiltonian)),
        q0: vec![section.number("q0", NumberRange::Finite)?],
        p0: vec![section.number("p0", NumberRange::Finite)?],
        command: None,
    })
}

/// A system of several degrees of freedom.
fn space(
    section: &Section,
    name: &'static str,
    hamiltonian: impl Separable + 'static,
) -> Result<System, ConfigError> {
    let dof = hamiltonian.dof();
    Ok(System {
        name,
        model: Model::Separable(Arc::new(hamiltonian)),
        q0: section.numbers("q0", dof)?,
        p0: section.numbers("p0", dof)?,
        command: None,
    })
}
