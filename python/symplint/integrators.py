"""The integrators of the library, by name.

Each is a function of a system of `symplint.systems` that takes the keys of the section ``[integrator]`` of a
configuration as keyword arguments, and returns an `Integrator`: ``symplint.integrators.strang(system)``, say. A hyphen in
a name is an underscore here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy.typing as npt

from . import _native
from ._arrays import Array, numbers
from ._errors import InputError
from .systems import System

__all__ = ["Integrator", "of_system"]


class Integrator:
    """One step of a method for a system.

    It is called as ``integrator(q, p, h)`` with arrays of shape (samples, dof) or, of one state, (dof,), and returns new
    ones. Passed to `symplint.check` it runs without Python.
    """

    def __init__(self, name: str | None, system: System, keys: dict[str, Any]) -> None:
        if not isinstance(system, System):
            raise InputError(f"the system is an object of type {type(system).__name__}; take one of symplint.systems")
        self._native = _native.Integrator(name, system._native, keys)
        self._system = system

    @property
    def name(self) -> str:
        """Its name, with variant."""
        return self._native.name

    @property
    def system(self) -> System:
        """The system that it advances."""
        return self._system

    @property
    def dof(self) -> int:
        """Degrees of freedom."""
        return self._native.dof

    def __call__(self, q: npt.ArrayLike, p: npt.ArrayLike, h: float) -> tuple[Array, Array]:
        try:
            rows_q, rows_p = numbers(q, "q"), numbers(p, "p")
        except (TypeError, ValueError) as error:
            raise InputError(str(error)) from None
        shape = rows_q.shape
        if shape != rows_p.shape or rows_q.ndim not in (1, 2) or shape[-1] != self.dof:
            raise InputError(
                f"q has the shape {shape} and p the shape {rows_p.shape}; "
                f"give both the shape (samples, {self.dof}), or ({self.dof},) for one state"
            )
        new_q, new_p = self._native.advance(rows_q.reshape(-1, self.dof), rows_p.reshape(-1, self.dof), float(h))
        return new_q.reshape(shape), new_p.reshape(shape)

    def __repr__(self) -> str:
        return f"<symplint integrator {self.name} for {self.system.name}>"


def of_system(system: System) -> Integrator:
    """The default integrator of a system; of a system that is a map, the map itself."""
    return Integrator(None, system, {})


def _maker(name: str, doc: str) -> Callable[..., Integrator]:
    def make(system: System, **keys: Any) -> Integrator:
        return Integrator(name, system, keys)

    make.__name__ = make.__qualname__ = name.replace("-", "_")
    make.__doc__ = doc + "\n"
    return make


def _add(name: str, doc: str) -> None:
    function = _maker(name, doc)
    globals()[function.__name__] = function
    __all__.append(function.__name__)


for _name, _summary, _variants in _native.catalogue()["integrators"]:
    _choices = f"\n\nParameters\n----------\nvariant : one of {', '.join(_variants)}" if _variants else ""
    _add(_name, _summary + _choices)
for _name, _integrator in _native.catalogue()["aliases"]:
    _add(_name, f"Another name for `{_integrator.replace('-', '_')}`, or for one of its variants.")
