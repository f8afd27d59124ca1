//! Systems that are maps and need no integrator.

use std::sync::Arc;

use symplint::TimeAdvance;
use symplint_models::Model;
use symplint_models::discrete::{HenonMap, PendulumRattle, StandardMap};

use super::{System, SystemInfo};
use crate::ConfigError;
use crate::section::{Key, NumberRange, Section};

/// The name of the integrator of a system that is a map.
pub const NOTHING: &str = "none";
pub const NONE: &str = "\"none\"";

const P0: Key = Key::new("p0", "0.0", "centre of the loop, momentum").numbers();

pub const HENON_MAP: SystemInfo = SystemInfo {
    name: "henon-map",
    summary: "Hénon's area-preserving map: p −= h q², then a rotation by the angle αh; a map, \
              without integrator",
    keys: &[
        Key::new("angle", "1.33", "α; Hénon's map is the step h = 1"),
        Key::new(
            "contraction",
            "1.0",
            "b; areas are multiplied by b^h: below 1 the map is dissipative",
        ),
        Key::new("q0", "0.0", "centre of the loop, position").numbers(),
        P0,
    ],
    integrator: NONE,
    budget: None,
    build: |section, _| {
        let angle = section.number("angle", NumberRange::Finite)?;
        let contraction = section.number("contraction", NumberRange::Positive)?;
        let map = HenonMap::new(angle, contraction).map_err(|e| section.refused_by("angle", &e))?;
        given(section, "henon-map", map)
    },
};

pub const STANDARD_MAP: SystemInfo = SystemInfo {
    name: "standard-map",
    summary: "the standard map, p += K h sin q, then q += h p mod 2π, on the cylinder or the torus; a map, \
              without integrator",
    keys: &[
        Key::new(
            "strength",
            "0.971635",
            "K; the standard map is the step h = 1",
        ),
        Key::new(
            "torus",
            "false",
            "whether p is also taken mod 2π; step sizes must then be whole numbers",
        ),
        Key::new("q0", "\"pi\"", "centre of the loop, angle").numbers(),
        P0,
    ],
    integrator: NONE,
    budget: None,
    build: |section, _| {
        let strength = section.number("strength", NumberRange::Finite)?;
        let map = StandardMap::new(strength).map_err(|e| section.refused_by("strength", &e))?;
        let map = match section.flag("torus")? {
            true => map.on_torus(),
            false => map,
        };
        given(section, "standard-map", map)
    },
};

pub const PENDULUM_RATTLE: SystemInfo = SystemInfo {
    name: "pendulum-rattle",
    summary: "a unit mass on a rod in Cartesian coordinates, x² + y² = L², by RATTLE; a map, without \
              integrator; loops are put on the circle",
    keys: &[
        Key::new("length", "1.0", "L"),
        Key::new("gravity", "1.0", "g"),
        Key::new(
            "angle",
            "0.6",
            "centre of the loop, angle from the lowest position",
        ),
        Key::new(
            "momentum",
            "0.5",
            "centre of the loop, momentum along the circle",
        ),
    ],
    integrator: NONE,
    budget: None,
    build: |section, _| {
        let length = section.number("length", NumberRange::Positive)?;
        let gravity = section.number("gravity", NumberRange::Finite)?;
        let map =
            PendulumRattle::new(length, gravity).map_err(|e| section.refused_by("length", &e))?;
        let angle = section.number("angle", NumberRange::Finite)?;
        let (q0, p0) = map.state(angle, section.number("momentum", NumberRange::Finite)?);
        Ok(System {
            name: "pendulum-rattle",
            model: Model::Map(Arc::new(map)),
            q0: q0.to_vec(),
            p0: p0.to_vec(),
            command: None,
        })
    },
};

/// A map of one degree of freedom.
fn given(
    section: &Section,
    name: &'static str,
    map: impl TimeAdvance + 'static,
) -> Result<System, ConfigError> {
    Ok(System {
        name,
        model: Model::Map(Arc::new(map)),
        q0: vec![section.number("q0", NumberRange::Finite)?],
        p0: vec![section.number("p0", NumberRange::Finite)?],
        command: None,
    })
}
