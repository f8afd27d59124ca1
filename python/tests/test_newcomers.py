"""Mistakes of people who use the package for the first time: each message names the mistake and the remedy."""

import math

import numpy as np
import pytest
import symplint


def good(q, p, h):
    p = p - h * np.sin(q)
    return q + h * p, p


def right_hand_side_of_time(t, y):
    return -y


def step_size_first(h, q, p):
    return good(q, p, h)


def momentum_first(p, q, h):
    q, p = good(q, p, h)
    return p, q


def all_at_once(z, h):
    return z


def without_h(q, p):
    return q, p


def four_arguments(q, p, h, k):
    return good(q, p, h)


def of_scalars(q, p, h):
    return q + h * p, p - h * math.sin(q)


def to_float(q, p, h):
    return float(q) + h * p, p


def by_if(q, p, h):
    if q > 0:
        p = p - h
    return q + h * p, p


def by_index(q, p, h):
    for i in range(2):
        p[i] -= h * np.sin(q[i])
        q[i] += h * p[i]


def by_column(q, p, h):
    return q + h * p, p - h * np.array([q[1], q[0]])


def keyword_only(q, p, *, h):
    return good(q, p, h)


def by_mean(q, p, h):
    return q + h * p, p - h * np.mean(q)


def transposed(q, p, h):
    q, p = good(q, p, h)
    return q.T, p.T


def one_array(q, p, h):
    return q + h * p


def three_results(q, p, h):
    return q, p, h


def a_dictionary(q, p, h):
    return {"q": q, "p": p}


def complex_numbers(q, p, h):
    return q + 1j * h * p, p


def divided_by_zero(q, p, h):
    with np.errstate(all="ignore"):
        return q / 0, p


def counts():
    calls = 0

    def step(q, p, h):
        nonlocal calls
        calls += 1
        return q + h * p, p - h * np.sin(q) + 1e-3 * calls

    return step


ONE, TWO = ([0.3], [0.2]), ([0.3, 0.1], [0.2, 0.4])

