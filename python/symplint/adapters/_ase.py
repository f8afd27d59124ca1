"""Dynamics of ASE."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import numpy as np

from .._errors import InputError
from ._step import AdaptedStep, radii_of_bodies

__all__ = ["ase"]

#: A femtosecond in the unit of time of ASE, Å √(u/eV): a usual time step for hydrogen, and √m times as much for atoms of mass m.
FEMTOSECOND = 0.09822694788464063


def ase(atoms: Any, dynamics: Callable[..., Any], **options: Any) -> AdaptedStep:
    """Molecular dynamics of ASE.

    Parameters
    ----------
    atoms : ase.Atoms
        Atoms with a calculator. They are not changed.
    dynamics : callable
        A class of molecular dynamics such as ``ase.md.verlet.VelocityVerlet``, or a function ``dynamics(atoms, timestep=…)`` that returns
        one.
    **options
        Further arguments of `dynamics`.

    Returns
    -------
    AdaptedStep
        One step of size h in the unit of time of ASE; a typical step is √m fs for a lightest atom of mass m. States are positions and
        momenta, x, y and z of the first atom first, without atoms that ``FixAtoms`` holds. They are canonical.

    Raises
    ------
    InputError
        If `dynamics` is not a class or function, `atoms` has no calculator, or a constraint other than ``FixAtoms``.

    Notes
    -----
    Set up once: the atoms and their calculator. For each state: positions, momenta, new dynamics, and a copy of `options`. The copy of a
    random generator begins anew, so that each state gets the same noise: a map must not depend on anything but the state and h.

    Examples
    --------
    >>> import ase, symplint
    >>> from ase.calculators.emt import EMT
    >>> from ase.md.verlet import VelocityVerlet
    >>> copper = ase.Atoms("Cu2", [[0.0, 0.0, 0.0], [2.3, 0.0, 0.0]], calculator=EMT())
    >>> step = symplint.adapters.ase(copper, VelocityVerlet)
    >>> symplint.check(step, budget=2000, loops=2).kind
    'symplectic'
    """
    if not hasattr(atoms, "get_positions"):
        raise InputError(f"atoms is an object of type {type(atoms).__name__}; give ase.Atoms")
    if not callable(dynamics):
        raise InputError(f"dynamics is an object of type {type(dynamics).__name__}; give a class such as ase.md.verlet.VelocityVerlet")
    if atoms.calc is None:
        raise InputError("the atoms have no calculator; set atoms.calc")
    free = np.ones(len(atoms), dtype=bool)
    for constraint in atoms.constraints:
        if type(constraint).__name__ != "FixAtoms":
            name = type(constraint).__name__
            raise InputError(f"the atoms have the constraint {name}; remove it, or write a step and give project=")
        free[constraint.index] = False
    if not free.any():
        raise InputError("all atoms are fixed; let some move")
    work = atoms.copy()
    work.calc = atoms.calc

    def step(q: Any, p: Any, h: float) -> tuple[Any, Any]:
        for values, change in ((q, work.set_positions), (p, work.set_momenta)):
            rows = atoms.get_positions() if change == work.set_positions else np.zeros((len(atoms), 3))
            rows[free] = values.reshape(-1, 3)
            change(rows, apply_constraint=False)
        dynamics(work, timestep=h, **copy.deepcopy(options)).run(1)
        return work.get_positions()[free].ravel(), work.get_momenta()[free].ravel()

    name = f"ASE {getattr(dynamics, '__name__', 'dynamics')}"
    q0, p0, masses = atoms.get_positions()[free], atoms.get_momenta()[free], atoms.get_masses()[free]
    typical_step = FEMTOSECOND * float(np.sqrt(masses.min()))
    radius = radii_of_bodies(q0, masses, typical_step)
    if isinstance(radius, tuple):
        radius = radius[0], radius[1] * np.repeat(masses, 3)
    return AdaptedStep(step, name, q0.ravel(), p0.ravel(), radius=radius, typical_step=typical_step)
