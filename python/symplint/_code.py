"""What the code of functions is, names, imports and changes."""

from __future__ import annotations

import ast
import dis
import functools
import importlib.util
import inspect
import textwrap
import types
from collections.abc import Iterator
from typing import Any

#: Methods by which lists, sets and queues grow. Those that set values are not here: parameters are set by them, too.
GROW = frozenset({"append", "appendleft", "extend", "add"})
#: What follows a path for which such a method is called.
GROWN = "()"


def texts(code: types.CodeType) -> Iterator[str]:
    """All that a code object does, and nothing of where it stands."""
    yield from (code.co_code.hex(), code.co_exceptiontable.hex(), str(code.co_flags))
    yield from (str(code.co_argcount), str(code.co_posonlyargcount), str(code.co_kwonlyargcount))
    for names in (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars):
        yield " ".join(names)
    for constant in code.co_consts:
        yield from _constant(constant)


def _constant(value: Any) -> Iterator[str]:
    if isinstance(value, types.CodeType):
        yield from texts(value)
    elif isinstance(value, frozenset):
        # In no order.
        yield from sorted(text for item in value for text in _constant(item))
    elif isinstance(value, tuple):
        yield f"{len(value)}"
        for item in value:
            yield from _constant(item)
    else:
        yield repr(value)


def attributes(code: types.CodeType) -> set[str]:
    """What code names, attributes among it."""
    return {name for part in _parts(code) for name in part.co_names}


def named(code: types.CodeType, *kinds: str) -> frozenset[str]:
    """What instructions of these kinds name."""
    found = (instruction for part in _parts(code) for instruction in dis.get_instructions(part))
    return frozenset(str(instruction.argval) for instruction in found if instruction.opname in kinds)


def imports(function: types.FunctionType) -> list[str]:
    """Full names of the modules that a function imports."""
    package = function.__globals__.get("__package__") or ""
    found = set()
    for part in _parts(function.__code__):
        instructions = list(dis.get_instructions(part))
        for k, instruction in enumerate(instructions):
            if instruction.opname == "IMPORT_NAME":
                # The level and the names from the module come before.
                level = instructions[k - 2].argval
                if not level:
                    found.add(str(instruction.argval))
                elif package and isinstance(level, int):
                    found.add(importlib.util.resolve_name("." * level + str(instruction.argval), package))
    return sorted(found)


def _parts(code: types.CodeType) -> Iterator[types.CodeType]:
    """A code object, and those of functions inside it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _parts(constant)


@functools.lru_cache
def changes(code: types.CodeType) -> frozenset[str]:
    """Paths of what code assigns or stores into: ``count``, ``calls[0]``, ``state.steps``, ``log()``.

    Paths of attributes begin with the first one where they are of a local variable, as ``self`` is.
    """
    assigned = named(code, "STORE_GLOBAL", "STORE_DEREF")
    outer = named(code, "LOAD_GLOBAL", "LOAD_NAME", "LOAD_DEREF")
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(code)))
    except (OSError, TypeError, SyntaxError):
        # Without source, attributes alone are known, and not whose.
        return assigned | named(code, "STORE_ATTR")
    return assigned | frozenset(_stored(tree, outer))


def _stored(tree: ast.AST, outer: frozenset[str]) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute | ast.Subscript) and not isinstance(node.ctx, ast.Load):
            if path := _path(node, outer)[0]:
                yield path
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in GROW:
            if path := _path(node.func.value, outer)[0]:
                yield path + GROWN


def _path(node: ast.expr, outer: frozenset[str]) -> tuple[str, bool]:
    """The path of a target, as far as it is known before the code runs, and whether that is all of it."""
    match node:
        case ast.Name(id=name):
            return (name if name in outer else ""), True
        case ast.Attribute(value=value, attr=name):
            path, is_whole = _path(value, outer)
            return (path if not is_whole else f"{path}.{name}" if path else name), is_whole
        case ast.Subscript(value=value, slice=key):
            path, is_whole = _path(value, outer)
            if path and is_whole and isinstance(key, ast.Constant):
                return f"{path}[{key.value!r}]", True
            return path, False
    return "", False
