"""Maps that are no steps in time, and periods that are not those of the map."""

import json

import numpy as np
import pytest
import symplint

CENTRE, RADIUS = (2e-3, 1e-3), 8e-3
#: x, y and the path difference of a beam.
BEAM = ([2e-3, 1e-3, 0.0], [1e-3, -1e-3, 3e-3]), ([8e-3, 8e-3, 1e-2], 8e-3)
SIZES = [1.0, 0.5, 0.25]


def kicker(q, p, h=1.0):
    return q, p + 1e-3 * h


def edge(q, p, h=1.0):
    """The fringe field of a magnet: a point transformation."""
    return q + 0.1 * h * q**3, p / (1.0 + 0.3 * h * q**2)


def tilt(q, p, h=1.0):
    """The frame is turned by 3 degrees."""
    angle, pz = np.deg2rad(3.0) * h, np.sqrt(1.0 - p * p)
    t = np.tan(angle)
    return q / (np.cos(angle) * (1.0 - t * p / pz)), p * np.cos(angle) + np.sin(angle) * pz


def drift(rounds):
    """An exact drift of 3 m; the momenta may go through slopes and energies, which rounds them."""

    def step(q, p, h=1.0):
        px, py, pz = p.T
        beta = 0.905
        energy = 1.0 + beta * beta * pz
        total = (energy * energy - (1.0 - beta * beta)) / beta**2
        along = np.sqrt(total - px * px - py * py)
        x, y = q[:, 0] + 3.0 * h * px / along, q[:, 1] + 3.0 * h * py / along
        z = q[:, 2] + 3.0 * h * (1.0 - energy / along)
        if rounds:
            slope = px / along * 1e3
            px = slope * 1e-3 * np.sqrt(total) / np.sqrt(1.0 + (slope * 1e-3) ** 2 + (py / along) ** 2)
            pz = (np.sqrt(total * beta * beta + (1.0 - beta * beta)) - 1.0) / beta / beta
        return np.stack([x, y, z], 1), np.stack([px, py, pz], 1)

    return step


def turn(q, p, h=1.0):
    """One turn of a ring with a tune of 1.6e-3: it ignores h."""
    p = p - 0.01 * np.sin(q)
    return q + 0.01 * p, p


MAPS = {
    "kicker": (kicker, CENTRE, RADIUS, None),
    "edge": (edge, CENTRE, RADIUS, SIZES),
    "edge, a large loop": (edge, CENTRE, 0.5, SIZES),
    "tilt": (tilt, CENTRE, RADIUS, SIZES),
    "drift": (drift(False), *BEAM, SIZES),
    "drift, slopes and back": (drift(True), *BEAM, SIZES),
    "one turn": (turn, (0.3, 0.2), 0.5, [1.0]),
}


@pytest.mark.parametrize("name", MAPS)
@pytest.mark.parametrize("has_step_size", [True, False])
def test_maps_that_are_no_steps_in_time_are_symplectic(name, has_step_size):
    step, (q0, p0), radius, sizes = MAPS[name]
    if has_step_size:
        report = symplint.check(step, q0, p0, radius=radius, step_sizes=sizes)
    else:
        report = symplint.check(lambda q, p: step(q, p), q0, p0, radius=radius, step_sizes="none")
    assert report.kind == "symplectic", report
    assert report.digits > 11
    assert not any("larger step sizes" in advice for advice in report.advice)
    if not has_step_size:
        assert "radii up to" in report.summary
        assert "step size" not in str(report) and "h =" not in str(report)
        points = json.loads(report.to_json())["points"]
        assert all(point["step_size"] is None for point in points)


@pytest.mark.parametrize("lost", [1e-2, 1e-5, 1e-9])
@pytest.mark.parametrize("name", MAPS)
def test_damped_maps_are_not(name, lost):
    step, (q0, p0), radius, _ = MAPS[name]

    def damped(q, p):
        q, p = step(q, p)
        return q, (1.0 - lost) * p

    report = symplint.check(damped, q0, p0, radius=radius, step_sizes="none")
    assert report.kind == "not-symplectic" and report.order is None, report


@pytest.mark.parametrize("arguments", [{}, {"per_sample": True}, {"q0": np.zeros((2, 3)), "p0": np.ones((2, 3))}])
def test_a_map_that_forgets_to_return_is_an_error(arguments):
    def forgets(q, p):
        p = 3.0 * p

    arguments = {"q0": 1.0, "p0": 0.5, "step_sizes": "none", "budget": 1000} | arguments
    with pytest.raises(symplint.StepError, match="forgets returned nothing and left its arrays as they were; return q, p"):
        symplint.check(forgets, **arguments)

    def kicks_some(q, p):
        p[q > 1.9] += 1e-3

    assert symplint.check(kicks_some, **arguments).evaluations > 0
    assert symplint.check(lambda q, p: (q, p), **arguments).kind == "symplectic"


