"""Lattices of PyAT."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from .._errors import InputError
from ._step import AdaptedStep

__all__ = ["pyat"]

#: Rows of an array of PyAT, (x, px, y, py, δ, ct): the positions, then the momenta.
PAIRS = ([0, 2, 4], [1, 3, 5])


def pyat(lattice: Any, orbit: npt.ArrayLike | None = None) -> AdaptedStep:
    """One passage through a lattice of PyAT.

    Parameters
    ----------
    lattice : at.Lattice
        The elements with their pass methods. It is not changed.
    orbit : array_like, optional
        The centre of the loops, a particle as PyAT has it: x, px, y, py, δ and ct. By default, all are 0.

    Returns
    -------
    AdaptedStep
        A map without a step size; radii are 1e-3. Its positions are (x, y, δ) and its momenta (px, py, ct): ct is the momentum of δ. Its
        parts are the elements.

    Raises
    ------
    InputError
        If there are no elements, or the particle does not have six coordinates.

    Notes
    -----
    Set up once: nothing but the lattice. All states are tracked at once. Pass methods with a memory (wakes, beam loading) depend on
    earlier calls.

    Examples
    --------
    >>> import at, symplint
    >>> cell = at.Lattice([at.Quadrupole("QF", 0.5, 1.2), at.Drift("D", 2.0), at.Quadrupole("QD", 0.5, -1.2)], energy=3e9)
    >>> symplint.check(symplint.adapters.pyat(cell), loops=2).kind
    'symplectic'
    """
    elements = list(lattice) if hasattr(lattice, "track") else []
    if not elements:
        raise InputError(f"lattice is an object of type {type(lattice).__name__} without elements; give an at.Lattice")
    particle = np.zeros(6) if orbit is None else np.asarray(orbit, dtype=np.float64)
    if particle.shape != (6,):
        raise InputError(f"orbit has the shape {particle.shape}; give six numbers: x, px, y, py, delta and ct")

    def tracked(track: Callable[..., Any]) -> Callable[..., Any]:
        def step(q: Any, p: Any, _: Any = None) -> tuple[Any, Any]:
            particles = np.empty((6, len(q)), order="F")
            particles[PAIRS[0]], particles[PAIRS[1]] = q.T, p.T
            track(particles)
            return particles[PAIRS[0]].T, particles[PAIRS[1]].T

        return step

    reference = {"energy": lattice.energy, "particle": lattice.particle, "in_place": True}
    parts = [
        (f"{element.FamName} ({element.PassMethod})", tracked(functools.partial(element.track, **reference))) for element in elements
    ]
    return AdaptedStep(
        tracked(functools.partial(lattice.track, nturns=1, in_place=True)), "PyAT lattice",
        particle[PAIRS[0]], particle[PAIRS[1]], radius=1e-3, per_sample=False, step_sizes="none", parts=parts,
    )  # fmt: skip
