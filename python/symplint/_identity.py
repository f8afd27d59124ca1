"""What identifies the step of a run: the source text of its module, and the key of the user."""

from __future__ import annotations

import functools
import hashlib
import inspect
import linecache
import os
import sys
import types
from typing import Any

from ._errors import InputError


def identity(functions: dict[str, Any], key: str | None) -> dict[str, Any]:
    """The SHA-256 of the source text of each module that defines one of the functions, and the key."""
    if key is not None and not isinstance(key, str):
        raise InputError(f"key is an object of type {type(key).__name__}; give a string")
    found = {}
    for name, function in functions.items():
        if function is not None:
            definition = _definition(function)
            module = str(getattr(definition, "__module__", None))
            text, whole = _source(definition), _source(sys.modules.get(module))
            if text is not None:
                # The module of a notebook has no text.
                place = module if whole is not None else f"{module}.{definition.__qualname__}"
                found[place] = hashlib.sha256((whole or text).encode()).hexdigest()[:16]
            elif key is None:
                message = f"run_dir is given, and the source text of {name} cannot be read"
                raise InputError(f'{message}; identify it by a text of yours, as in key="version 2, friction 0.1"')
    return {"source": found, "key": key}


def _definition(function: Any) -> Any:
    """The function or class that has a source text."""
    if isinstance(function, functools.partial):
        return _definition(function.func)
    function = inspect.unwrap(function)
    if isinstance(function, types.MethodType):
        return type(function.__self__)
    return function if isinstance(function, type) or hasattr(function, "__qualname__") else type(function)


def _source(value: Any) -> str | None:
    file = getattr(getattr(value, "__code__", None), "co_filename", None)
    if file is not None and not (os.path.exists(file) or file in linecache.cache):
        # Code that `exec` ran: inspect finds the text of another file.
        return None
    try:
        return inspect.getsource(value)
    except (OSError, TypeError):
        return None
