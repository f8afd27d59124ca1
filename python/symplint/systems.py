"""The systems of the library, by name.

Each is a function that takes the keys of the section ``[system]`` of a configuration as keyword arguments, and returns a
`System`; ``symplint.systems.pendulum()``, say. A hyphen in a name is an underscore here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from . import _native
from ._arrays import Array
from ._catalogue import docstring, of_key, sentence, signature

__all__ = ["System"]


class System:
    """A system with an initial state: the centre of loops."""

    def __init__(self, native: _native.System) -> None:
        self._native = native

    @property
    def name(self) -> str:
        """Its name in configurations."""
        return self._native.name

    @property
    def dof(self) -> int:
        """Degrees of freedom."""
        return self._native.dof

    @property
    def q0(self) -> Array:
        """Initial positions."""
        return self._native.q0

    @property
    def p0(self) -> Array:
        """Initial momenta."""
        return self._native.p0

    def __repr__(self) -> str:
        return repr(self._native)


def __dir__() -> list[str]:
    # Without what the module imports.
    return [name for name in __all__ if name != "System"]


def _maker(name: str, summary: str, keys: list[tuple[str, str | None, str, str, list[str]]]) -> Callable[..., System]:
    def make(**keys: Any) -> System:
        return System(_native.System(name, keys))

    arguments = [of_key(*key) for key in keys]
    make.__name__ = make.__qualname__ = name.replace("-", "_")
    make.__signature__ = signature([], arguments, "System")  # type: ignore[attr-defined]
    text = f"The system {name}: {sentence(summary, capital=False)}"
    make.__doc__ = docstring(text, arguments, "System", "The system with its initial state.")
    return make


for _system in _native.catalogue()["systems"]:
    _function = _maker(*_system)
    globals()[_function.__name__] = _function
    __all__.append(_function.__name__)
