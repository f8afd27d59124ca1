"""Whether a function is the one that a stopped run called."""

from __future__ import annotations

import dis
import functools
import hashlib
import inspect
import types
from collections.abc import Iterator
from typing import Any

import numpy as np

#: Numbers and texts up to this length stand for themselves.
LONGEST = 40


def fingerprint(function: Any) -> dict[str, Any]:
    """What tells a function from another one: a digest of its code, and the numbers and texts that it refers to by name.

    The same of functions of the same package that it calls. Names that the code itself assigns are left out, as counters
    are. Not included: other objects, files, and compiled code.
    """
    seen = _Seen(function)
    seen.add("", function)
    return {"code": seen.code.hexdigest(), "values": seen.values}


class _Seen:
    """What was found so far."""

    def __init__(self, function: Any) -> None:
        self.package = _package(function)
        self.code = hashlib.sha256()
        self.values: dict[str, str] = {}
        self.known: set[int] = set()

    def add(self, name: str, value: Any, unless: frozenset[str] = frozenset()) -> None:
        """A value that is referred to by a name; of an object, attributes `unless` the code assigns them."""
        if (text := _text(value)) is not None:
            self.values[name] = text
            return
        if id(value) in self.known:
            return
        self.known.add(id(value))
        if isinstance(value, list | tuple):
            for k, item in enumerate(value):
                self.add(f"{name}[{k}]", item)
        elif isinstance(value, dict):
            for key, item in value.items():
                self.add(f"{name}[{key!r}]", item)
        elif isinstance(value, functools.partial):
            self.add(name, value.func)
            self.add(_join(name, "args"), value.args)
            self.add(_join(name, "keywords"), value.keywords)
        elif isinstance(value, types.MethodType):
            self._add_function(name, value.__func__)
            self._add_attributes(name, value.__self__, unless | _assigned(value.__func__))
        elif isinstance(value, types.FunctionType):
            self._add_function(name, value)
        elif isinstance(value, type | types.ModuleType | types.BuiltinFunctionType):
            pass
        elif isinstance(call := getattr(type(value), "__call__", None), types.FunctionType):
            self._add_function(name, call)
            self._add_attributes(name, value, unless | _assigned(call))

    def _add_function(self, name: str, function: types.FunctionType) -> None:
        if _package(function) != self.package:
            self.code.update(f"{function.__module__}.{function.__qualname__}\0".encode())
            return
        try:
            source = inspect.getsource(function)
        except (OSError, TypeError):
            source = function.__code__.co_code.hex()
        self.code.update(f"{source}\0".encode())
        for kind, default in (("defaults", function.__defaults__), ("defaults", function.__kwdefaults__)):
            self.add(_join(name, kind), default)
        assigned = _assigned(function)
        cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
        # A cell is empty before the variable is assigned.
        outer = {other: cell.cell_contents for other, cell in cells if cell != types.CellType()}
        used = {other: function.__globals__.get(other) for other in _named(function, ("LOAD_GLOBAL", "LOAD_NAME"))}
        for values in (outer, used):
            for other in sorted(values):
                if other not in assigned:
                    self.add(_join(name, other), values[other], assigned)

    def _add_attributes(self, name: str, value: Any, unless: frozenset[str]) -> None:
        attributes = getattr(value, "__dict__", {})
        for attribute in sorted(attributes):
            held = attributes[attribute]
            if attribute not in unless and (_text(held) is not None or isinstance(held, list | tuple)):
                self.add(_join(name, attribute), held)


def _join(name: str, other: str) -> str:
    return f"{name}.{other}" if name else other


def _package(function: Any) -> str:
    module = getattr(function, "__module__", None) or getattr(type(function), "__module__", None)
    return str(module).split(".", 1)[0]


def _text(value: Any) -> str | None:
    """A number, a text or an array of numbers in a few characters that no other one has; None of anything else."""
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        digest = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return f"{value.dtype} array {value.shape} {digest[:16]}"
    if value is None or isinstance(value, bool | int | float | complex | str | bytes | np.generic):
        text = repr(value)
        return text if len(text) <= LONGEST else f"{text[:16]}… {hashlib.sha256(text.encode()).hexdigest()[:16]}"
    return None


def _named(function: types.FunctionType, instructions: tuple[str, ...]) -> frozenset[str]:
    """What instructions of these kinds name in the code of a function, and in that of functions inside it."""

    def names(code: types.CodeType) -> Iterator[str]:
        for instruction in dis.get_instructions(code):
            if instruction.opname in instructions:
                yield str(instruction.argval)
        for constant in code.co_consts:
            if isinstance(constant, types.CodeType):
                yield from names(constant)

    return frozenset(names(function.__code__))


def _assigned(function: types.FunctionType) -> frozenset[str]:
    """Names of global and outer variables and of attributes that the code of a function assigns."""
    return _named(function, ("STORE_GLOBAL", "STORE_DEREF", "STORE_ATTR"))
