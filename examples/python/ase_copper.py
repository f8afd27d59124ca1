"""Four atoms of copper in ASE, by its velocity Verlet and by its Langevin dynamics (pip install ase).

Positions are in Å, and the momenta of ASE, mass times velocity, are canonical: they need no weights. New atoms for each state
keep nothing of the one before.
"""

import numpy as np
import symplint
from ase import Atoms, units
from ase.calculators.emt import EMT
from ase.md.langevin import Langevin
from ase.md.verlet import VelocityVerlet

# A regular tetrahedron, near its state of rest.
POSITIONS = 0.9 * np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])


def step_of(dynamics):
    """One step of `dynamics`, a function of the atoms and the step size."""

    def step(q, p, h):
        atoms = Atoms("Cu4", q.reshape(4, 3), momenta=p.reshape(4, 3), calculator=EMT())
        dynamics(atoms, h).run(1)
        return atoms.get_positions().ravel(), atoms.get_momenta().ravel()

    return step


def verlet(atoms, h):
    return VelocityVerlet(atoms, timestep=h)


def langevin(atoms, h):
    # The same noise for every state: a map must not depend on anything but the state and h.
    random = np.random.RandomState(1)
    return Langevin(atoms, timestep=h, temperature_K=300, friction=0.005 / units.fs, rng=random, fixcm=False)


def report(dynamics):
    return symplint.check(
        step_of(dynamics), POSITIONS.ravel(), np.zeros(12), step_sizes=np.array([24.0, 12.0, 6.0]) * units.fs,
        radius=(0.02, 0.5), per_sample=True, budget=2500, loops=3,
    )  # fmt: skip


if __name__ == "__main__":
    for dynamics in (verlet, langevin):
        found = report(dynamics)
        print(f"{dynamics.__name__}: {found.headline}\n  {found.summary}")
