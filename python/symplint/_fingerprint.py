"""Whether a function is the one that a stopped run called."""

from __future__ import annotations

import array
import functools
import hashlib
import importlib
import importlib.util
import inspect
import json
import os
import pathlib
import sys
import sysconfig
import types
from collections import deque
from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np

from ._code import GROWN, attributes, changes, imports, named, texts
from .integrators import Integrator
from .systems import System

#: Numbers and texts up to this length stand for themselves.
LONGEST = 40
#: Values that are told by their names; further ones are in the digest alone.
MOST_VALUES = 1000
#: Objects that are looked into.
MOST_OBJECTS = 100_000

#: What others than Python's own functions hold of a function of the user: `functools.wraps` and caches, numba, NumPy.
WRAPPED = ("__wrapped__", "py_func", "pyfunc")
#: Objects of the standard library that hold values of the user. Others, as locks and files, are different in every run.
HOLDERS = ("types", "argparse", "collections")
PRINTED = (type(None), type(...), bool, int, float, complex, str, bytes, bytearray, Decimal, Fraction)
CONTAINERS = (list, tuple, dict, set, frozenset, deque, types.MappingProxyType)
#: What these do is done before a step is taken.
BEFORE = ("__init__", "__new__", "__post_init__", "__setstate__")


def fingerprint(function: Any) -> dict[str, Any]:
    """What tells a function from another one: a digest of its code, and the numbers and texts that it refers to.

    The same of everything of the user that it names: functions, classes and objects with what they hold, attributes of
    modules. What the code itself changes is left out, as counters are. Not included: what files hold, compiled code, the
    code of the standard library and of installed packages, but for that of the function, and names that are made up
    while the code runs.
    """
    seen = _Seen(_Own(function), {})
    seen.look("", function)
    return seen.found()


class _Own:
    """Tells modules of the user from those of Python and of installed packages."""

    def __init__(self, function: Any) -> None:
        paths = {sysconfig.get_path(name) for name in ("stdlib", "platstdlib")} | {os.path.dirname(__file__)}
        self._others = tuple(os.path.realpath(path) + os.sep for path in paths if path)
        # A step may itself be installed.
        self._package = _root(_module(_unwrapped(function)))

    def has_module(self, name: str) -> bool:
        """Whether a module is the user's."""
        root = _root(name)
        if root == "symplint" or root in sys.stdlib_module_names:
            # Of Python, but for the program itself.
            return root == "__main__"
        module = sys.modules.get(name)
        if root == self._package or module is None:
            return True
        # A module that was made by hand has neither, and a package may have no file.
        file = getattr(module, "__file__", None)
        return all(self.has_file(file) for file in ([file] if file else getattr(module, "__path__", ())))

    def has(self, value: Any) -> bool:
        """Whether a function or class is the user's."""
        code = getattr(value, "__code__", None)
        if isinstance(code, types.CodeType) and not code.co_filename.startswith("<"):
            # `functools.wraps` gives functions the module of others.
            return self.has_file(code.co_filename) or _root(value.__globals__.get("__name__", "")) == self._package
        return self.has_module(_module(value))

    def has_file(self, file: str) -> bool:
        """Whether a file is the user's."""
        path = os.path.realpath(file)
        parts = pathlib.PurePath(path).parts
        installed = "site-packages" in parts or "dist-packages" in parts
        return not installed and not path.startswith(self._others)


