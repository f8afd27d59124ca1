"""Checks that were stopped, and continue. `tools/kill_and_resume.py` kills them in earnest."""

import functools
import importlib
import json
import linecache
import os
import re
import sys

import numpy as np
import pytest
import symplint
from symplint._identity import identity

SETTINGS = {"step_sizes": [0.5, 0.25], "budget": 400, "loops": 3}


class Stopped(BaseException):
    """As Ctrl-C: no failure of the step."""


def counting(folder):
    """A leapfrog that counts its calls in a file, and raises in the call whose number is in another one."""

    def step(q, p, h):
        calls, last = folder / "calls", folder / "last"
        made = calls.read_text().splitlines() if calls.exists() else []
        if last.exists() and len(made) == int(last.read_text()):
            raise Stopped
        q = q + 0.5 * h * p
        p = p - h * np.sin(q)
        calls.write_text("\n".join([*made, repr((h, q.tolist(), p.tolist()))]))
        return q + 0.5 * h * p, p

    return step


def report(folder):
    found = json.loads((folder / "run" / "report.json").read_text())
    return found, found.pop("provenance")["replayed"]


@pytest.mark.parametrize("per_sample", [False, True])
def test_a_check_that_was_stopped_goes_on(tmp_path, per_sample):
    whole, stopped = tmp_path / "whole", tmp_path / "stopped"

    def check(folder):
        folder.mkdir(exist_ok=True)
        symplint.check(counting(folder), 1.0, 0.5, per_sample=per_sample, out=folder / "run", **SETTINGS)
        return (folder / "calls").read_text()

    calls = check(whole)
    count = len(calls.splitlines())
    stopped.mkdir()
    for last in (1, count // 3, count - 1):
        (stopped / "last").write_text(str(last))
        with pytest.raises(Stopped):
            check(stopped)
    (stopped / "last").unlink()
    assert check(stopped) == calls
    (of_whole, none), (of_stopped, replayed) = report(whole), report(stopped)
    assert none == 0 and replayed > 0
    assert of_stopped == of_whole
    # All is known: nothing is called.
    assert check(stopped) == calls
    assert report(stopped)[1] == of_whole["evaluations"]["made"]


@pytest.mark.parametrize("per_sample", [False, True])
@pytest.mark.parametrize("friction", [None, 0.125])
def test_a_test_of_a_force_or_a_field_that_was_stopped_goes_on(tmp_path, per_sample, friction):
    whole, stopped = tmp_path / "whole", tmp_path / "stopped"

    def test(folder, **arguments):
        folder.mkdir(exist_ok=True)
        step = counting(folder)
        arguments = {"run_dir": folder / "run", "per_sample": per_sample, "budget": 400} | arguments
        if friction is None:
            return symplint.check_force(lambda q: step(q, q, 0.5)[1], [1.0, 0.5], **arguments)
        return symplint.check_field(lambda q, p: (p, step(q, p, 0.0)[1] - friction * p), 1.0, 0.5, **arguments)

    found = test(whole)
    calls = (whole / "calls").read_text()
    count = len(calls.splitlines())
    stopped.mkdir()
    for last in (1, count // 2, count - 1):
        (stopped / "last").write_text(str(last))
        with pytest.raises(Stopped):
            test(stopped)
    (stopped / "last").unlink()
    # The second one finds all results, and calls nothing.
    for _ in range(2):
        assert test(stopped).to_dict() == found.to_dict()
        assert (stopped / "calls").read_text() == calls
    assert (stopped / "run" / "report.json").read_text() == found.to_json()
    for other in ({"loops": 5}, {"key": "another"}, {"args": (1.0,)}, {"period": 2.0}, {"rng": 2}):
        with pytest.raises(symplint.InputError, match="run"):
            test(stopped, **other)


def _step(q, p, h):
    p = p - h * np.sin(q)
    return q + h * p, p


MODULE = """
class Simulation:
    def step(self, q, p, h):
        p = p - 1.0 * h * q
        return q + h * p, p

    def __call__(self, q, p, h):
        return self.step(q, p, h)

def step(q, p, h, k=1.0):
    return Simulation().step(q, p, h)
"""


@pytest.fixture
def module(tmp_path, monkeypatch):
    """A module of the user, and a function that edits it."""
    monkeypatch.syspath_prepend(tmp_path)
    path = tmp_path / "of_user.py"

    def edit(old, new):
        path.write_text(MODULE.replace(old, new))
        linecache.clearcache()

    edit("", "")
    yield importlib.import_module("of_user"), edit
    del sys.modules["of_user"]


def test_the_source_text_of_its_module_identifies_a_step(module):
    of_user, edit = module
    steps = [of_user.step, of_user.Simulation().step, of_user.Simulation(), functools.partial(of_user.step, k=2.0)]
    steps.append(functools.lru_cache(of_user.step))
    before = identity({"step": steps[0], "reset": None}, None)["source"]
    assert list(before) == ["of_user"]
    assert all(identity({"step": step}, None)["source"] == before for step in steps)
    edit("1.0 * h", "2.0 * h")
    assert all(identity({"step": step}, None)["source"].keys() == before.keys() for step in steps)
    assert all(identity({"step": step}, None)["source"] != before for step in steps)


def test_another_run_is_refused_with_the_difference(tmp_path, module):
    of_user, edit = module

    def check(**arguments):
        return symplint.check(of_user.step, 1.0, 0.5, out=tmp_path / "run", **(SETTINGS | arguments))

    def refuses(difference, **arguments):
        with pytest.raises(symplint.InputError, match=re.escape(difference)):
            check(**arguments)

    check()
    assert check().to_dict()["provenance"]["replayed"] > 0
    refuses("check.budget is 400 there and 300 here", budget=300)
    refuses('key is null there and "k = 2" here', key="k = 2")
    edit("1.0 * h", "2.0 * h")
    refuses("source.of_user is ")


def test_a_step_without_source_text_needs_a_key(tmp_path):
    names = {"__name__": __name__}
    exec(MODULE, names)
    with pytest.raises(symplint.InputError, match='the source text of step cannot be read; identify it .* key='):
        symplint.check(names["step"], 1.0, 0.5, out=tmp_path / "run", **SETTINGS)
    assert not (tmp_path / "run").exists()
    report = symplint.check(names["step"], 1.0, 0.5, out=tmp_path / "run", key="1", **SETTINGS)
    assert report.kind == "symplectic"
    with pytest.raises(symplint.InputError, match='key is "1" there and "2" here'):
        symplint.check(names["step"], 1.0, 0.5, out=tmp_path / "run", key="2", **SETTINGS)
    with pytest.raises(symplint.InputError, match="key is an object of type int; give a string"):
        symplint.check(_step, 1.0, 0.5, out=tmp_path / "run", key=2, **SETTINGS)


def test_a_folder_that_cannot_be_used_is_an_input_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(symplint.InputError, match="cannot make the folder"):
        symplint.check(_step, 1.0, 0.5, out=tmp_path / "file" / "run", **SETTINGS)
    assert symplint.check(_step, 1.0, 0.5, out=str(tmp_path / "bytes").encode(), **SETTINGS).kind == "symplectic"
    (tmp_path / "journal").write_text("notes of mine")
    with pytest.raises(symplint.InputError, match="not a journal"):
        symplint.check(_step, 1.0, 0.5, out=tmp_path, **SETTINGS)
    assert (tmp_path / "journal").read_text() == "notes of mine"
    with pytest.raises(symplint.InputError, match="run_dir is an empty path"):
        symplint.check(_step, 1.0, 0.5, out="", **SETTINGS)


def test_a_step_may_change_the_working_directory(tmp_path, monkeypatch):
    other = tmp_path / "other"
    other.mkdir()
    monkeypatch.chdir(tmp_path)

    def step(q, p, h):
        os.chdir(other)
        return _step(q, p, h)

    def stop(measured, planned, h):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stopped:
        symplint.check(step, 1.0, 0.5, out="run", progress=stop, **SETTINGS)
    assert repr(str(tmp_path / "run")) in stopped.value.__notes__[0]
    monkeypatch.chdir(tmp_path)
    symplint.check(step, 1.0, 0.5, out="run", **SETTINGS)
    assert report(tmp_path)[1] > 0
    assert list(other.iterdir()) == []


@pytest.mark.skipif(os.name == "nt", reason="a working directory cannot be removed")
def test_a_relative_folder_without_a_working_directory_is_an_input_error(tmp_path, monkeypatch):
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    with pytest.raises(symplint.InputError, match="run_dir is 'run', relative .* give an absolute path"):
        symplint.check(_step, 1.0, 0.5, out="run", **SETTINGS)
