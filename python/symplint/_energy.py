"""The energy of states."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ._errors import InputError

__all__ = ["EnergyOfRows"]


class EnergyOfRows:
    """Writes the energy of states into their first positions, as the native module reads it.

    Parameters
    ----------
    energy : callable
        ``energy(q, p)``, or ``energy(q)`` if the positions are all coordinates.
    has_form : bool
        Whether they are.
    """

    def __init__(self, energy: Callable[..., Any], has_form: bool) -> None:
        self.energy, self.has_form = energy, has_form

    def __call__(self, q: Any, p: Any) -> tuple[Any, Any]:
        """The states with their energies."""
        energies = np.asarray(self.energy(q.copy()) if self.has_form else self.energy(q.copy(), p.copy()))
        expected = q.shape[:-1]
        if energies.shape != expected:
            raise InputError(f"energy returns an array of shape {energies.shape}; give one number for each state, shape {expected}")
        q[..., 0] = energies
        return q, p