class _Seen:
    """What was found so far."""

    def __init__(self, own: _Own, known: dict[int, tuple[str, Any]]) -> None:
        self.own = own
        self.code = hashlib.sha256()
        self.values: dict[str, str] = {}
        #: The name of each object that was looked into. Objects that were made on the way are kept: another one may be
        #: in their place else.
        self.known = known
        #: Attributes that the code named so far.
        self.named: set[str] = set()
        self.waiting: deque[tuple[str, str, Any, frozenset[str]]] = deque()
        #: Modules of the user.
        self.modules: list[tuple[str, str, types.ModuleType, frozenset[str]]] = []

    def look(self, name: str, value: Any) -> None:
        """Looks at a value, and at all that it holds and refers to."""
        self._add(name, "", value, frozenset())
        done: set[tuple[str, str]] = set()
        while self.waiting:
            self._look(*self.waiting.popleft())
            if not self.waiting:
                # Of modules, what all code names that was found so far.
                for of_module in self.modules:
                    self._add_named(*of_module, done)

    def found(self) -> dict[str, Any]:
        return {"code": self.code.hexdigest(), "values": self.values}

    def _note(self, *texts: str) -> None:
        self.code.update("\0".join((*texts, "\0")).encode("utf-8", "surrogatepass"))

    def _add(self, name: str, path: str, value: Any, unless: frozenset[str]) -> None:
        """A value of a name, by a path from a variable or an object on, `unless` the code changes what is there."""
        if path in unless or (isinstance(value, CONTAINERS) and path + GROWN in unless):
            return
        if isinstance(value, np.ndarray) and any(other.startswith(path + "[") for other in unless):
            return
        if (text := _text(value)) is None:
            self.waiting.append((name, path, value, unless))
        else:
            self._add_text(name, text)

    def _add_text(self, name: str, text: str) -> None:
        # A global variable may have the name of an attribute.
        if name not in self.values and len(self.values) < MOST_VALUES:
            self.values[name] = text
        else:
            self._note(name, text)

    def _look(self, name: str, path: str, value: Any, unless: frozenset[str]) -> None:
        # Which of two equal tuples it is makes no difference.
        if id(value) in self.known and not isinstance(value, tuple | frozenset):
            self._note(name, self.known[id(value)][0])
            return
        if len(self.known) >= MOST_OBJECTS:
            return
        self.known[id(value)] = (name, value)
        if isinstance(value, types.MethodType):
            self.named.add(value.__name__)
            self._add(name, "", value.__func__, frozenset())
            self._add(name, "", value.__self__, frozenset())
        elif isinstance(value, types.FunctionType):
            self._add_function(name, value)
        elif isinstance(value, type):
            self._add_class(name, path, value, unless)
        elif isinstance(value, types.ModuleType):
            self._note(value.__name__)
            if self.own.has_module(value.__name__):
                self.modules.append((name, path, value, unless))
        elif isinstance(value, Integrator | System):
            parts = (value.system, value) if isinstance(value, Integrator) else (value,)
            self._note(name, *(part._native.config() for part in parts))
        else:
            self._add_object(name, path, value, unless)

    def _add_function(self, name: str, function: types.FunctionType) -> None:
        code = function.__code__
        cells = zip(code.co_freevars, function.__closure__ or (), strict=True)
        # A cell is empty before the variable is assigned.
        outer = {other: cell.cell_contents for other, cell in cells if cell != types.CellType()}
        if not self.own.has(function):
            self._note(_module(function), function.__qualname__)
            # A decorator of an installed package has the function of the user.
            held = outer | {other: value for other, value in vars(function).items() if other in WRAPPED}
            self._add_all(name, {other: value for other, value in held.items() if callable(value)}, frozenset())
            return
        self._note(*texts(code))
        self.named |= attributes(code)
        changed = changes(code)
        globals_, names = function.__globals__, named(code, "LOAD_GLOBAL", "LOAD_NAME")
        used = {other: globals_[other] for other in names if other in globals_}
        for defaults in (function.__defaults__ or (), function.__kwdefaults__ or {}):
            self._add(_join(name, "defaults"), "", defaults, frozenset())
        for held in (outer, used, self._imported(function)):
            self._add_all(name, held, changed)
        # It may count its calls itself, by its name.
        own = frozenset(path.removeprefix(f"{code.co_name}.") for path in changed)
        self._add_all(name, dict(vars(function)), own)

    def _add_all(self, name: str, values: dict[str, Any], unless: frozenset[str]) -> None:
        for other in sorted(values):
            self._add(_join(name, other), other, values[other], unless)

    def _imported(self, function: types.FunctionType) -> dict[str, Any]:
        """Modules of the user that a function imports."""
        found = {}
        for module in imports(function):
            try:
                spec = importlib.util.find_spec(module)
                if spec is not None and spec.origin is not None and self.own.has_file(spec.origin):
                    found[module] = importlib.import_module(module)
            except Exception:
                # The function may never come there.
                continue
        return found

    def _add_class(self, name: str, path: str, kind: type, unless: frozenset[str]) -> None:
        self._note(_module(kind), kind.__qualname__)
        if not self.own.has(kind):
            return
        for base in kind.__bases__:
            self._add(_join(name, base.__name__), "", base, frozenset())
        unless = frozenset(
            other.removeprefix(f"{holder}.") for holder in (path, kind.__name__) for other in unless | self._changed(kind)
        )
        for other, value in list(vars(kind).items()):
            part = _join(name, other)
            if isinstance(value, property):
                for function in (value.fget, value.fset, value.fdel):
                    self._add(part, "", function, unless)
            elif isinstance(value, staticmethod | classmethod):
                self._add(part, "", value.__func__, unless)
            elif isinstance(value, functools.cached_property):
                self._add(part, "", value.func, unless)
            elif isinstance(value, types.FunctionType) or not other.startswith(("__", "_abc_")):
                self._add(part, other, value, unless)

    def _add_named(
        self, name: str, path: str, module: types.ModuleType, unless: frozenset[str], done: set[tuple[str, str]]
    ) -> None:
        """Attributes of a module that the code names, but those that are done."""
        held = vars(module)
        for other in sorted(self.named & held.keys()):
            if (module.__name__, other) not in done:
                done.add((module.__name__, other))
                self._add(_join(name, other), _join(path, other), held[other], unless)

    def _add_object(self, name: str, path: str, value: Any, unless: frozenset[str]) -> None:
        kind = type(value)
        self._note(_module(kind), kind.__qualname__, _title(value))
        self._add_items(name, path, value, unless)
        if self.own.has(kind):
            self._add(_join(name, "class"), "", kind, frozenset())
            held, unless = _attributes(value), unless | {_join(path, other) for other in self._changed(kind)}
        elif _root(_module(kind)) in sys.stdlib_module_names:
            held = _of_python(value)
        elif not isinstance(value, np.ndarray) and (numbers := _as_array(value)) is not None:
            held = {"": numbers}
        else:
            held = _attributes(value) | {other: getattr(value, other) for other in WRAPPED if _has(value, other)}
        for other in sorted(held):
            self._add(_join(name, other), _join(path, other), held[other], unless)

    def _add_items(self, name: str, path: str, value: Any, unless: frozenset[str]) -> None:
        if isinstance(value, dict | types.MappingProxyType):
            for k, (key, item) in enumerate(list(value.items())):
                text = _text(key)
                if text is None:
                    text = f"#{k}"
                    self._add(f"{name}[{text}].key", "", key, frozenset())
                self._add(f"{name}[{text}]", f"{path}[{text}]", item, unless)
        elif isinstance(value, list | tuple | deque):
            for k, item in enumerate(value):
                self._add(f"{name}[{k}]", f"{path}[{k}]", item, unless)
        elif isinstance(value, np.ndarray):
            # Of objects.
            self._add(name, path, value.tolist(), unless)
        elif isinstance(value, set | frozenset):
            self._note(name, *sorted(self._alone(item) for item in value))
        elif isinstance(value, str | bytes | int | float | complex):
            # Of a class of its own, which may print it in another way.
            base = next(base for base in (str, bytes, int, float, complex) if isinstance(value, base))
            self._add_text(name, base.__repr__(value))

    def _alone(self, value: Any) -> str:
        """What is found of an item of a set, which has no place in it."""
        seen = _Seen(self.own, dict(self.known))
        seen.look("", value)
        return json.dumps(seen.found(), sort_keys=True)

    def _changed(self, kind: type) -> frozenset[str]:
        """What methods of a class change that the code named so far, or that they name."""
        methods = {other: value for base in reversed(kind.__mro__) for other, value in vars(base).items()}
        found = {other for other, value in methods.items() if isinstance(value, functools.cached_property)}
        waiting = [other for other in methods if other in self.named or other == "__call__"]
        taken = set(BEFORE)
        while waiting:
            name = waiting.pop()
            function = methods.get(name)
            function = getattr(function, "__func__", getattr(function, "fget", function))
            if name not in taken and isinstance(function, types.FunctionType) and self.own.has(function):
                taken.add(name)
                found |= changes(function.__code__)
                waiting += attributes(function.__code__)
        return frozenset(found)


