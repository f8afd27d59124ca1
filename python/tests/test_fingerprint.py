"""Steps that were edited are told from those that a stopped run called, and those that were not are not."""

import functools
import importlib
import json
import os
import subprocess
import sys
import textwrap
import types
from unittest.mock import Mock

import numpy as np
import pytest
import symplint
from symplint._fingerprint import fingerprint
from symplint._form import MapOfForm

#: Of a step as it was: its source, what is edited, and in what.
EDITS = {
    "the step": ("def step(q, p, h): return q + h * p, p - h * 1.0 * q", "1.0", "2.0"),
    "a name without its value": ("import numpy as np\ndef step(q, p, h): return q + h * p, p - h * np.sin(q)", "sin", "cos"),
    "the default of an argument": ("def step(q, p, h, k=1.0): return q + h * p, p - h * k * q", "k=1.0", "k=2.0"),
    "names of arguments": (
        "def force(a, b): return a - b\ndef step(q, p, h): return q + h * p, p - h * force(a=q, b=1)",
        "(a, b): return a - b", "(b, a): return b - a",
    ),
    "a function inside it": (
        "def step(q, p, h):\n    force = lambda q: 1.0 * q\n    return q + h * p, p - h * force(q)", "1.0", "2.0",
    ),
    "a method of self": (
        """
        class Simulation:
            def force(self, q): return 1.0 * q
            def step(self, q, p, h): return q + h * p, p - h * self.force(q)
        step = Simulation().step
        """, "1.0", "2.0",
    ),
    "a method of a base class that is called by an operator": (
        """
        class Base:
            def __mul__(self, q): return 1.0 * q
        class Simulation(Base):
            def __call__(self, q, p, h): return q + h * p, p - h * (self * q)
        step = Simulation()
        """, "1.0", "2.0",
    ),
    "a property": (
        """
        class Simulation:
            @property
            def strength(self): return 1.0
            def step(self, q, p, h): return q + h * p, p - h * self.strength * q
        step = Simulation().step
        """, "1.0", "2.0",
    ),
    "a dictionary of self": (
        """
        class Simulation:
            def __init__(self): self.params = {"friction": 1.0}
            def step(self, q, p, h): return q + h * p, p - h * self.params["friction"] * q
        step = Simulation().step
        """, "1.0", "2.0",
    ),
    "a variable of the name of an attribute": (
        """
        k = 1.0
        class Simulation:
            def __init__(self): self.k = 3.0
            def step(self, q, p, h): return q + h * p, p - h * k * self.k * q
        step = Simulation().step
        """, "k = 1.0", "k = 2.0",
    ),
    "an object of self, with slots": (
        """
        class Parameters:
            __slots__ = ("k",)
            def __init__(self, k): self.k = k
        class Simulation:
            def __init__(self): self.parts = [{"first": Parameters(1.0)}]
            def step(self, q, p, h): return q + h * p, p - h * self.parts[0]["first"].k * q
        step = Simulation().step
        """, "1.0", "2.0",
    ),
    "an attribute of a class": (
        "class P:\n    k = 1.0\ndef step(q, p, h): return q + h * p, p - h * P.k * q", "1.0", "2.0",
    ),
    "a dataclass": (
        """
        from dataclasses import dataclass
        @dataclass(frozen=True)
        class Parameters:
            k: float
        P = Parameters(1.0)
        def step(q, p, h): return q + h * p, p - h * P.k * q
        """, "(1.0)", "(2.0)",
    ),
    "a namespace": (
        "import types\nP = types.SimpleNamespace(k=1.0)\ndef step(q, p, h): return q + h * p, p - h * P.k * q", "1.0", "2.0",
    ),
    "a method of a global object": (
        """
        class Simulation:
            def advance(self, q, p, h): return q + h * p, p - h * 1.0 * q
        simulation = Simulation()
        def step(q, p, h): return simulation.advance(q, p, h)
        """, "1.0", "2.0",
    ),
    "a set": ("K = {1.0, 5.0}\ndef step(q, p, h): return q + h * p, p - h * sum(K) * q", "1.0", "2.0"),
    "an array in a dictionary": (
        "import numpy as np\nP = {'k': np.array([1.0])}\ndef step(q, p, h): return q, p - h * P['k'] * q", "1.0", "2.0",
    ),
    "an array of objects": (
        "import numpy as np\nP = np.array([{'k': 1.0}])\ndef step(q, p, h): return q, p - h * P[0]['k'] * q", "1.0", "2.0",
    ),
    "an array of another library": (
        """
        import numpy as np
        class Tensor:
            def __array__(self, dtype=None, copy=None): return np.array([1.0])
        K = Tensor()
        def step(q, p, h): return q + h * p, p - h * np.asarray(K) * q
        """, "1.0", "2.0",
    ),
    "which of two equal objects it is": (
        """
        A, B = [1.0], [1.0]
        P = {"a": A, "b": B, "c": A}
        def step(q, p, h): return q + h * p, p - h * P["c"][0] * q
        """, '"c": A', '"c": B',
    ),
    "a partial function": (
        """
        import functools
        def base(k, q, p, h): return q + h * p, p - h * 1.0 * q
        step = functools.partial(base, 3.0)
        """, "1.0", "2.0",
    ),
    "what was partially given": (
        "import functools\ndef base(k, q, p, h): return q, p - h * k * q\nstep = functools.partial(base, 3.0)", "3.0", "2.0",
    ),
    "a cached function": (
        """
        import functools
        @functools.lru_cache
        def strength(h): return 1.0 * h
        def step(q, p, h): return q + h * p, p - h * strength(h) * q
        """, "1.0", "2.0",
    ),
    "a decorated function": (
        """
        import functools
        def counted(function):
            @functools.wraps(function)
            def wrapper(*arguments): return function(*arguments)
            return wrapper
        @counted
        def step(q, p, h): return q + h * p, p - h * 1.0 * q
        """, "1.0", "2.0",
    ),
    "what decorates a function": (
        """
        import functools
        def scaled(function):
            @functools.wraps(function)
            def wrapper(q, p, h): return function(q, p, 1.0 * h)
            return wrapper
        @scaled
        def step(q, p, h): return q + h * p, p - h * q
        """, "1.0", "2.0",
    ),
    "a method of a dictionary": (
        "get = {'k': 1.0}.get\ndef step(q, p, h): return q + h * p, p - h * get('k') * q", "1.0", "2.0",
    ),
    "a compiled function": (
        "from numpy import sin as force\ndef step(q, p, h): return q + h * p, p - h * force(q)", "import sin", "import cos",
    ),
    "a system of the library": (
        """
        import symplint
        base = symplint.integrators.strang(symplint.systems.henon_heiles())
        def step(q, p, h): return base(q, p, h)
        """, ".strang", ".yoshida4",
    ),
    "another item of what it counts in": (
        """
        state = {"calls": 0, "k": 1.0}
        def step(q, p, h):
            state["calls"] += 1
            return q + h * p, p - h * state["k"] * q
        """, "1.0", "2.0",
    ),
}  # fmt: skip