def test_an_accurate_method_at_small_steps_is_not_called_symplectic():
    def rk4(q, p, h):
        def slope(q, p):
            return p, -np.sin(q)

        k1 = slope(q, p)
        k2 = slope(q + 0.5 * h * k1[0], p + 0.5 * h * k1[1])
        k3 = slope(q + 0.5 * h * k2[0], p + 0.5 * h * k2[1])
        k4 = slope(q + h * k3[0], p + h * k3[1])
        sums = [a + 2 * b + 2 * c + d for a, b, c, d in zip(k1, k2, k3, k4, strict=True)]
        return q + h / 6 * sums[0], p + h / 6 * sums[1]

    report = symplint.check(rk4, 1.0, 0.5, step_sizes=[1e-3, 5e-4])
    assert report.kind == "undecided", report
    # A given name decides.
    near = float(report.advice[0].split("near ")[1].split(":")[0])
    assert symplint.check(rk4, 1.0, 0.5, step_sizes=[near, near / 2]).kind == "not-symplectic"


def test_repetitions_compose_the_map_with_itself():
    calls = 0

    def counted(q, p):
        nonlocal calls
        calls += 1
        return turn(q, p)

    # One state at a time: batches have copies of rows, which are no evaluations.
    report = symplint.check(counted, 0.3, 0.2, radius=0.5, step_sizes="none", repeat=20, per_sample=True)
    assert report.kind == "symplectic", report
    assert report.evaluations == calls <= 20_000
    assert "repeat" in report.to_dict()["config"]["check"]
    with pytest.raises(symplint.InputError, match="repeat"):
        symplint.check(counted, 0.3, 0.2, step_sizes="none", repeat=0)


def test_what_is_given_in_place_of_step_sizes():
    with pytest.raises(symplint.InputError, match='give step sizes, or "none"'):
        symplint.check(kicker, *CENTRE, step_sizes="auto")
    with pytest.raises(symplint.InputError, match="make"):
        symplint.check(kicker, *CENTRE, step_sizes="none", make=True)
    with pytest.raises(symplint.InputError, match="both"):
        symplint.check(kicker, *CENTRE, step_sizes="none", typical_step=0.1)


def test_failures_of_maps_without_a_step_size():
    def fails(q, p):
        raise ValueError("no beam")

    with pytest.raises(symplint.StepError) as raised:
        symplint.check(fails, *CENTRE, step_sizes="none")
    assert raised.value.h is None and isinstance(raised.value.__cause__, ValueError)
    with pytest.raises(symplint.StepError) as raised:
        symplint.check(lambda q, p: (np.full_like(q, np.nan), p), *CENTRE, step_sizes="none")
    assert raised.value.h is None and "h =" not in str(raised.value)


def test_a_map_of_one_state_without_a_step_size():
    def one(q, p):
        return q, p - 0.1 * q**2

    report = symplint.check(one, *CENTRE, radius=RADIUS, step_sizes="none", per_sample=True, budget=2000)
    assert report.kind == "symplectic", report
    assert report.to_dict()["config"]["check"]["step_sizes"] == "none"
    assert "the map" in report.to_html()


def leapfrog(q, p, h):
    q = q + 0.5 * h * p
    p = p - h * np.sin(q)
    return q + 0.5 * h * p, p


@pytest.mark.parametrize("period", [6.28, 6.2831853, 6.283185307, 3.0, 10.0])
def test_a_period_that_is_not_one_of_the_map_is_named(period):
    def wraps(q, p, h):
        q, p = leapfrog(q, p, h)
        return q % (2.0 * np.pi), p

    random = np.random.default_rng(0)
    for _ in range(4):
        q0, p0, radius = random.uniform(-3, 3), random.uniform(-1, 1), 10 ** random.uniform(-2, 0)
        report = symplint.check(leapfrog, q0, p0, radius=radius, period=period)
        assert report.kind == "symplectic", report
        assert any(text.startswith(f"{period:.10g} is not a period of q[0]") for text in report.evidence)
        report = symplint.check(leapfrog, q0, p0, radius=radius, period=2 * np.pi)
        assert report.kind == "symplectic" and "not a period" not in str(report)
    # Loops that cross the end of the box cannot do without it.
    with pytest.raises(symplint.InputError, match=rf"{period:.10g} is not a period of q\[0\]"):
        symplint.check(wraps, 0.1, 0.5, period=period)


def test_periods_of_momenta_are_tried_as_well():
    def standard_map(q, p):
        p = p + 0.7 * np.sin(q)
        return q + p, p

    periods = {"period": 2 * np.pi, "step_sizes": "none", "radius": 0.3}
    report = symplint.check(standard_map, 1.0, 0.5, momentum_period=2 * np.pi, **periods)
    assert report.kind == "symplectic" and "not a period" not in str(report)
    report = symplint.check(standard_map, 1.0, 0.5, momentum_period=5.0, **periods)
    assert report.kind == "symplectic" and "5 is not a period of p[0]" in str(report)
