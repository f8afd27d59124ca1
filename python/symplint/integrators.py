"""The integrators of the library, by name.

Each is a function of a system of `symplint.systems` that takes the keys of the section ``[integrator]`` of a
configuration as keyword arguments, and returns an `Integrator`: ``symplint.integrators.strang(system)``, say. A hyphen in
a name is an underscore here.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy.typing as npt

from . import _native
from ._arrays import Array, numbers
from ._catalogue import Argument, choice, docstring, sentence, signature
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
    """The default integrator of a system; of a system that is a map, the map itself.

    Parameters
    ----------
    system : System
        One of `symplint.systems`.

    Returns
    -------
    Integrator
        One step of the method.
    """
    return Integrator(None, system, {})


def __dir__() -> list[str]:
    # Without what the module imports.
    return [name for name in __all__ if name not in ("Integrator", "of_system")]


#: Options of methods that solve equations.
OF_SOLVER = [
    choice("solver", ["fixed-point", "newton"], 'solver of the equations, "fixed-point" if left out; some methods have no other'),
    Argument("tolerance", "float | None", "float", None, "tolerance of the solver, rounding error if left out"),
    Argument("max_iterations", "int | None", "int", None, "iterations after which the solver fails, 1000 if left out"),
    Argument("iterations", "int | None", "int", None, "fixed number of iterations instead of a tolerance"),
]
#: Deliberate faults, for tests.
FAULTS = [
    Argument("damping", "float | None", "float", None, "deliberate fault: multiplies momenta by exp(-damping h) after the step"),
    choice("precision", ["single", "double"], 'deliberate fault: "single" rounds states before and after the step'),
]
SYSTEM = inspect.Parameter("system", inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation="System")


def _maker(name: str, summary: str, variants: list[str], is_implicit: bool, after: str = "") -> Callable[..., Integrator]:
    def make(system: System, **keys: Any) -> Integrator:
        return Integrator(name, system, keys)

    arguments = [choice("variant", variants, "form of the method", default=variants[0])] if len(variants) > 1 else []
    arguments += [*(OF_SOLVER if is_implicit else []), *FAULTS]
    make.__name__ = make.__qualname__ = name.replace("-", "_")
    make.__signature__ = signature([SYSTEM], arguments, "Integrator")  # type: ignore[attr-defined]
    before = "system : System\n    One of `symplint.systems`."
    text = f"The integrator {name}: {sentence(summary, capital=False)}"
    make.__doc__ = docstring(text, arguments, "Integrator", "One step of the method.", before, after)
    return make


def _add(function: Callable[..., Integrator]) -> None:
    globals()[function.__name__] = function
    __all__.append(function.__name__)


_KNOWN = {}
for _name, _summary, _reference, _variants, _is_implicit in _native.catalogue()["integrators"]:
    _KNOWN[_name] = _variants, _is_implicit
    _add(_maker(_name, _summary, _variants, _is_implicit, f"\nReferences\n----------\n{_reference}\n" if _reference else ""))
for _name, _integrator, _variants in _native.catalogue()["aliases"]:
    _of_integrator, _is_implicit = _KNOWN[_integrator]
    _form = f" in the form {_variants[0]}" if _variants else ""
    _add(_maker(_name, f"another name for `{_integrator.replace('-', '_')}`{_form}", _variants or _of_integrator, _is_implicit))
