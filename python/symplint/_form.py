"""Maps in non-canonical coordinates, as canonical ones of the points (z, ϑ(z)).

The loop integral ∮ ϑ(z)·dz is ∮ p·dq with q = z and p = ϑ(z). These points are a manifold, on which the map acts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ._arrays import Array
from ._errors import InputError


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
    """Puts states on the points (z, ϑ(z))."""

    def __init__(self, form: Callable[..., Any]) -> None:
        self.form = form

    def __call__(self, q: Any, p: Any) -> Any:
        return q, one_form(self.form, q)


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
