"""States whose arrays have several axes, such as (atoms, 3), as rows of numbers."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ._arrays import Array, numbers
from ._errors import InputError

__all__ = ["Shaped", "axes", "broadcast", "of_any_shape", "shaped"]


def axes(value: Any) -> int:
    """The number of axes of an array; 1 for other objects, which are refused later."""
    try:
        return numbers(value, "q0").ndim
    except (TypeError, ValueError):
        return 1


def of_any_shape(value: Any, name: str) -> Array:
    """Numbers of any shape; a single one makes a row.

    Raises
    ------
    InputError
        If it is empty, or not an array of numbers.
    """
    try:
        array = numbers(value, name)
    except (TypeError, ValueError) as error:
        raise InputError(str(error)) from None
    if array.size == 0:
        raise InputError(f"{name} is empty; give one number for each degree of freedom")
    return np.atleast_1d(array)


def broadcast(value: Any, name: str, shape: tuple[int, ...]) -> Array:
    """One number for each coordinate, as a row: of a number for all of them, or of an array that can be broadcast to the shape of q0.

    Raises
    ------
    InputError
        If it has another shape.
    """
    array = of_any_shape(value, name)
    try:
        return np.broadcast_to(array, shape).ravel()
    except ValueError:
        raise InputError(f"{name} has the shape {array.shape} and q0 {shape}; give one number for each, or a single number") from None


def shaped(rows: Any, shape: tuple[int, ...], per_sample: bool) -> Any:
    """States in the shape of q0, with the samples as the first axis unless it is one state. A view, if the library has views."""
    return rows.reshape(shape if per_sample else (rows.shape[0], *shape))


class Shaped:
    """A function of states in the shape of q0, as a function of rows: a step, another function of q and p, or a loop.

    Parameters
    ----------
    step : callable
        The function.
    shape : tuple of int
        The shape of q0.
    per_sample : bool
        Whether it takes one state.
    make : bool
        Whether it is a factory of such functions.
    states : tuple of int
        The places of its arguments that are arrays of states.
    """

    def __init__(
        self, step: Callable[..., Any], shape: tuple[int, ...], per_sample: bool, *, make: bool = False, states: tuple[int, ...] = (0, 1)
    ) -> None:
        self.step, self.shape, self.per_sample, self.make, self.states = step, shape, per_sample, make, states
        self.__name__ = str(getattr(step, "__name__", type(step).__name__))

    def __call__(self, *arguments: Any) -> Any:
        if self.make:
            return Shaped(self.step(*arguments), self.shape, self.per_sample)
        given = [
            shaped(argument, self.shape, self.per_sample) if place in self.states else argument
            for place, argument in enumerate(arguments)
        ]
        found = self.step(*given)
        if isinstance(found, tuple | list):
            samples = () if self.per_sample else arguments[0].shape[:1]
            return tuple(self._rows(array, samples) for array in found)
        return found

    def _rows(self, array: Any, samples: tuple[int, ...]) -> Any:
        """An array of states as rows; arrays of another shape stay as they are, and are refused later."""
        if tuple(getattr(array, "shape", ())) == (*samples, *self.shape):
            return array.reshape((*samples, math.prod(self.shape)))
        return array
