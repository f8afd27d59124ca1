//! `[loop]`: the closed curve of initial states.

use std::sync::Arc;

use symplint::map::{ProjectedLoop, balanced_radii};
use symplint::{Circle, FourierLoop, Loop, TimeAdvance};

use super::document::{Node, Value};
use super::error::ConfigError;
use super::section::{Accept, Key, Section};
use super::system::System;

/// The keys of `[loop]`.
pub const KEYS: &[Key] = &[
    Key::new(
        "shape",
        "\"circle\"",
        "\"circle\": q = q0 + r sin 2πs, p = p0 + r cos 2πs; or \"fourier\": random modes 1 to 3",
    ),
    Key::new(
        "radius",
        "1.0",
        "r; a list, one for each degree of freedom; { q = …, p = … }; or \"auto\", as the map suggests",
    ),
    Key::optional(
        "dofs",
        "[0]",
        "degrees of freedom that the circle moves, counted from 0; all if left out",
    ),
    Key::new(
        "phases",
        "\"equal\"",
        "\"random\": each degree of freedom starts at a phase of its own",
    ),
    Key::new("seed", "1", "seed of random phases and modes"),
];

const RADII: [Key; 2] = [
    Key::new("q", "1.0", "radius in q: a number or a list"),
    Key::new("p", "1.0", "radius in p: a number or a list"),
];

/// The loop of a configuration.
pub struct ReadLoop {
    pub phase_loop: Box<dyn Loop>,
    /// Its radii in words and the evaluations that they took, where they were looked for.
    pub radii: Option<(String, usize)>,
}

/// Reads `[loop]`; its centre is the initial state of the system, and radii are looked for at a step of the map.
pub fn read(
    node: Option<&Node>,
    system: &System,
    map: &Arc<dyn TimeAdvance>,
    step_size: f64,
) -> Result<(ReadLoop, Section), ConfigError> {
    let section = Section::new("loop", node, KEYS.to_vec())?;
    let shape = section.choice("shape", &["circle", "fourier"])?;
    let (q0, p0) = (system.q0.clone(), system.p0.clone());
    let refused = |key: &'static str| {
        let section = &section;
        move |error: symplint::Error| {
            let text = error.to_string();
            match text.split_once("; ") {
                Some((message, remedy)) => section.error(key, message, remedy),
                None => section.error(key, text, "name degrees of freedom from 0 on"),
            }
        }
    };
    let (radii_q, radii_p, found) = match section.written_text("radius") {
        Some("auto") => {
            let found = balanced_radii(map, &q0, &p0, step_size).map_err(refused("radius"))?;
            let text = format!("radius q {}, p {}", range(&found.q), range(&found.p));
            section.record(
                "radius",
                toml::Table::from_iter([
                    ("q".to_owned(), toml::Value::from(found.q.clone())),
                    ("p".to_owned(), toml::Value::from(found.p.clone())),
                ]),
            );
            (found.q, found.p, Some((text, found.evaluations)))
        }
        _ => {
            let (q, p) = radii(&section, q0.len())?;
            (q, p, None)
        }
    };
    let dofs = section.optional_wholes("dofs", 0)?;
    let phases = section.choice("phases", &["equal", "random"])?;
    let seed = section.whole("seed", 0)?;
    let phase_loop: Box<dyn Loop> = if shape == "circle" {
        let circle = Circle::with_radii(q0, p0, radii_q, radii_p);
        let mut circle = circle.map_err(refused("radius"))?;
        if let Some(dofs) = dofs {
            let dofs: Vec<usize> = dofs.into_iter().map(|dof| dof as usize).collect();
            circle = circle.on(&dofs).map_err(refused("dofs"))?;
        }
        if phases == "random" {
            circle = circle.with_random_phases(seed);
        }
        Box::new(circle)
    } else {
        let circle_only = if dofs.is_some() { Some("dofs") } else { None };
        if let Some(key) = circle_only.or((phases == "random").then_some("phases")) {
            return Err(section.error(
                key,
                "applies to circles only",
                "leave it out: a fourier loop has random phases in every degree of freedom",
            ));
        }
        let fourier = FourierLoop::random(q0, p0, &radii_q, &radii_p, seed);
        Box::new(fourier.map_err(refused("radius"))?)
    };
    // A loop of a constrained system lies on its manifold.
    let phase_loop: Box<dyn Loop> = match map.constraint() {
        Some(_) => Box::new(ProjectedLoop::new(phase_loop, Arc::clone(map))),
        None => phase_loop,
    };
    let radii = found;
    Ok((ReadLoop { phase_loop, radii }, section))
}

/// Radii in q and in p, of every degree of freedom.
fn radii(section: &Section, dof: usize) -> Result<(Vec<f64>, Vec<f64>), ConfigError> {
    let node = section.node("radius")?.expect("it has a default");
    match &node.value {
        Value::Table(_) => {
            let apart = section.subsection("radius", &RADII)?;
            let apart = apart.expect("it is a table");
            let radii = (apart.numbers("q", dof)?, apart.numbers("p", dof)?);
            section.adopt("radius", apart);
            Ok(radii)
        }
        Value::List(_) => {
            let radii = section.numbers("radius", dof)?;
            Ok((radii.clone(), radii))
        }
        _ => {
            let radius = section.number("radius", Accept::Positive)?;
            Ok((vec![radius; dof], vec![radius; dof]))
        }
    }
}

/// A value, or the smallest and the largest of several.
fn range(values: &[f64]) -> String {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(0.0, f64::max);
    match low == high {
        true => format!("{low:.3e}"),
        false => format!("{low:.3e} to {high:.3e}"),
    }
}
