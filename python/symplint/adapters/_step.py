"""The step that an adapter returns."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .._arrays import Array

__all__ = ["AdaptedStep", "radii_of_bodies"]

#: Radii of the lightest bodies as a part of the smallest distance. Conventional: forces vary, and do not change their kind.
PART_OF_DISTANCE = 0.02
#: The phase, in radians, by which a typical step advances the fastest motion. Conventional: it sets the velocities of the loop.
PHASE_OF_A_STEP = 0.2
#: Bodies whose distances from all others are computed.
BODIES_TRIED = 256


class AdaptedStep:
    """A step of another package with its centre, masses and step sizes: what the functions of `symplint.adapters` return.

    `symplint.check` uses its centre, weights and step sizes unless you pass others. It may be called as ``step(q, p, h)``.

    Parameters
    ----------
    step : callable
        ``step(q, p, h)`` of one state, or of many if `per_sample` is false. Without a step size, h has no meaning.
    name : str
        Its name in reports.
    q0, p0 : array_like
        The centre of the loops.
    weight : array_like, optional
        The canonical momentum is weight × p.
    radius : float, array_like, pair of them or "auto"
        Radius of the loop, as `symplint.check` takes it.
    per_sample : bool
        Whether `step` takes one state.
    step_sizes : "none", optional
        "none" if the map has no step size.
    typical_step : float, optional
        A typical step size.
    dtype : str, optional
        "float32" if the step computes in single precision.
    parts : sequence of (str, callable), optional
        Parts of the step, in which `symplint.check` searches for a defect.
    """

    def __init__(
        self,
        step: Callable[..., Any],
        name: str,
        q0: npt.ArrayLike,
        p0: npt.ArrayLike,
        *,
        weight: npt.ArrayLike | None = None,
        radius: Any = "auto",
        per_sample: bool = True,
        step_sizes: str | None = None,
        typical_step: float | None = None,
        dtype: str | None = None,
        parts: Sequence[tuple[str, Callable[..., Any]]] = (),
    ) -> None:
        self.step = step
        self.__name__ = name
        self.q0: Array = np.array(q0, dtype=np.float64)
        self.p0: Array = np.array(p0, dtype=np.float64)
        self.weight: Array | None = None if weight is None else np.array(weight, dtype=np.float64)
        self.radius = radius
        self.per_sample, self.step_sizes, self.typical_step, self.dtype = per_sample, step_sizes, typical_step, dtype
        self.parts = list(parts)
        self._lock = threading.Lock()

    def __call__(self, q: Any, p: Any, h: float | None = None) -> Any:
        """The states after one step."""
        # Threads would share the object of the package that takes the step.
        with self._lock:
            return self.step(q, p, h)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_lock"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state, _lock=threading.Lock())

    def __repr__(self) -> str:
        return f"<step: {self.__name__}, {self.q0.size} degrees of freedom>"


def radii_of_bodies(positions: Array, masses: Array, typical_step: float) -> Any:
    """Radii of a loop that moves bodies by a small part of their distances, and gives all of them the same action.

    Parameters
    ----------
    positions : ndarray of shape (bodies, 3)
        Where the bodies are.
    masses : ndarray of shape (bodies,)
        Their masses.
    typical_step : float
        A typical step size.

    Returns
    -------
    (ndarray, ndarray) or "auto"
        Radii of positions and velocities, x, y and z of the first body first. "auto" if there is no distance or no step size.
    """
    tried = positions[:: -(-len(positions) // BODIES_TRIED)]
    squared = ((tried[:, None] - positions) ** 2).sum(axis=2)
    apart = squared[squared > 0.0]
    if not apart.size or not typical_step:
        return "auto"
    of_q = np.repeat(PART_OF_DISTANCE * np.sqrt(apart.min() * masses.min() / masses), 3)
    return of_q, of_q * PHASE_OF_A_STEP / abs(typical_step)
