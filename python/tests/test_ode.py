"""Steps of the integrators of SciPy."""

import pickle

import numpy as np
import pytest
import symplint

pytest.importorskip("scipy")


def pendulum(t, y):
    return [y[1], -np.sin(y[0])]


def bogacki_shampine(q, p, h):
    """P. Bogacki and L. F. Shampine, Appl. Math. Lett. 2, 321 (1989): the method of order 3."""

    def f(y):
        return np.array([y[1], -np.sin(y[0])])

    y = np.array([q, p])
    k1 = f(y)
    k2 = f(y + h / 2 * k1)
    k3 = f(y + 3 * h / 4 * k2)
    return y + h * (2 * k1 + 3 * k2 + 4 * k3) / 9


@pytest.mark.parametrize("h", [0.5, -0.25])
def test_one_fixed_step_is_one_step_of_the_method(h):
    step = symplint.from_ode(pendulum, "RK23", fixed_steps=1)
    q, p = np.array([[1.0], [0.2]]), np.array([[0.5], [-0.1]])
    np.testing.assert_allclose(step(q, p, h), bogacki_shampine(q, p, h), rtol=1e-14)
    np.testing.assert_allclose(step(q[0], p[0], h), bogacki_shampine(q[0], p[0], h), rtol=1e-14)
    two = symplint.from_ode(pendulum, "RK23", fixed_steps=2)
    middle = bogacki_shampine(q, p, h / 2)
    np.testing.assert_allclose(two(q, p, h), bogacki_shampine(*middle, h / 2), rtol=1e-14)


def test_adaptive_steps_end_at_the_exact_solution():
    def oscillator(t, y, frequency):
        return [frequency * y[1], -frequency * y[0]]

    step = symplint.from_ode(oscillator, "DOP853", rtol=1e-12, atol=1e-14, args=(2.0,))
    q, p = step(np.array([[1.0]]), np.array([[0.0]]), 3.0)
    assert [q[0, 0], p[0, 0]] == pytest.approx([np.cos(6.0), -np.sin(6.0)], abs=1e-10)


def test_methods_get_their_verdicts():
    step = symplint.from_ode(pendulum, "RK23", fixed_steps=1)
    sizes = {"step_sizes": [0.5, 0.25, 0.125, 0.0625], "budget": 2000}
    report = symplint.check(step, 1.0, 0.5, **sizes)
    assert report.kind == "not-symplectic"
    # A tight tolerance follows the flow, which is symplectic: no large defect is found.
    tight = symplint.from_ode(pendulum, "DOP853", rtol=1e-13, atol=1e-13)
    report = symplint.check(tight, 1.0, 0.5, step_sizes=[0.5, 0.25], budget=1000, loops=2)
    assert report.kind != "not-symplectic", report


def test_a_step_is_pickled_and_named():
    step = symplint.from_ode(pendulum, "RK45", fixed_steps=1)
    again = pickle.loads(pickle.dumps(step))
    state = (np.array([[1.0]]), np.array([[0.5]]), 0.5)
    assert np.array_equal(again(*state), step(*state))
    assert step.__name__ == "pendulum by RK45"


def test_a_run_folder_belongs_to_the_source_of_f(tmp_path):
    step = symplint.from_ode(pendulum, "RK45", fixed_steps=1)
    arguments = {"step_sizes": [0.5], "loops": 1, "budget": 300, "jacobian": False}
    symplint.check(step, 1.0, 0.5, run_dir=tmp_path, **arguments)
    again = symplint.check(step, 1.0, 0.5, run_dir=tmp_path, **arguments)
    assert again.to_dict()["provenance"]["replayed"] > 0
    assert "test_ode" in (tmp_path / "journal").read_bytes()[:4096].decode(errors="replace")


@pytest.mark.parametrize("solver", ["RK45", "Radau", "LSODA"])
def test_values_of_f_that_are_not_finite_are_named(solver):
    step = symplint.from_ode(lambda t, y: [0.0, np.nan], solver)
    with pytest.raises(symplint.StepError, match=r"f\(t, y\) is NaN in dy/dt\[1\] at t = 0"):
        symplint.check(step, 1.0, 0.5, step_sizes=[0.5], loops=1, budget=300)


@pytest.mark.filterwarnings("ignore:invalid value")
def test_adaptive_steps_avoid_values_that_are_not_finite():
    def falls(t, y):
        return [np.nan if y[0] < 0.0 else -50.0 * y[0], 0.0]

    state = np.array([[1.0]]), np.array([[0.5]])
    q, _ = symplint.from_ode(falls, first_step=1.0)(*state, 1.5)
    assert abs(q[0, 0]) < 1e-3
    with pytest.raises(ValueError, match="is NaN in dy/dt"):
        symplint.from_ode(falls, fixed_steps=1)(*state, 1.5)
    with pytest.raises(RuntimeError, match=r"stops at t = 0.1: .* f\(t, y\) is infinite in dy/dt\[1\] at t = 0.1"):
        symplint.from_ode(lambda t, y: [1.0, np.inf if t > 0.1 else 0.0])(*state, 1.5)


@pytest.mark.parametrize("fixed_steps", [None, 2])
def test_a_wrong_number_of_values_is_named(fixed_steps):
    step = symplint.from_ode(lambda t, y: [-np.sin(y[0])], fixed_steps=fixed_steps)
    with pytest.raises(symplint.StepError, match="returned 1 value for 2 coordinates"):
        symplint.check(step, 1.0, 0.5, step_sizes=[0.5], loops=1, budget=300)


def test_failures_and_refused_arguments():
    def blows_up(t, y):
        return [y[0] ** 2, 0.0]

    with pytest.raises(symplint.StepError, match="blows_up by RK45 stops at t = 0"):
        symplint.check(symplint.from_ode(blows_up), 1.5, 0.5, step_sizes=[2.0], loops=1, budget=300)

    def crosses(t, y):
        return y[0] - 1.2

    crosses.terminal = True
    step = symplint.from_ode(pendulum, events=crosses)
    with pytest.raises(RuntimeError, match="pendulum by RK45 stops at t = 0"):
        step(np.array([[1.0]]), np.array([[1.0]]), 1.0)
    for arguments, words in (
        ({"t_eval": [0.5]}, "t_eval is given"),
        ({"f": 3}, "give a function"),
        ({"solver": "RK77"}, "solver is 'RK77'; give one of RK23, RK45, DOP853, Radau, BDF, LSODA"),
        ({"solver": 3}, "solver is 3"),
        ({"fixed_steps": 0}, "1 or more"),
        ({"fixed_steps": 1, "rtol": 1e-3}, "both fixed_steps and rtol"),
        ({"solver": "Radau", "fixed_steps": 1}, "Radau has no steps of fixed size"),
    ):
        with pytest.raises(symplint.InputError, match=words):
            symplint.from_ode(**({"f": pendulum} | arguments))
