"""Steps made of named parts."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from ._errors import InputError

__all__ = ["Composition", "compose"]

#: A part of a step: its name and its function.
Part = tuple[str, Callable[..., Any]]


class Composition:
    """Maps one after the other, each with a name: what `compose` returns.

    `check` takes a composition as a step. A composition can also be called. If `check` finds a defect, it tests each part.
    """

    def __init__(self, parts: Iterable[Part], has_step_size: bool = True) -> None:
        self.parts = list(parts)
        self.has_step_size = has_step_size
        self.__name__ = f"{len(self.parts)} parts"

    def __call__(self, q: Any, p: Any, *h: float) -> tuple[Any, Any]:
        """All parts, the first to be applied first."""
        for number in range(len(self.parts)):
            q, p = self._advanced(number, q, p, *h)
        return q, p

    def part(self, number: int) -> Callable[..., Any]:
        """One part as a separate step.

        Parameters
        ----------
        number : int
            Its number, from 0.

        Returns
        -------
        callable
            A step as `check` takes it.
        """
        return lambda q, p, *h: self._advanced(number, q, p, *h)

    def without_step_size(self) -> Composition:
        """The same for parts that get no step size.

        Returns
        -------
        Composition
            The composition of ``f(q, p)``.
        """
        return Composition(self.parts, has_step_size=False)

    def _advanced(self, number: int, q: Any, p: Any, *h: float) -> tuple[Any, Any]:
        name, function = self.parts[number]
        try:
            result = function(q, p, *h) if self.has_step_size else function(q, p)
        except Exception as error:
            error.add_note(f"in part {number} ({name})")
            raise
        if result is None:
            return q, p
        if not (isinstance(result, tuple | list) and len(result) == 2):
            kind = type(result).__name__
            raise TypeError(f"part {number} ({name}) returned an object of type {kind}; return q and p, or change both in place and return None")
        q, p = result
        return q, p

    def __repr__(self) -> str:
        names = [name for name, _ in self.parts]
        shown = ", ".join(names if len(names) <= 4 else [*names[:3], "…", names[-1]])
        return f"Composition({shown})"


def compose(*parts: Part) -> Composition:
    """Compose a step of named parts.

    Parameters
    ----------
    *parts : (str, callable)
        The name of each part, such as a lattice element, and its function: ``f(q, p, h)`` as `check` takes a step, or
        ``f(q, p)`` for maps without a step size. The first is applied first.

    Returns
    -------
    Composition
        The whole step. If it changes loop integrals, `check` sends one more loop through all parts, and reports which of them do.
        The cost does not depend on the number of parts.

    Raises
    ------
    InputError
        If the parts are empty, or a part is not a pair of a name and a function.

    Examples
    --------
    >>> import numpy as np, symplint
    >>> def drift(q, p, h):
    ...     q += h * p
    >>> def kick(q, p, h):
    ...     p -= h * np.sin(q)
    >>> def friction(q, p, h):
    ...     p *= 1 - 0.01 * h
    >>> step = symplint.compose(("drift", drift), ("kick", kick), ("friction", friction))
    >>> report = symplint.check(step, [1.0], [0.5])
    >>> next(sentence for sentence in report.sentences if "substeps" in sentence).split(";")[0]
    'Of the 3 substeps at h = 0.5, substep 3 (friction) changes the loop integral by -5.00e-3'
    """
    if not parts:
        raise InputError("no parts are given; give pairs of a name and a function")
    for number, part in enumerate(parts):
        if not (isinstance(part, tuple | list) and len(part) == 2):
            raise InputError(f"part {number} is {part!r}; give a pair of a name and a function")
        name, function = part
        if not isinstance(name, str):
            raise InputError(f"the name of part {number} is {name!r}; give a text")
        if not callable(function):
            raise InputError(f"part {number} ({name}) is an object of type {type(function).__name__}; give a function")
    return Composition((name, function) for name, function in parts)