def _join(name: str, other: str) -> str:
    return f"{name}.{other}" if name and other else name or other


def _module(value: Any) -> str:
    return str(getattr(value, "__module__", None) or getattr(type(value), "__module__", None))


def _root(module: str) -> str:
    return module.split(".", 1)[0]


def _unwrapped(function: Any) -> Any:
    """The function of the user in what was made of it."""
    for _ in range(LONGEST):
        if isinstance(function, functools.partial):
            function = function.func
        elif _root(_module(type(function))) == "symplint" and hasattr(function, "step"):
            function = function.step
        elif wrapped := [other for other in WRAPPED if _has(function, other)]:
            function = getattr(function, wrapped[0])
        elif isinstance(function, types.MethodType):
            return type(function.__self__)
    return function


def _of_python(value: Any) -> dict[str, Any]:
    """What an object of the standard library holds of the user."""
    if isinstance(value, functools.partial | functools.partialmethod):
        return {"func": value.func, "args": value.args, "keywords": value.keywords}
    if isinstance(value, types.BuiltinFunctionType):
        # A method of an object, or of a module.
        return {"self": value.__self__}
    if _root(_module(type(value))) in HOLDERS:
        return _attributes(value)
    return {other: getattr(value, other) for other in WRAPPED if _has(value, other)}


