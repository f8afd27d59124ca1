"""Processes that were forked, and steps that call the library."""

import copy
import os
import pickle
import subprocess
import sys

import numpy as np
import pytest
import symplint

PARENT_AND_CHILD = """
import os, sys, tempfile, warnings
import numpy as np
import symplint

# Python 3.12 and later warn of threads, which is what this is about.
warnings.simplefilter("ignore", DeprecationWarning)

def step(q, p, h):
    p = p - h * np.sin(q)
    return q + h * p, p

strang = symplint.integrators.strang(symplint.systems.henon_heiles())

def use():
    q, p = symplint.circle([0.1, 0.2], [0.3, 0.1], radius=0.1, samples=4096)
    symplint.SampledLoop(q, p).sample(64)
    symplint.FourierLoop(0.0, 0.0).sample(64)
    after = strang(q, p, 0.1)
    symplint.loop_integral(q, p)
    assert symplint.measure((q, p), after, h=0.1).kind == "symplectic"
    report = symplint.check(strang, radius=0.1, step_sizes=[0.25], loops=2)
    assert report.kind == "symplectic"
    with tempfile.TemporaryDirectory() as folder:
        report.save(folder)
    report = symplint.check(step, 1.0, 0.5, step_sizes=[0.25], loops=2)
    assert report.kind == "symplectic"
    report._image(0.25, 64)
    symplint.systems.pic_1d()

use()
child = os.fork()
if child == 0:
    use()
    grandchild = os.fork()
    if grandchild == 0:
        use()
        os._exit(7)
    os._exit(os.waitstatus_to_exitcode(os.waitpid(grandchild, 0)[1]))
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
use()
print("done")
"""

CALLS_THE_LIBRARY = """
import numpy as np
import symplint

def call():
    # So many samples that the threads share them.
    symplint.circle(0.0, 0.0, samples=2**15)

def step(q, p, h):
    call()
    p = p - h * np.sin(q)
    return q + h * p, p

def circle(s):
    call()
    angles, ones = 2 * np.pi * s[:, np.newaxis], np.ones(40)
    return np.sin(angles) * ones, np.cos(angles) * ones

report = symplint.check(step, np.zeros(40), np.zeros(40), step_sizes=[0.25], samples=2**13, budget=40_000, {arguments})
assert report.kind == "symplectic", report
print("done")
"""


def output(code, **environment):
    """What a program prints that must end within a minute, with all processes that it starts."""
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, start_new_session=True,
        env=os.environ | environment,
    )  # fmt: skip
    try:
        return process.communicate(timeout=60)[0]
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)
        raise


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_process_that_was_forked():
    assert output(PARENT_AND_CHILD) == "done\n"


@pytest.mark.parametrize("arguments", ["loop=circle", "rule='streaming'", "loop=circle, threads=1"])
def test_functions_that_call_the_library(arguments):
    assert output(CALLS_THE_LIBRARY.format(arguments=arguments), RAYON_NUM_THREADS="2") == "done\n"


def midpoint(q, p, h):
    dq, dp = p - 0.5 * h * np.sin(q), -np.sin(q + 0.5 * h * p)
    return q + h * dq, p + h * dp


def test_reports_and_exceptions_go_from_process_to_process():
    report = symplint.check(midpoint, 1.0, 0.5, step_sizes=[0.5, 0.25])
    found = pickle.loads(pickle.dumps(report))
    assert found.to_json() == report.to_json() and str(found) == str(report)
    assert found.points.tobytes() == report.points.tobytes()
    with pytest.raises(symplint.SymplintError, match="pickled"):
        found.plot_loop()

    with pytest.raises(symplint.NotSymplecticError) as caught:
        symplint.assert_symplectic(midpoint, 1.0, 0.5, step_sizes=[0.5, 0.25])
    found = pickle.loads(pickle.dumps(caught.value))
    assert type(found) is symplint.NotSymplecticError and str(found) == str(caught.value)
    assert found.report.kind == "not-symplectic"

    def step(q, p, h):
        if h == 0.25 and (q > 1.9).any():
            raise ArithmeticError("too far")
        return midpoint(q, p, h)

    with pytest.raises(symplint.StepError) as caught:
        symplint.check(step, 1.0, 0.5, step_sizes=[0.5, 0.25])
    found = pickle.loads(pickle.dumps(caught.value))
    assert type(found) is symplint.StepError and str(found) == str(caught.value)
    assert (found.h, found.s, found.sample) == (0.25, caught.value.s, caught.value.sample)
    assert found.report.to_json() == caught.value.report.to_json()


def test_copies_of_reports_keep_the_map():
    report = symplint.check(midpoint, 1.0, 0.5, step_sizes=[0.5])
    for found in (copy.copy(report), copy.deepcopy(report)):
        assert found.to_json() == report.to_json()
        assert len(found._image(0.5, 16)[0][0]) == 16
