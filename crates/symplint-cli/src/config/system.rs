//! `[system]`: the Hamiltonian and the state that loops go round.

use std::path::Path;
use std::sync::Arc;

use symplint_models::systems::{
    AbsoluteValue, HarmonicOscillator, HenonHeiles, InterpolatedPendulum, Pendulum, PendulumArray,
    PendulumPotential,
};
use symplint_models::{ModelError, Separable};

use super::document::{Node, Value};
use super::error::ConfigError;
use super::section::{Accept, Key, Section, suggestion};
use super::state_file::read_state;

/// A Hamiltonian with an initial state.
pub struct System {
    /// Its name in configurations.
    pub name: &'static str,
    /// H.
    pub hamiltonian: Arc<dyn Separable>,
    /// Initial positions: the centre of loops.
    pub q0: Vec<f64>,
    /// Initial momenta.
    pub p0: Vec<f64>,
}

/// A system that configurations may name.
pub struct SystemInfo {
    /// Name.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// Its keys besides `name`.
    pub keys: &'static [Key],
    build: fn(&Section, &Path) -> Result<System, ConfigError>,
}

const Q0: Key = Key::new("q0", "0.0", "centre of the loop, position");
const P0: Key = Key::new("p0", "0.0", "centre of the loop, momentum");
const Q0_AT_PI: Key = Key::new("q0", "\"pi\"", "centre of the loop, position");

/// Every system.
pub const SYSTEMS: &[SystemInfo] = &[
    SystemInfo {
        name: "pendulum",
        summary: "nonlinear pendulum, H = p²/2 + cos q (paper, section 3.2)",
        keys: &[
            Key::new(
                "potential",
                "\"cos\"",
                "\"cos\" as in the paper's figures, \"sin\" as in its text",
            ),
            Q0_AT_PI,
            Key::new("p0", "0.5", "centre of the loop, momentum"),
        ],
        build: |section, _| {
            let potential = match section.choice("potential", &["cos", "sin"])? {
                "cos" => PendulumPotential::Cos,
                _ => PendulumPotential::Sin,
            };
            plane(section, "pendulum", Pendulum::new(potential))
        },
    },
    SystemInfo {
        name: "absolute-value",
        summary: "H = p²/2 + |q|, or √(q² + ε²) in place of |q| (section 4.2)",
        keys: &[
            Key::new("epsilon", "0.0", "0 for abs(q), above 0 for √(q² + ε²)"),
            Q0,
            P0,
        ],
        build: |section, _| {
            let epsilon = section.number("epsilon", Accept::NotNegative)?;
            let system = AbsoluteValue::new(epsilon).map_err(|e| refused(section, "epsilon", e))?;
            plane(section, "absolute-value", system)
        },
    },
    SystemInfo {
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
        build: |section, _| {
            let degree = section.whole("degree", 0)? as usize;
            let cells = section.whole("cells", 1)? as usize;
            let system = InterpolatedPendulum::new(degree, cells).map_err(|error| {
                let key = if matches!(error, ModelError::Degree { .. }) {
                    "degree"
                } else {
                    "cells"
                };
                refused(section, key, error)
            })?;
            plane(section, "interpolated-pendulum", system)
        },
    },
    SystemInfo {
        name: "pendulum-array",
        summary: "a ring of pendula coupled by springs (section 4.4)",
        keys: &[
            Key::new(
                "pendula",
                "1024",
                "number of pendula, the degrees of freedom",
            ),
            Key::new("alpha", "1.0", "strength of the pendula"),
            Key::new("k", "1.0", "strength of the springs"),
            Key::new(
                "initial",
                "\"uniform\"",
                "random in [0, 1), or { file = \"state.npy\" } with rows q, p (.csv: columns)",
            ),
            Key::new("seed", "1", "of the random initial state"),
        ],
        build: pendulum_array,
    },
    SystemInfo {
        name: "harmonic-oscillator",
        summary: "independent oscillators, H = Σ (p² + ω² q²)/2",
        keys: &[
            Key::new("dof", "1", "number of oscillators"),
            Key::new("omega", "1.0", "angular frequency, one for all or a list"),
            Q0,
            P0,
        ],
        build: |section, _| {
            let dof = section.whole("dof", 1)? as usize;
            let omega = section.numbers("omega", dof)?;
            let system =
                HarmonicOscillator::new(omega).map_err(|e| refused(section, "omega", e))?;
            space(section, "harmonic-oscillator", system)
        },
    },
    SystemInfo {
        name: "henon-heiles",
        summary: "H = |p|²/2 + |q|²/2 + q₁² q₂ − q₂³/3, two degrees of freedom",
        keys: &[
            Key::new("q0", "[0.0, 0.1]", "centre of the loop, positions"),
            Key::new("p0", "[0.3, 0.0]", "centre of the loop, momenta"),
        ],
        build: |section, _| space(section, "henon-heiles", HenonHeiles),
    },
];

