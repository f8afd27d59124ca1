"""Maps in non-canonical coordinates, as canonical ones of the points (z, ϑ(z)).

The loop integral ∮ ϑ(z)·dz is ∮ p·dq with q = z and p = ϑ(z). These points are a manifold, on which the map acts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ._arrays import Array
from ._errors import InputError


#: Steps of Newton's method at most. It converges in a few, from states within the size of the loop.
MAX_STEPS = 50

#: Moves below this part of the loop that do not shrink are noise of the functions.
MAX_NOISE = 1e-6

#: The distance of differences in units of the loop. It is large, as the noise of the direction makes loops rough, and a smooth error of
#: the direction only makes Newton's method take a step more.
DISTANCE = 2.0**-6

#: Functions whose gradients differ in direction by less than the root of this depend on each other. Rounding makes 1e-15 of it.
DEPENDENT = 1e-10


class MapOfForm:
    """``step(z, h)`` as a step of q = z and p = ϑ(z)."""

    def __init__(self, step: Callable[..., Any], form: Callable[..., Any], make: bool) -> None:
        self.step, self.form, self.make = step, form, make
        self.__name__ = getattr(step, "__name__", type(step).__name__)

    def __call__(self, *arguments: Any) -> Any:
        if self.make:
            return MapOfForm(self.step(*arguments), self.form, make=False)
        z, _, *h = arguments
        after = self.step(z, *h)
        after = z if after is None else after
        return after, one_form(self.form, after)


class Projection:
    """Puts states on the points (z, ϑ(z)), with z on the leaf that `leaves` keep to."""

    def __init__(self, form: Callable[..., Any], leaves: list[Callable[..., Any]]) -> None:
        self.form, self.leaves = form, leaves

    def __call__(self, q: Any, p: Any) -> Any:
        for leaf in self.leaves:
            moved = leaf(q)
            q = q if moved is None else np.asarray(moved)
            if q.shape != p.shape:
                raise InputError(f"project(z) has shape {q.shape} and z {p.shape}; return one number for each coordinate")
        return q, one_form(self.form, q)


class Leaf:
    """Puts states z on the level of Casimir functions through a state, by Newton's method along their gradients.

    Gradients are central differences. Distances are in units of the loop, so that the result does not depend on the units of
    the coordinates.
    """

    def __init__(self, casimirs: list[Callable[..., Any]], z0: Array, size: Array, per_sample: bool) -> None:
        self.casimirs, self.size, self.per_sample = casimirs, size, per_sample
        self.level = self.values(z0[None, :])[0]
        if not np.isfinite(self.level).all():
            raise InputError("a function of casimir is not finite at q0; give a state z0 at which all are defined")

    def __call__(self, z: Any) -> Array:
        found = np.array(z, dtype=float).reshape(-1, self.size.size)
        left: Any = np.isfinite(found).all(axis=1)
        last = np.full(len(found), np.inf)
        for _ in range(MAX_STEPS):
            if not left.any():
                break
            rows = found[left]
            gradients = self.gradients(rows)
            with np.errstate(all="ignore"):
                missed = self.values(rows) - self.level
                usable = np.isfinite(missed).all(axis=1) & np.isfinite(gradients).all(axis=(1, 2))
                sizes = np.linalg.norm(gradients, axis=2)
                usable &= (sizes > 0.0).all(axis=1)
                rows[~usable], gradients[~usable], missed[~usable], sizes[~usable] = np.nan, 0.0, 0.0, 1.0
                gradients, missed = gradients / sizes[:, :, None], missed / sizes
                products = gradients @ gradients.transpose(0, 2, 1)
                # Functions that depend on each other are as good as one.
                factors = np.linalg.pinv(products, rcond=DEPENDENT, hermitian=True) @ missed[:, :, None]
                moves = (gradients.transpose(0, 2, 1) @ factors)[:, :, 0]
                found[left] = rows - self.size * moves
            size = np.abs(moves).max(axis=1)
            rounding = 4.0 * np.finfo(float).eps * (np.abs(rows) / self.size).max(axis=1)
            stagnates = (size > 0.5 * last[left]) & (size < MAX_NOISE)
            last[left] = size
            left[left] = (size > rounding) & ~stagnates
        found[left] = np.nan
        return found.reshape(np.shape(z))

    def gradients(self, z: Array) -> Array:
        """Of each function, in units of the loop: (samples, functions, coordinates)."""
        moved = DISTANCE * np.diag(self.size)
        states = z[:, None, None, :] + np.array([1.0, -1.0])[:, None, None] * moved
        values = self.values(states.reshape(-1, self.size.size)).reshape(len(z), 2, self.size.size, -1)
        return ((values[:, 0] - values[:, 1]) / (2.0 * DISTANCE)).transpose(0, 2, 1)

    def values(self, z: Array) -> Array:
        """The values of all functions, one column for each."""
        columns = []
        for casimir in self.casimirs:
            of = np.array([casimir(row) for row in z]) if self.per_sample else np.asarray(casimir(z.copy()))
            if of.shape != z.shape[:1]:
                expected = "one number" if self.per_sample else f"an array of shape {z.shape[:1]}"
                raise InputError(f"casimir(z) has shape {of.shape[1:] if self.per_sample else of.shape}; return {expected}")
            columns.append(of)
        return np.stack(columns, axis=1).astype(float)


class CircleOfForm:
    """A closed curve z(s), with an area in the plane of every two coordinates, and ϑ on it."""

    def __init__(self, z0: Array, radius: Array, form: Callable[..., Any]) -> None:
        self.z0, self.radius, self.form = z0, radius, form

    def __call__(self, s: Array) -> Any:
        phases = np.arange(self.z0.size) / (2 * self.z0.size)
        z = self.z0 + self.radius * np.sin(2.0 * np.pi * (s[:, None] + phases))
        return z, one_form(self.form, z)


class LoopOfForm:
    """A closed curve z(s) of the user, and ϑ on it."""

    def __init__(self, loop: Callable[..., Any], form: Callable[..., Any]) -> None:
        self.loop, self.form = loop, form
        self.__name__ = getattr(loop, "__name__", type(loop).__name__)

    def __call__(self, s: Array) -> Any:
        z = self.loop(s)
        return z, one_form(self.form, z)


class FormOfRows:
    """A one-form that takes one state, for arrays of them."""

    def __init__(self, form: Callable[..., Any]) -> None:
        self.form = form

    def __call__(self, z: Array) -> Any:
        return np.array([one_form(self.form, row) for row in z])


def one_form(form: Callable[..., Any], z: Any) -> Any:
    """ϑ(z), of the shape of z."""
    found = form(z)
    if np.shape(found) != np.shape(z):
        raise InputError(f"form(z) has shape {np.shape(found)} and z {np.shape(z)}; return one number for each coordinate")
    return found
