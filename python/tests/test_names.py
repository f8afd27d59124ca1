"""Names of arguments: those of scipy.optimize and SPEC 7, old ones, and groups."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import symplint

CENTRE = [0.3], [0.2]


def step(q, p, h, k=1.0):
    p = p - h * k * np.sin(q)
    return q + h * p, p


def same(one, other):
    return one.to_dict()["evidence"] == other.to_dict()["evidence"]


def test_a_typical_step_is_one_name_and_h_an_old_one():
    report = symplint.check(step, *CENTRE, typical_step=0.1)
    with pytest.warns(DeprecationWarning, match="h is an old name; use typical_step"):
        assert same(report, symplint.check(step, *CENTRE, h=0.1))
    with pytest.raises(symplint.InputError, match="both step_sizes and typical_step"):
        symplint.check(step, *CENTRE, typical_step=0.1, step_sizes=[0.1])


@pytest.mark.parametrize(
    ("new", "old"), [({"budget": 2000}, {"maxfev": 2000}), ({"rng": 3}, {"seed": 3})], ids=["budget", "rng"]
)
def test_an_argument_with_two_names_is_given_once(new, old):
    assert same(symplint.check(step, *CENTRE, **new), symplint.check(step, *CENTRE, **old))
    with pytest.raises(symplint.InputError, match="both .* and .* are given"):
        symplint.check(step, *CENTRE, **new, **old)


def test_random_loops_follow_rng():
    with_three = symplint.check(step, *CENTRE, rng=3)
    assert not same(with_three, symplint.check(step, *CENTRE))
    one, other = (symplint.check(step, *CENTRE, rng=np.random.default_rng(5)) for _ in range(2))
    assert same(one, other)
    with pytest.raises(symplint.InputError, match="rng is an object of type str"):
        symplint.check(step, *CENTRE, rng="5")


def test_run_dir_is_out(tmp_path):
    report = symplint.check(step, *CENTRE, run_dir=tmp_path / "run")
    assert (tmp_path / "run" / "report.json").exists()
    assert same(report, symplint.check(step, *CENTRE, out=tmp_path / "run"))


def test_further_arguments_are_passed_on(tmp_path):
    report = symplint.check(step, *CENTRE, args=(4.0,), run_dir=tmp_path)
    assert same(report, symplint.check(lambda q, p, h: step(q, p, h, 4.0), *CENTRE))
    # Other arguments are another run.
    with pytest.raises(symplint.InputError, match="args"):
        symplint.check(step, *CENTRE, args=(5.0,), run_dir=tmp_path)
    with pytest.raises(symplint.InputError, match="args are for a function.*functools.partial"):
        symplint.check(symplint.compose(("step", step)), *CENTRE, args=(4.0,))
    with pytest.raises(symplint.InputError, match="four.*bind others by functools.partial"):
        symplint.check(symplint.compose(("four", lambda q, p, h, four: (q, p))), *CENTRE)


def test_further_arguments_are_a_tuple():
    calls = (
        lambda args: symplint.check(step, *CENTRE, args=args),
        lambda args: symplint.assert_symplectic(step, *CENTRE, args=args),
        lambda args: symplint.assert_structure(step, *CENTRE, symplectic=True, args=args),
        lambda args: symplint.check_force(lambda q, k: -k * q, CENTRE[0], args=args),
        lambda args: symplint.check_field(lambda q, p, k: (p, -k * q), *CENTRE, args=args),
    )
    for call in calls:
        with pytest.raises(symplint.InputError, match=r"args is 2.0; give a tuple, args=\(2.0,\)"):
            call(2.0)


def test_workers_are_a_number_a_map_or_an_executor():
    report = symplint.check(step, *CENTRE, budget=500)
    with ThreadPoolExecutor(2) as pool:
        for workers in (2, map, pool, pool.map):
            found = symplint.check(step, *CENTRE, budget=500, workers=workers)
            assert found.kind == report.kind and found.digits == report.digits
    assert same(report, symplint.check(step, *CENTRE, budget=500, workers=1))
    for workers in (0, -2, True):
        with pytest.raises(symplint.InputError, match="workers is"):
            symplint.check(step, *CENTRE, workers=workers)
    with pytest.raises(symplint.InputError, match="both workers and executor"):
        symplint.check(step, *CENTRE, workers=2, executor=map)


def test_coordinates_are_the_arguments_of_their_names():
    def of_velocities(q, v, h):
        v = v - h * np.sin(q - q[:, ::-1]) / [1.0, 3.0]
        return q + h * v, v

    centre = [0.3, 1.0], [0.1, 0.2]
    masses = symplint.Coordinates(weight=[1.0, 3.0])
    report = symplint.check(of_velocities, *centre, coordinates=masses)
    assert report.kind == "symplectic"
    assert same(report, symplint.check(of_velocities, *centre, weight=[1.0, 3.0]))
    with pytest.raises(symplint.InputError, match="weight is given twice"):
        symplint.check(of_velocities, *centre, coordinates=masses, weight=[1.0, 3.0])
    with pytest.raises(symplint.InputError, match="coordinates is an object of type list"):
        symplint.check(of_velocities, *centre, coordinates=[1.0, 3.0])