/// Reads `[system]`.
pub fn read(node: Option<&Node>, folder: &Path) -> Result<(System, Section), ConfigError> {
    const NAME: Key = Key::optional("name", "\"pendulum\"", "which system");
    // The name says which keys there are, so it is read before they are judged.
    let names = || SYSTEMS.iter().map(|info| info.name);
    let bare = Section::new("system", None, vec![NAME])?;
    let written = match node.map(|node| &node.value) {
        Some(Value::Table(table)) => table.entries.get("name").map(|(_, node)| node),
        _ => None,
    };
    let Some(written) = written else {
        let all = names().collect::<Vec<_>>().join(", ");
        return Err(bare.error(
            "name",
            "missing",
            format!("add [system] with name = one of {all}"),
        ));
    };
    let Value::Text(name) = &written.value else {
        return Err(bare
            .error(
                "name",
                format!("{}, not a text", written.value.kind()),
                "put it in quotes",
            )
            .at(&written.place, "must be a text"));
    };
    let Some(info) = SYSTEMS.iter().find(|info| info.name == name) else {
        return Err(bare
            .error(
                "name",
                format!("there is no \"{name}\""),
                suggestion(name, names()),
            )
            .at(&written.place, "unknown"));
    };
    let keys = info.keys.iter().copied().chain([NAME]).collect();
    let section = Section::new("system", node, keys)?;
    section.text("name")?;
    let system = (info.build)(&section, folder)?;
    Ok((system, section))
}

/// A model's own complaint, at the key that caused it.
fn refused(section: &Section, key: &str, error: ModelError) -> ConfigError {
    let text = error.to_string();
    match text.split_once("; ") {
        Some((message, remedy)) => section.error(key, message, remedy),
        None => section.error(key, text, "change this key"),
    }
}

/// A system of one degree of freedom.
fn plane(
    section: &Section,
    name: &'static str,
    hamiltonian: impl Separable + 'static,
) -> Result<System, ConfigError> {
    Ok(System {
        name,
        hamiltonian: Arc::new(hamiltonian),
        q0: vec![section.number("q0", Accept::Finite)?],
        p0: vec![section.number("p0", Accept::Finite)?],
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
        hamiltonian: Arc::new(hamiltonian),
        q0: section.numbers("q0", dof)?,
        p0: section.numbers("p0", dof)?,
    })
}

fn pendulum_array(section: &Section, folder: &Path) -> Result<System, ConfigError> {
    let pendula = section.whole("pendula", 1)? as usize;
    let alpha = section.number("alpha", Accept::Finite)?;
    let k = section.number("k", Accept::Finite)?;
    let seed = section.whole("seed", 0)?;
    let array =
        PendulumArray::new(pendula, alpha, k).map_err(|e| refused(section, "pendula", e))?;
    let initial = section.node("initial")?;
    let (q0, p0) = match initial.as_ref().map(|node| &node.value) {
        Some(Value::Text(text)) if text == "uniform" => array.uniform_state(seed),
        Some(Value::Table(_)) => {
            let keys = [Key::optional(
                "file",
                "\"state.npy\"",
                "rows q and p, or columns in .csv",
            )];
            let inner = section
                .subsection("initial", &keys)?
                .expect("it is a table");
            let Some(file) = inner.optional_text("file")? else {
                return Err(section.error(
                    "initial",
                    "no file named",
                    "write { file = \"state.npy\" }",
                ));
            };
            read_state(&folder.join(file), pendula)
                .map_err(|error| section.error("initial", error.message, error.remedy))?
        }
        _ => {
            return Err(section.error(
                "initial",
                "neither \"uniform\" nor a file",
                "write \"uniform\" or { file = \"state.npy\" }",
            ));
        }
    };
    Ok(System {
        name: "pendulum-array",
        hamiltonian: Arc::new(array),
        q0,
        p0,
    })
}
