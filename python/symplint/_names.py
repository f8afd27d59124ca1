"""Other names of arguments, and groups of them."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import InputError

__all__ = ["Coordinates", "WithArguments", "executor_of", "one_of", "seed_of", "tuple_of"]


@dataclass(frozen=True, kw_only=True)
class Coordinates:
    """What makes the coordinates of a map canonical; `check` also takes each of these as an argument.

    Parameters
    ----------
    period, momentum_period : float or array_like, optional
        Periods of positions and momenta, 0 for those without.
    weight : float or array_like, optional
        The canonical momentum is weight × p: masses, if p are velocities.
    project : callable, optional
        ``project(q, p)`` puts states on the constraint manifold.
    form : callable, optional
        The one-form of non-canonical coordinates.
    casimir : callable or list of callables, optional
        The Casimir functions of a degenerate form.
    mass_matrix : callable or array_like, optional
        ``mass_matrix(q)``, if p are velocities v and the canonical momentum is M(q) v.

    Examples
    --------
    >>> import numpy as np, symplint
    >>> def step(q, v, h):
    ...     v = v - h * np.sin(q - q[:, ::-1]) / [1.0, 3.0]
    ...     return q + h * v, v
    >>> masses = symplint.Coordinates(weight=[1.0, 3.0])
    >>> symplint.check(step, [0.3, 1.0], [0.1, 0.2], coordinates=masses).kind
    'symplectic'
    """

    period: npt.ArrayLike | None = None
    momentum_period: npt.ArrayLike | None = None
    weight: npt.ArrayLike | None = None
    project: Callable[..., Any] | None = None
    form: Callable[..., Any] | None = None
    casimir: Callable[..., Any] | list[Callable[..., Any]] | None = None
    mass_matrix: Callable[..., Any] | npt.ArrayLike | None = None

    def _merged(self, stated: dict[str, Any]) -> dict[str, Any]:
        """These coordinates and what is stated besides, as arguments of `check`."""
        if not isinstance(self, Coordinates):
            raise InputError(f"coordinates is an object of type {type(self).__name__}; give symplint.Coordinates(...)")
        found = dict(stated)
        for of in fields(self):
            value = getattr(self, of.name)
            if value is not None and stated[of.name] is not None:
                raise InputError(f"{of.name} is given twice, in coordinates and by itself; give it once")
            found[of.name] = stated[of.name] if value is None else value
        return found


class WithArguments:
    """A step to which further arguments are passed on."""

    def __init__(self, step: Callable[..., Any], args: tuple[Any, ...]) -> None:
        self.step, self.args = step, args
        self.__name__ = str(getattr(step, "__name__", type(step).__name__))

    def __call__(self, *state: Any) -> Any:
        return self.step(*state, *self.args)


class WithoutStepSize:
    """``step(q, p)`` as a step that is also given a step size."""

    def __init__(self, step: Callable[..., Any]) -> None:
        self.step = step
        self.__name__ = str(getattr(step, "__name__", type(step).__name__))
        self._is_called = self._returns_or_changes = False

    @property
    def is_idle(self) -> bool:
        """Whether all calls returned None and left their arrays unchanged."""
        return self._is_called and not self._returns_or_changes

    def __call__(self, q: Any, p: Any, _: float) -> Any:
        if self._returns_or_changes or not isinstance(q, np.ndarray):
            return self.step(q, p)
        before = q.copy(), p.copy()
        result = self.step(q, p)
        # Two flags that only become true: workers may be threads.
        self._is_called = True
        if result is not None or not (np.array_equal(q, before[0]) and np.array_equal(p, before[1])):
            self._returns_or_changes = True
        return result


def one_of(name: str, value: Any, other: str, alias: Any, default: Any, deprecated: bool = False) -> Any:
    """The value of an argument that has two names; `alias` is None if the other one is not used.

    Raises
    ------
    InputError
        If both are given.
    """
    if alias is None:
        return value
    if value is not default:
        raise InputError(f"both {name} and {other} are given; they are one argument")
    if deprecated:
        warnings.warn(f"{other} is an old name; use {name}", DeprecationWarning, stacklevel=4)
    return alias


def tuple_of(args: Any) -> tuple[Any, ...]:
    """Further arguments of a function.

    Raises
    ------
    InputError
        If they are not a tuple or a list.
    """
    if not isinstance(args, tuple | list):
        raise InputError(f"args is {args!r}; give a tuple, args=({args!r},)")
    return tuple(args)


def seed_of(rng: Any) -> int:
    """The seed of the library that a seed or a generator of numpy stands for."""
    if isinstance(rng, np.random.Generator):
        return int(rng.integers(2**63))
    if isinstance(rng, np.random.SeedSequence | np.random.BitGenerator):
        return int(np.random.default_rng(rng).integers(2**63))
    if isinstance(rng, int | np.integer) and not isinstance(rng, bool):
        return int(rng)
    raise InputError(f"rng is an object of type {type(rng).__name__}; give a whole number or a numpy.random.Generator")


class _Map:
    """An executor made of a function like the built-in `map`."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.map = function


@contextmanager
def executor_of(workers: Any) -> Iterator[Any]:
    """An executor for what `workers` may be: a number of processes, -1 for one each processor; a function like `map`; an executor."""
    if isinstance(workers, bool) or (isinstance(workers, int) and workers < 1 and workers != -1):
        raise InputError(f"workers is {workers}; give a number of processes, 1 or more, or -1 for one for each processor")
    if isinstance(workers, int):
        count = (os.cpu_count() or 1) if workers == -1 else workers
        if count == 1:
            yield None
            return
        with ProcessPoolExecutor(count) as pool:
            yield pool
    elif callable(workers) and not hasattr(workers, "submit") and not hasattr(workers, "map"):
        yield _Map(workers)
    else:
        yield workers