def _title(value: Any) -> str:
    """The name of a function that is compiled."""
    name = getattr(value, "__name__", "") if callable(value) else ""
    return name if isinstance(name, str) else ""


def _has(value: Any, name: str) -> bool:
    """Whether it has a function of this name. Some objects make up any attribute that they are asked for."""
    try:
        inspect.getattr_static(value, name)
        return callable(getattr(value, name))
    except Exception:
        return False


def _attributes(value: Any) -> dict[str, Any]:
    """Attributes of an object, in its dictionary or in slots."""
    slots = (slot for base in type(value).__mro__ for slot in _slots(base))
    found = {slot: getattr(value, slot) for slot in slots if hasattr(value, slot)}
    held = getattr(value, "__dict__", {})
    return found | ({str(key): item for key, item in held.items()} if isinstance(held, dict) else {})


def _slots(kind: type) -> Iterator[str]:
    descriptors = vars(kind).items() if "__slots__" in vars(kind) else ()
    return (name for name, value in descriptors if isinstance(value, types.MemberDescriptorType))


def _as_array(value: Any) -> np.ndarray | None:
    """The numbers of an array of another library; None of anything else."""
    if not hasattr(type(value), "__array__"):
        return None
    try:
        # Parameters of torch are bound to their gradients.
        found = np.asarray(value.detach() if _has(value, "detach") else value)
    except Exception:
        return None
    return found


def _text(value: Any) -> str | None:
    """A number, a text or an array of numbers in a few characters that no other one has; None of anything else."""
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        digest = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return f"{value.dtype} array {value.shape} {digest[:16]}"
    if isinstance(value, array.array):
        return _text(np.asarray(value))
    if isinstance(value, pathlib.PurePath):
        return _text(str(value))
    # All of them print what they are.
    if type(value) in PRINTED or isinstance(value, np.generic):
        text = repr(value)
        return text if len(text) <= LONGEST else f"{text[:16]}… {hashlib.sha256(text.encode()).hexdigest()[:16]}"
    return None