#: In files of their own, beside the step.
IMPORTED = {
    "a function": ("from forces import kick\ndef step(q, p, h): return q + h * p, p - h * kick(q)"),
    "a module": ("import forces\ndef step(q, p, h): return q + h * p, p - h * forces.kick(q)"),
    "a module that another function names first": (
        "import forces\ndef a(q): return forces.kick(q)\ndef step(q, p, h): return q + h * forces.unit(p), p - h * a(q)"
    ),
    "a module that the step imports": (
        "def step(q, p, h):\n    import forces\n    return q + h * p, p - h * forces.kick(q)"
    ),
    "a number": ("import forces\ndef step(q, p, h): return q + h * p, p - h * forces.STRENGTH * q"),
}


def module(folder, name, source):
    """A module of the user."""
    (folder / f"{name}.py").write_text(textwrap.dedent(source))
    for known in (name, "forces"):
        sys.modules.pop(known, None)
    importlib.invalidate_caches()
    return importlib.import_module(name)


@pytest.fixture(autouse=True)
def of_user(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    yield
    for name in ("of_user", "forces"):
        sys.modules.pop(name, None)


@pytest.mark.parametrize("what", EDITS)
def test_an_edit_is_seen(tmp_path, what):
    source, old, new = EDITS[what]
    assert old in source
    first = fingerprint(module(tmp_path, "of_user", source).step)
    assert fingerprint(module(tmp_path, "of_user", source).step) == first
    assert fingerprint(module(tmp_path, "of_user", source.replace(old, new)).step) != first
    # It can be written.
    json.dumps(first)


@pytest.mark.parametrize("what", IMPORTED)
def test_an_edit_of_another_file_is_seen(tmp_path, what):
    forces = "STRENGTH = 1.0\ndef kick(q): return STRENGTH * q\ndef unit(p): return p\ndef plot(): return 1"

    def of(source):
        (tmp_path / "forces.py").write_text(source)
        return fingerprint(module(tmp_path, "of_user", IMPORTED[what]).step)

    first = of(forces)
    assert of(forces.replace("1.0", "2.0")) != first
    # What the step does not name is no part of it, and neither are comments.
    assert of(forces.replace("return 1", "return 2") + "\n# a comment") == first


@pytest.mark.parametrize(
    "wrap",
    [functools.partial, np.vectorize, functools.lru_cache, lambda step: MapOfForm(step, step, False), staticmethod],
)
def test_an_edit_is_seen_within_what_wraps_the_step(tmp_path, wrap):
    source = EDITS["the step"][0]
    first = fingerprint(wrap(module(tmp_path, "of_user", source).step))
    assert fingerprint(wrap(module(tmp_path, "of_user", source).step)) == first
    assert fingerprint(wrap(module(tmp_path, "of_user", source.replace("1.0", "2.0")).step)) != first


@pytest.mark.parametrize("edit", [("1.0", "2.0"), ("sin", "cos"), ("lambda: 3", "lambda: 4")])
def test_an_edit_of_a_function_without_source_is_seen(edit):
    def step(source):
        names = {"np": np, "__name__": "__main__"}
        exec(source, names)
        return fingerprint(names["step"])

    source = "def step(q, p, h):\n    f = lambda: 3\n    return q + h * p, p - h * 1.0 * f() * np.sin(q)"
    assert step(source) == step("\n\n" + source)
    assert step(source) != step(source.replace(*edit))


def test_a_step_whose_file_was_edited_after_it_was_imported_is_the_old_one(tmp_path):
    source = EDITS["the step"][0]
    old = module(tmp_path, "of_user", source)
    first = fingerprint(old.step)
    (tmp_path / "of_user.py").write_text(source.replace("1.0", "2.0"))
    assert fingerprint(old.step) == first


def test_a_form_whose_step_was_edited_is_refused(tmp_path):
    source = """
    import numpy as np
    def step(z, h):
        x, y = z.T
        x *= np.exp(h * (1.0 - y))
        y *= np.exp(h * (x - 1.0))
    def form(z):
        x, y = z.T
        return np.column_stack([-np.log(y) / x, 0.0 * y])
    """

    def check(source):
        user = module(tmp_path, "of_user", source)
        settings = {"radius": 0.4, "step_sizes": [0.25], "loops": 2, "budget": 400, "out": tmp_path / "run"}
        return symplint.check(user.step, [1.0, 1.5], form=user.form, **settings)

    assert check(source).kind == "symplectic"
    assert check(source).to_dict()["provenance"]["replayed"] > 0
    with pytest.raises(symplint.InputError, match=r"is of another run: step\."):
        check(source.replace("        y *=", "        y *= 0.9;  y *="))


def test_another_reset_is_refused(tmp_path):
    state = types.SimpleNamespace(k=1.0)

    def step(q, p, h):
        return q + h * p, p - h * np.sin(q + h * p)

    def check(k):
        settings = {"step_sizes": [0.25], "loops": 2, "budget": 400, "out": tmp_path / "run"}
        symplint.check(step, 1.0, 0.5, reset=lambda: setattr(state, "last", k), **settings)

    check(1.0)
    with pytest.raises(symplint.InputError, match=r"reset\.values\.k is "):
        check(2.0)


#: Steps that change what they refer to, each in another way.
COUNTING = {
    "a list": ("calls = [0]", "calls[0] += 1"),
    "a dictionary": ("calls = {'made': 0}", "calls['made'] += 1"),
    "a dictionary in another one": ("calls = {'of': {'step': 0}}", "calls['of']['step'] += 1"),
    "an array": ("calls = np.zeros(2)", "calls[0] += 1"),
    "a work array": ("work = np.zeros(1)", "work[:] = q.ravel()[:1]"),
    "a cache": ("known = {}", "known[h] = q"),
    "a list that grows": ("log = []", "log.append(h)"),
    "a list of an object": ("class T: pass\nt = T()\nt.log = []", "t.log.append(h)"),
    "a set that grows": ("seen = set()", "seen.add(h)"),
    "an attribute of an object": ("class T: calls = 0\nt = T()\nt.calls = 0", "t.calls += 1"),
    "an attribute of a class": ("class T: calls = 0", "T.calls += 1"),
    "an attribute of itself": ("", "step.calls = getattr(step, 'calls', 0) + 1"),
    "an object in an object": ("class T: pass\nt = T()\nt.of = T()\nt.of.calls = 0", "t.of.calls += 1"),
    "a method of an object": (
        "class T:\n    def __init__(self): self.calls = [0]\n    def count(self): self.calls[0] += 1\nt = T()", "t.count()",
    ),
    "a property that is cached": (
        "import functools\nclass T:\n    @functools.cached_property\n    def k(self): return 1.0\nt = T()", "t.k",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", COUNTING)
def test_what_the_code_itself_changes_is_no_difference(tmp_path, what):
    state, change = COUNTING[what]
    source = f"import numpy as np\n{state}\ndef step(q, p, h):\n    {change}\n    return q, p\n"
    step = module(tmp_path, "of_user", source).step
    first = fingerprint(step)
    step(np.ones((3, 1)), np.ones((3, 1)), 0.5)
    assert fingerprint(step) == first


def test_a_step_that_counts_goes_on_in_the_same_process(tmp_path):
    calls = [0]

    def step(q, p, h):
        calls[0] += 1
        if calls[0] == 7:
            raise KeyboardInterrupt
        p = p - h * np.sin(q)
        return q + h * p, p

    def check():
        return symplint.check(step, 1.0, 0.5, step_sizes=[0.5, 0.25], budget=400, loops=2, out=tmp_path / "run")

    with pytest.raises(KeyboardInterrupt):
        check()
    assert check().to_dict()["provenance"]["replayed"] > 0


SAME_EVERYWHERE = """
import json, sys, threading, logging, random
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
import numpy as np
from symplint._fingerprint import fingerprint

class Kind(Enum):
    A = "a"
    B = "b"

@dataclass
class Node:
    kind: Kind
    next: object = None

names = {"alpha", "beta", "gamma", ("delta", 1), Kind.A}
first = Node(Kind.A)
first.next = Node(Kind.B, first)
lock, log, rng = threading.Lock(), logging.getLogger("step"), np.random.default_rng()

def step(q, p, h):
    with lock:
        log.debug("x")
        kind = h in {"alpha", "beta", "gamma"}
        return q + h * len(names) * (first.next.kind is Kind.B), p + rng.normal() + random.random()

print(json.dumps(fingerprint(step)))
"""


def test_the_same_in_every_process(tmp_path):
    # Sets of texts have another order in each, and locks another place.
    (tmp_path / "program.py").write_text(SAME_EVERYWHERE)
    found = set()
    for seed in "123":
        command = [sys.executable, tmp_path / "program.py"]
        found.add(subprocess.check_output(command, env=os.environ | {"PYTHONHASHSEED": seed}, text=True))
    assert len(found) == 1


def test_objects_that_make_up_attributes_have_an_end():
    made_up = Mock()

    def step(q, p, h):
        return q, p + made_up.k

    assert len(fingerprint(step)["values"]) < 100


def test_what_holds_itself_and_what_is_deep_has_an_end(tmp_path):
    user = module(tmp_path, "of_user", "chain = []\ndef step(q, p, h): return q, p, chain")
    held = user.chain
    for _ in range(5000):
        held.append([])
        held = held[0]
    first = fingerprint(user.step)
    held.append(user.chain)
    assert fingerprint(user.step) != first
    user.chain[:] = list(range(5000))
    many = fingerprint(user.step)
    user.chain[-1] = -1
    assert fingerprint(user.step) != many
    assert len(many["values"]) <= 1000
