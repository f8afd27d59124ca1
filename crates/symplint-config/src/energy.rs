//! The energy of a system that has one.

use symplint::map::Capabilities;
use symplint::{Block, StepFailure, TimeAdvance};
use symplint_models::Model;

/// A step of a system, which also gives its energy.
pub struct StepWithEnergy<M> {
    pub map: M,
    pub model: Model,
}

impl<M: TimeAdvance> TimeAdvance for StepWithEnergy<M> {
    fn dof(&self) -> usize {
        self.map.dof()
    }

    fn advance(&self, h: f64, block: &mut Block<'_>) -> Result<(), StepFailure> {
        self.map.advance(h, block)
    }

    fn capabilities(&self) -> Capabilities<'_> {
        let inner = self.map.capabilities();
        Capabilities {
            energy: match self.model.hamiltonian() {
                Some(system) => Some(Box::new(|q, p, energies| system.energy(q, p, energies))),
                None => inner.energy,
            },
            ..inner
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use symplint::Diagnosis;
    use symplint::verdict::{Growth, PropertyName};

    use crate::Config;

    fn diagnosed(settings: &[&str]) -> Diagnosis {
        let settings: Vec<String> = settings.iter().map(ToString::to_string).collect();
        let config = Config::load(Path::new("pendulum"), &settings).unwrap();
        config
            .diagnostic
            .run(&config.map, &*config.phase_loop)
            .unwrap()
    }

    #[test]
    fn many_steps_of_a_system_show_whether_its_energy_drifts() {
        let growth = |diagnosis: &Diagnosis| {
            let mut properties = diagnosis.verdict.properties.iter();
            let energy = properties.find(|of| of.name == PropertyName::Energy)?;
            energy.in_time.map(|(_, growth)| growth)
        };
        let steps = [
            "diagnostic.step_sizes=[0.2]",
            "diagnostic.steps=200",
            "loop.radius=0.5",
        ];
        assert_eq!(growth(&diagnosed(&steps)), Some(Growth::Bounded));
        let by_runge_kutta = [&steps[..], &["integrator.name=rk2"]].concat();
        assert_eq!(growth(&diagnosed(&by_runge_kutta)), Some(Growth::Grows));
        // Without many steps, the energy is not asked for.
        assert_eq!(growth(&diagnosed(&steps[..1])), None);
    }
}
