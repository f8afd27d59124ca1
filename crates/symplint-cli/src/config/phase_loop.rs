//! `[loop]`: the closed curve of initial states.

use symplint::{Circle, FourierLoop, Loop};

use super::document::Node;
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
    Key::new("radius", "1.0", "r, in units of q and of p"),
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

/// Reads `[loop]`; its centre is the initial state of the system.
pub fn read(node: Option<&Node>, system: &System) -> Result<(Box<dyn Loop>, Section), ConfigError> {
    let section = Section::new("loop", node, KEYS.to_vec())?;
    let shape = section.choice("shape", &["circle", "fourier"])?;
    let radius = section.number("radius", Accept::Positive)?;
    let dofs = section.optional_wholes("dofs", 0)?;
    let phases = section.choice("phases", &["equal", "random"])?;
    let seed = section.whole("seed", 0)?;
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
    let phase_loop: Box<dyn Loop> = if shape == "circle" {
        let mut circle = Circle::new(q0, p0, radius).map_err(refused("radius"))?;
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
        let radii = vec![radius; q0.len()];
        Box::new(FourierLoop::random(q0, p0, &radii, &radii, seed).map_err(refused("radius"))?)
    };
    Ok((phase_loop, section))
}
