"""Writes systems.pyi and integrators.pyi: their functions are made of the catalogue of the native module.

Run it with ``python python/tools/stubs.py`` after a system, a key or an integrator was added. With ``--check`` it writes
nothing, and fails if the files differ.
"""

import argparse
import sys
from pathlib import Path

from symplint import _native

FOLDER = Path(__file__).parent.parent / "symplint"
NOTE = "# Made by tools/stubs.py.\n"

SYSTEMS = """
from typing import Any

from . import _native as native
from ._arrays import Array

__all__ = [{names}]

class System:
    _native: native.System
    def __init__(self, native: native.System) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def dof(self) -> int: ...
    @property
    def q0(self) -> Array: ...
    @property
    def p0(self) -> Array: ...

"""

INTEGRATORS = """
from typing import Any

import numpy.typing as npt

from . import _native as native
from ._arrays import Array
from .systems import System

__all__ = [{names}]

class Integrator:
    _native: native.Integrator
    def __init__(self, name: str | None, system: System, keys: dict[str, Any]) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def system(self) -> System: ...
    @property
    def dof(self) -> int: ...
    def __call__(self, q: npt.ArrayLike, p: npt.ArrayLike, h: float) -> tuple[Array, Array]: ...

def of_system(system: System) -> Integrator: ...
"""


def header(template: str, names: list[str]) -> str:
    listed = "".join(f'\n    "{name}",' for name in names) + "\n"
    return NOTE + template.lstrip("\n").replace("{names}", listed)


def systems() -> str:
    found = [(name.replace("-", "_"), keys) for name, _, keys in _native.catalogue()["systems"]]
    lines = [header(SYSTEMS, ["System", *(name for name, _ in found)])]
    for name, keys in found:
        arguments = ", ".join(f"{key}: Any = ..." for key, *_ in keys)
        lines.append(f"def {name}({'*, ' if keys else ''}{arguments}) -> System: ...\n")
    return "".join(lines)


def integrators() -> str:
    catalogue = _native.catalogue()
    names = [name.replace("-", "_") for name, *_ in catalogue["integrators"] + catalogue["aliases"]]
    lines = [header(INTEGRATORS, ["Integrator", "of_system", *names])]
    lines += [f"def {name}(system: System, **keys: Any) -> Integrator: ...\n" for name in names]
    return "".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    for name, text in (("systems.pyi", systems()), ("integrators.pyi", integrators())):
        path = FOLDER / name
        if not check:
            path.write_text(text, encoding="utf-8")
        elif path.read_text(encoding="utf-8") != text:
            sys.exit(f"{path} differs from the catalogue: run python python/tools/stubs.py")


if __name__ == "__main__":
    main()
