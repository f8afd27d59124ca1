"""Checks that were stopped, and go on. `tools/kill_and_resume.py` kills them in earnest."""

import json
import os
import re

import numpy as np
import pytest
import symplint

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


STRENGTH = 1.0


def _kick(p, q, h):
    return p - h * STRENGTH * np.sin(q)


def _step(q, p, h):
    p = _kick(p, q, h)
    return q + h * p, p


class _Simulation:
    def __init__(self, strength):
        self.strength = strength
        self.calls = 0

    def step(self, q, p, h):
        self.calls += 1
        p = p - h * self.strength * np.sin(q)
        return q + h * p, p


def test_another_step_is_refused_with_the_difference(tmp_path, monkeypatch):
    def check(step, name, **arguments):
        return symplint.check(step, 1.0, 0.5, out=tmp_path / name, **(SETTINGS | arguments))

    def refuses(step, name, difference, **arguments):
        with pytest.raises(symplint.InputError, match=re.escape(difference)):
            check(step, name, **arguments)

    check(_step, "function")
    check(_step, "function")
    refuses(_step, "function", "check.budget is 400 there and 300 here", budget=300)
    refuses(lambda q, p, h: _step(q, p, h), "function", "step is")
    monkeypatch.setitem(globals(), "STRENGTH", 2.0)
    refuses(_step, "function", 'step.values."_kick.STRENGTH" is "1.0" there and "2.0" here')
    # What the code itself counts is no difference.
    simulation = _Simulation(1.0)
    check(simulation.step, "method")
    check(simulation.step, "method")
    assert simulation.calls > 0
    refuses(_Simulation(3.0).step, "method", 'step.values.strength is "1.0" there and "3.0" here')
    # A global variable of the name of an attribute is no part of it.
    monkeypatch.setitem(globals(), "strength", 5.0)
    check(simulation.step, "method")
    masses = np.array([1.0, 2.0])
    check(lambda q, p, h: (q + h * p / masses[0], p), "array")
    masses[0] = 3.0
    refuses(lambda q, p, h: (q + h * p / masses[0], p), "array", "step.")


def test_a_folder_that_cannot_be_used_is_an_input_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(symplint.InputError, match="cannot make the folder"):
        symplint.check(_step, 1.0, 0.5, out=tmp_path / "file" / "run", **SETTINGS)
    assert symplint.check(_step, 1.0, 0.5, out=str(tmp_path / "bytes").encode(), **SETTINGS).kind == "symplectic"
    (tmp_path / "journal").write_text("notes of mine")
    with pytest.raises(symplint.InputError, match="not a journal"):
        symplint.check(_step, 1.0, 0.5, out=tmp_path, **SETTINGS)
    assert (tmp_path / "journal").read_text() == "notes of mine"
    with pytest.raises(symplint.InputError, match="out is an empty path"):
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
    with pytest.raises(symplint.InputError, match="out is 'run', relative .* give an absolute path"):
        symplint.check(_step, 1.0, 0.5, out="run", **SETTINGS)
