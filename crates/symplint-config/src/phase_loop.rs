//! `[loop]`: the closed curve of initial states.

use std::sync::Arc;

use symplint::map::{ProjectedLoop, balanced_radii};
use symplint::verdict::plain_numbers;
use symplint::{Circle, FourierLoop, Loop, Phases, TimeAdvance};

use super::document::{Node, Value};
use super::error::ConfigError;
use super::section::{Key, NumberRange, Section};
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
        "r: a number; a list, one for each degree of freedom; { q = …, p = … }; or \"auto\", a size taken from the map",
    ),
    Key::optional(
        "dofs",
        "[0]",
        "degrees of freedom that the circle moves, counted from 0; by default all",
    ),
    Key::new(
        "phases",
        "\"staggered\"",
        "where each degree of freedom starts: multiples of the golden ratio, \"equal\" (the paper's circle) or \"random\"",
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
    /// Its radii in words, if the map chose them.
    pub radii: Option<String>,
}

/// `[loop]` as it is written, before the map is called.
pub struct LoopSettings {
    section: Section,
    shape: &'static str,
    /// None where the map is to suggest them.
    radii: Option<(Vec<f64>, Vec<f64>)>,
    dofs: Option<Vec<u64>>,
    phases: Phases,
    seed: u64,
}

/// Reads `[loop]` of a system with `dof` degrees of freedom.
pub fn read(node: Option<&Node>, dof: usize) -> Result<LoopSettings, ConfigError> {
    let section = Section::new("loop", node, KEYS.to_vec())?;
    let shape = section.choice("shape", &["circle", "fourier"])?;
    let radii = match section.written_text("radius") {
        Some("auto") => {
            section.text("radius")?;
            None
        }
        _ => Some(radii(&section, dof)?),
    };
    let dofs = section.optional_wholes("dofs", 0)?;
    let phases = section.choice("phases", &Phases::NAMES)?;
    let seed = section.whole("seed", 0)?;
    let phases = Phases::named(phases, seed).expect("one of the names");
    Ok(LoopSettings {
        section,
        shape,
        radii,
        dofs,
        phases,
        seed,
    })
}

impl LoopSettings {
    /// The keys with their values.
    pub fn resolved(&self) -> toml::Table {
        self.section.recorded()
    }

    /// The loop round the initial state of a system; radii are determined at a step of the map.
    pub fn build(
        &self,
        system: &System,
        map: &Arc<dyn TimeAdvance>,
        step_size: f64,
    ) -> Result<ReadLoop, ConfigError> {
        let (q0, p0) = (system.q0.clone(), system.p0.clone());
        let (radii_q, radii_p, found) = match &self.radii {
            Some((q, p)) => (q.clone(), p.clone(), None),
            None => {
                let found = balanced_radii(map, &q0, &p0, step_size);
                let found = found.map_err(|error| self.section.refused_by("radius", &error))?;
                // A run of a program is resumed from its configuration, and has to make the same calls again.
                if system.command.is_none() {
                    self.record_radii(&found.q, &found.p);
                }
                (found.q.clone(), found.p.clone(), Some(found))
            }
        };
        let phase_loop: Box<dyn Loop> = if self.shape == "circle" {
            let circle = Circle::with_radii(q0, p0, radii_q, radii_p);
            let mut circle = circle.map_err(|error| self.section.refused_by("radius", &error))?;
            if let Some(dofs) = &self.dofs {
                let dofs: Vec<usize> = dofs.iter().map(|&dof| dof as usize).collect();
                circle =
                    (circle.on(&dofs)).map_err(|error| self.section.refused_by("dofs", &error))?;
            }
            Box::new(circle.with_phases(self.phases))
        } else {
            let circle_only = self.dofs.is_some().then_some("dofs");
            if let Some(key) =
                circle_only.or((self.phases != Phases::default()).then_some("phases"))
            {
                return Err(self.section.error(
                    key,
                    "applies to circles only",
                    "leave it out: a fourier loop has random phases in every degree of freedom",
                ));
            }
            let fourier = FourierLoop::random(q0, p0, &radii_q, &radii_p, self.seed);
            Box::new(fourier.map_err(|error| self.section.refused_by("radius", &error))?)
        };
        // A loop of a constrained system lies on its manifold.
        let radii = (found.as_ref())
            .map(|found| format!("radius q {}, p {}", range(&found.q), range(&found.p)));
        let phase_loop: Box<dyn Loop> = match found {
            Some(found) => Box::new(found.counted(phase_loop)),
            None => phase_loop,
        };
        let phase_loop: Box<dyn Loop> = match map.capabilities().constraint {
            Some(_) => Box::new(ProjectedLoop::new(phase_loop, Arc::clone(map))),
            None => phase_loop,
        };
        Ok(ReadLoop { phase_loop, radii })
    }

    fn record_radii(&self, q: &[f64], p: &[f64]) {
        let radii = [("q", q), ("p", p)]
            .map(|(name, radii)| (name.to_owned(), toml::Value::from(radii.to_vec())));
        (self.section).record("radius", toml::Table::from_iter(radii));
    }
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
            let radius = section.number("radius", NumberRange::Positive)?;
            Ok((vec![radius; dof], vec![radius; dof]))
        }
    }
}

/// A value, or the smallest and the largest of several.
fn range(values: &[f64]) -> String {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(0.0, f64::max);
    match low == high {
        true => plain_numbers(&format!("{low:.3e}")),
        false => plain_numbers(&format!("{low:.3e} to {high:.3e}")),
    }
}
