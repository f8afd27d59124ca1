//! `[integrator]`: the time-advance map.

use std::sync::Arc;

use symplint::TimeAdvance;
use symplint_models::integrators::catalogue::{CATALOGUE, build};
use symplint_models::{ModelError, Separable};

use super::document::{Node, SETTING};
use super::error::ConfigError;
use super::section::{Key, Section, suggestion};

/// The keys of `[integrator]`.
pub const KEYS: &[Key] = &[
    Key::new("name", "\"strang\"", "see `symplint list integrators`"),
    Key::optional(
        "variant",
        "\"position-first\"",
        "\"position-first\" or \"momentum-first\"; for rk2 \"midpoint\" or \"heun\"",
    ),
];

/// Reads `[integrator]` and builds its step.
pub fn read(
    node: Option<&Node>,
    system: Arc<dyn Separable>,
) -> Result<(String, Box<dyn TimeAdvance>, Section), ConfigError> {
    let section = Section::new("integrator", node, KEYS.to_vec())?;
    let name = section.text("name")?;
    let of_other = variant_of_another(&section, &name);
    let variant = if of_other {
        None
    } else {
        section.optional_text("variant")?
    };
    let map = build(&name, variant.as_deref(), system).map_err(|error| {
        let names = CATALOGUE.iter().map(|info| info.name);
        match &error {
            ModelError::UnknownIntegrator { .. } => section.error(
                "name",
                format!("there is no integrator \"{name}\""),
                suggestion(&name, names),
            ),
            ModelError::UnknownVariant { known, variant, .. } => section.error(
                "variant",
                format!("\"{name}\" has no variant \"{variant}\""),
                match known {
                    [] => "it has none: leave the key out".to_owned(),
                    known => suggestion(variant, known.iter().copied()),
                },
            ),
            other => section.error("name", other.to_string(), "choose another integrator"),
        }
    })?;
    let full_name = variant.map_or(name.clone(), |variant| format!("{name}, {variant}"));
    Ok((full_name, map, section))
}

/// Whether `--set` named another integrator than the file did, for which the file's variant
/// means nothing.
fn variant_of_another(section: &Section, name: &str) -> bool {
    let set = |key| {
        section
            .written_place(key)
            .is_some_and(|place| place.source.name() == SETTING)
    };
    let known = CATALOGUE
        .iter()
        .find(|info| info.name == name)
        .map(|info| info.variants);
    let written = section.written_text("variant");
    set("name")
        && !set("variant")
        && written
            .zip(known)
            .is_some_and(|(variant, known)| !known.contains(&variant))
}
