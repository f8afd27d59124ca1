"""The plugin of pytest, in a separate pytest."""

import pytest

pytest_plugins = ["pytester"]

STEP = """
import numpy as np
import pytest

def step(q, p, h):
    p = p - h * np.sin(q)
    return q + h * p, p

def leaky(q, p, h):
    q, p = step(q, p, h)
    return q, p * (1.0 - 0.01 * h)
"""


def run(pytester, text, *options):
    pytester.makepyfile(STEP + text)
    return pytester.runpytest_subprocess("-p", "no:cacheprovider", "--strict-markers", *options)


def test_the_fixture_passes_and_fails(pytester):
    result = run(
        pytester,
        """
def test_good(symplectic):
    report = symplectic(step, 1.0, 0.5, digits=12)
    assert report.kind == "symplectic"

def test_bad(symplectic):
    symplectic(leaky, 1.0, 0.5)
""",
    )
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.fnmatch_lines(["*leaky is not symplectic*0.005 at h = 0.5*"])
    # The failure points at the line of the test, not into the package.
    result.stdout.fnmatch_lines([">*symplectic(leaky, 1.0, 0.5)"])


def test_tracebacks_end_at_the_line_of_the_test(pytester):
    result = run(
        pytester,
        """
import symplint

def test_assertion():
    symplint.assert_symplectic(leaky, 1.0, 0.5)

def test_argument():
    symplint.check(leaky, 1.0, 0.5, loops=0)
""",
    )
    result.assert_outcomes(failed=2)
    result.stdout.fnmatch_lines([">*symplint.assert_symplectic(leaky, 1.0, 0.5)", ">*symplint.check(leaky, *, loops=0)"])
    result.stdout.no_fnmatch_line("*def assert_symplectic(*")
    result.stdout.no_fnmatch_line("*def check(*")


def test_markers_and_options(pytester):
    text = """
@pytest.mark.symplectic(digits=17)
def test_marked(symplectic):
    symplectic(step, 1.0, 0.5)

@pytest.mark.symplectic(digits=17)
def test_arguments_come_first(symplectic):
    symplectic(step, 1.0, 0.5, digits=10)

@pytest.mark.symplectic(budget=400)
def test_budget(symplectic):
    assert symplectic(step, 1.0, 0.5).evaluations <= 400

def test_plain(symplectic):
    assert symplectic(step, 1.0, 0.5).evaluations > 1000

@pytest.mark.symplectic(precision=3)
def test_unknown(symplectic):
    pass
"""
    result = run(pytester, text)
    result.assert_outcomes(passed=3, failed=1, errors=1)
    result.stdout.fnmatch_lines(["*digits only, not to 17*"])
    result.stdout.fnmatch_lines(["*the marker symplectic takes budget and digits*"])
    result = run(pytester, text, "--symplectic-budget=500", "-k", "plain")
    result.assert_outcomes(failed=1)
    result = run(pytester, text, "--symplectic-digits=17", "-k", "plain")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines(["*not to 17*"])


@pytest.mark.parametrize("words", ["symplectic(budget=None, digits=None)"])
def test_the_marker_is_listed(pytester, words):
    result = pytester.runpytest_subprocess("--markers")
    assert words in result.stdout.str()


def test_the_configuration_of_pytest_sets_digits(pytester):
    text = """
def test_all(symplectic):
    symplectic(step, 1.0, 0.5)
"""
    for digits, outcome in (("10", {"passed": 1}), ("16", {"failed": 1})):
        pytester.makeini(f"[pytest]\nsymplectic_digits = {digits}\n")
        run(pytester, text).assert_outcomes(**outcome)
    # An option of the command line comes first.
    run(pytester, text, "--symplectic-digits", "10").assert_outcomes(passed=1)
    pytester.makeini("[pytest]\nsymplectic_digits = many\n")
    run(pytester, text).stdout.fnmatch_lines(["*symplectic_digits is 'many'*give a number*"])
