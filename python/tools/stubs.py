"""Writes systems.pyi and integrators.pyi: their functions are made of the catalogue of the library.

Run it with ``python python/tools/stubs.py`` after a system, a key or an integrator was added. With ``--check`` it writes
nothing, and fails if the files differ.
"""

import argparse
import inspect
import json
import sys
from pathlib import Path
from typing import Any

from symplint import integrators, systems

FOLDER = Path(__file__).parent.parent / "symplint"
NOTE = "# Made by tools/stubs.py.\n"

SYSTEMS = """
from collections.abc import Mapping
from typing import Any, Literal

import numpy.typing as npt

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
from typing import Any, Literal

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


def definition(function: Any) -> str:
    """A function as a stub has it, with the annotations of its signature as they are."""
    signature = inspect.signature(function)
    arguments = []
    for argument in signature.parameters.values():
        if argument.kind is argument.KEYWORD_ONLY and "*" not in arguments:
            arguments.append("*")
        default = "" if argument.default is argument.empty else f" = {json.dumps(argument.default)}".replace("null", "None").replace("false", "False")
        arguments.append(f"{argument.name}: {argument.annotation}{default}")
    return f"def {function.__name__}({', '.join(arguments)}) -> {signature.return_annotation}: ...\n"


def stub(template: str, module: Any) -> str:
    names = dir(module)
    return header(template, module.__all__) + "".join(definition(getattr(module, name)) for name in names)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    for name, text in (("systems.pyi", stub(SYSTEMS, systems)), ("integrators.pyi", stub(INTEGRATORS, integrators))):
        path = FOLDER / name
        if not check:
            path.write_text(text, encoding="utf-8")
        elif path.read_text(encoding="utf-8") != text:
            sys.exit(f"{path} differs from the catalogue: run python python/tools/stubs.py")


if __name__ == "__main__":
    main()