MISTAKES = {
    "right-hand side of scipy": (right_hand_side_of_time, ONE, {}, ["right-hand side", "check_field"]),
    "step size first": (step_size_first, ONE, {}, ["first argument is a step size", "lambda q, p, h: step_size_first(h, q, p)"]),
    "momentum first": (momentum_first, ONE, {}, ["first argument is a momentum", "return q, p"]),
    "all coordinates at once": (all_at_once, ONE, {}, ["takes all coordinates at once", "form="]),
    "no step size": (without_h, ONE, {}, ["no step size", 'step_sizes="none"']),
    "a step size that is not passed": (good, ONE, {"step_sizes": "none"}, ["called as step(q, p)"]),
    "an argument too many": (four_arguments, ONE, {}, ["four_arguments(q, p, h, k)", "args="]),
    "functions of scalars": (of_scalars, ONE, {}, ["numpy functions", "per_sample=True"]),
    "functions of scalars for one state": (of_scalars, ONE, {"per_sample": True}, ["shape (dof,)", "q[0]"]),
    "parts without a step size": (None, ONE, {"substeps": [("a", without_h)]}, ["no step size", 'step_sizes="none"']),
    "float of an array": (to_float, ONE, {}, ["shape (samples, dof)", "per_sample=True"]),
    "if of an array": (by_if, ONE, {}, ["truth value", "per_sample=True"]),
    "index of a degree of freedom": (by_index, TWO, {}, ["q[:, i] is degree of freedom i", "per_sample=True"]),
    "a state as two numbers": (by_column, TWO, {}, ["broadcast", "shape (samples, dof)", "q[:, i]", "per_sample=True"]),
    "a step size as a keyword": (keyword_only, ONE, {}, ["h is keyword-only", "lambda q, p, h: keyword_only(q, p, h=h)"]),
    "mean over samples": (by_mean, TWO, {}, ["other rows of the batch", "axis=1"]),
    "transposed results": (transposed, TWO, {}, ["one row for each sample"]),
    "one array": (one_array, ONE, {}, ["return q and p"]),
    "three results": (three_results, ONE, {}, ["tuple of length 3", "return q and p"]),
    "a dictionary": (a_dictionary, ONE, {}, ["dict", "return q and p"]),
    "complex numbers": (complex_numbers, ONE, {}, ["complex128", "real numbers"]),
    "division by zero": (divided_by_zero, ONE, {}, ["q[0] is inf", "smaller step sizes"]),
    "memory": (counts(), ONE, {}, ["depends on earlier calls", "depend only on h and the state"]),
    "no function": (3, ONE, {}, ["step is an object of type int", "step(q, p, h)"]),
    "nothing": (None, ONE, {}, ["step is missing", "substeps"]),
    "no centre": (good, (None, None), {}, ["q0 and p0 are missing; give the centre of the loops"]),
    "centres of two lengths": (good, ([1, 2], [1]), {}, ["q0 has 2 values and p0 has 1"]),
    "centres of two shapes": (good, (np.ones((3, 2)), np.ones(6)), {}, ["q0 has the shape (3, 2) and p0 (6,)", "one of both"]),
    "a step size of zero": (good, ONE, {"step_sizes": [0.0]}, ["step_sizes[0] is 0", "other than 0"]),
    "a step size as a text": (good, ONE, {"step_sizes": "0.5"}, ['step_sizes is "0.5"', '"none"']),
    "no radius": (good, ONE, {"radius": 0.0}, ["radius is 0.0", '"auto"']),
    "a small budget": (good, ONE, {"budget": 100}, ["budget is 100", "at least 200"]),
    "a mass of zero": (good, ONE, {"weight": [0.0]}, ["weight[0] is 0"]),
    "a period too many": (good, ONE, {"period": [1.0, 1.0]}, ["period has 2 values for 1"]),
    "an unknown rule": (good, ONE, {"rule": "spectral"}, ['rule is "spectral"', '"pseudospectral"']),
    "an open loop": (
        good,
        ONE,
        {"loop": lambda s: (np.cos(s)[:, None], np.sin(s)[:, None])},
        ["not closed", "full turns (2π, not 6.28)"],
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_the_message_names_the_mistake_and_the_remedy(mistake):
    step, centre, arguments, words = MISTAKES[mistake]
    with pytest.raises(symplint.SymplintError) as raised:
        symplint.check(step, *centre, **arguments)
    for word in words:
        assert word in str(raised.value)


def test_an_unknown_name_of_the_step_size_is_named():
    with pytest.raises(TypeError, match="'dt'; did you mean 'typical_step'"):
        symplint.check(good, *ONE, dt=0.1)


def test_a_right_hand_side_is_no_step():
    report = symplint.check(lambda q, p, h: (p, -np.sin(q)), *ONE)
    assert report.cause.kind == "ignores-step-size"
    assert "check_field" in report.advice[0]


def test_results_in_the_other_order_are_named():
    report = symplint.check(lambda q, p, h: good(q, p, h)[::-1], *ONE)
    assert report.cause.kind == "swapped"


def test_states_that_are_not_returned_are_named():
    def forgets(q, p, h):
        q, p = good(q, p, h)

    report = symplint.check(forgets, *ONE)
    assert report.kind == "undecided"
    assert "returns the states that it advanced" in report.advice[0]


def test_random_numbers_are_named():
    rng = np.random.default_rng(1)
    report = symplint.check(lambda q, p, h: (q + h * p, p - h * q + h * rng.normal(size=q.shape)), *ONE)
    assert report.kind == "undecided"
    assert "draws random numbers" in report.summary


def test_a_report_is_neither_true_nor_false():
    with pytest.raises(TypeError, match="is_symplectic"):
        assert symplint.check(good, *ONE)
