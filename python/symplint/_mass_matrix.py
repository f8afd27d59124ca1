"""Steps in positions and velocities, as steps in positions and the momenta M(q) v."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ._arrays import numbers
from ._errors import InputError

__all__ = ["EnergyOfVelocities", "MassMatrix", "StepOfVelocities"]


class MassMatrix:
    """The mass matrix at a state or at many: what the user gave as a function, or one for all states."""

    def __init__(self, given: Any) -> None:
        self.given = given if callable(given) else numbers(given, "mass_matrix")

    def at(self, q: Any) -> Any:
        """The matrix of each row of q."""
        found = np.asarray(self.given(q.copy()) if callable(self.given) else self.given)
        dof = q.shape[-1]
        expected = (*q.shape, dof)
        if found.shape not in (expected, (dof, dof)):
            name = "mass_matrix(q)" if callable(self.given) else "mass_matrix"
            raise InputError(f"{name} has the shape {found.shape} and q {q.shape}; give {expected}, or ({dof}, {dof}) for one matrix")
        return found

    def momenta(self, q: Any, v: Any) -> Any:
        """M(q) v."""
        return (self.at(q) @ np.asarray(v)[..., None])[..., 0]

    def velocities(self, q: Any, p: Any) -> Any:
        """M(q)⁻¹ p."""
        return np.linalg.solve(self.at(q), np.asarray(p)[..., None])[..., 0]


class StepOfVelocities:
    """``step(q, v, h)`` as a step of positions and canonical momenta."""

    def __init__(self, step: Callable[..., Any], mass_matrix: MassMatrix, make: bool = False) -> None:
        self.step, self.mass_matrix, self.make = step, mass_matrix, make
        self.__name__ = str(getattr(step, "__name__", type(step).__name__))

    def __call__(self, *arguments: Any) -> Any:
        if self.make:
            return StepOfVelocities(self.step(*arguments), self.mass_matrix)
        q, p, *h = arguments
        v = self.mass_matrix.velocities(q, p)
        after = self.step(q, v, *h)
        if after is not None:
            q, v = (np.asarray(rows) for rows in after)
        return q, self.mass_matrix.momenta(q, v)


class EnergyOfVelocities:
    """``energy(q, v)`` as a function of positions and canonical momenta."""

    def __init__(self, energy: Callable[..., Any], mass_matrix: MassMatrix) -> None:
        self.energy, self.mass_matrix = energy, mass_matrix

    def __call__(self, q: Any, p: Any) -> Any:
        return self.energy(q, self.mass_matrix.velocities(q, p))
