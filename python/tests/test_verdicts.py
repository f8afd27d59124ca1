"""Verdicts on maps whose answer is known."""

import numpy as np
import pytest
import symplint


def verlet(q, p, h):
    p = p + 0.5 * h * -np.sin(q)
    q = q + h * p
    return q, p + 0.5 * h * -np.sin(q)


def rk4(q, p, h):
    def slope(q, p):
        return p, -np.sin(q)

    k1 = slope(q, p)
    k2 = slope(q + 0.5 * h * k1[0], p + 0.5 * h * k1[1])
    k3 = slope(q + 0.5 * h * k2[0], p + 0.5 * h * k2[1])
    k4 = slope(q + h * k3[0], p + h * k3[1])
    sums = [a + 2 * b + 2 * c + d for a, b, c, d in zip(k1, k2, k3, k4, strict=True)]
    return q + h / 6 * sums[0], p + h / 6 * sums[1]


def rk4_of(force):
    """Runge-Kutta 4 in several degrees of freedom."""

    def step(q, p, h):
        k1 = p, force(q)
        k2 = p + 0.5 * h * k1[1], force(q + 0.5 * h * k1[0])
        k3 = p + 0.5 * h * k2[1], force(q + 0.5 * h * k2[0])
        k4 = p + h * k3[1], force(q + h * k3[0])
        sums = [a + 2 * b + 2 * c + d for a, b, c, d in zip(k1, k2, k3, k4, strict=True)]
        return q + h / 6 * sums[0], p + h / 6 * sums[1]

    return step


def pendulum_chain(q):
    return -np.sin(q) + 0.3 * (np.roll(q, 1, axis=1) + np.roll(q, -1, axis=1) - 2 * q)


def product_of_squares(q):
    return -q * q[:, ::-1] ** 2


def test_velocity_verlet_is_symplectic():
    report = symplint.check(verlet, 1.0, 0.5)
    assert report.kind == "symplectic" and report.is_symplectic is True
    assert report.digits > 13.5
    assert report.evaluations <= 20_000


def test_velocity_verlet_in_single_precision():
    seen = set()

    def step(q, p, h):
        seen.update((q.dtype, p.dtype))
        q, p = verlet(q, p, np.float32(h))
        assert q.dtype == np.float32
        return q, p

    report = symplint.check(step, [1.0, -0.4], [0.5, 0.2], step_sizes=[0.5, 0.25, 0.125], dtype="float32")
    assert seen == {np.dtype("float32")}
    assert report.kind == "symplectic"
    assert 5.0 < report.digits < 8.5


def test_rk4_has_order_6_in_one_degree_of_freedom_and_5_in_several():
    sizes = 0.5 ** np.arange(1, 7)
    assert symplint.check(rk4, 1.0, 0.5, step_sizes=sizes).order == 6
    report = symplint.check(rk4_of(product_of_squares), [1.0, 0.7], [0.5, -1.0], radius=0.3, step_sizes=sizes)
    assert report.kind == "not-symplectic" and report.is_symplectic is False
    assert report.order == 5
    # Terms of order 5 and 6 are as large as each other at these step sizes.
    report = symplint.check(rk4_of(pendulum_chain), [1.0, 0.5, -0.3], [0.5, 0.1, 0.2], step_sizes=sizes)
    assert report.kind == "not-symplectic" and report.order is None


def test_scipy_steps_are_not_symplectic():
    integrate = pytest.importorskip("scipy.integrate")

    def step(q, p, h):
        solution = integrate.solve_ivp(
            lambda _, state: (state[1], -np.sin(state[0])), (0.0, h), (q[0], p[0]), method="RK45", rtol=1e-3, atol=1e-6
        )
        return solution.y[:, -1][:1], solution.y[:, -1][1:]

    report = symplint.check(step, 1.0, 0.5, step_sizes=[1.0, 0.5, 0.25], per_sample=True, budget=2000, loops=3)
    assert report.kind in ("not-symplectic", "broken-loops")


def test_a_leapfrog_with_staggered_velocities():
    # Velocities belong to times half a step earlier: as a map of the numbers that the code stores, it is symplectic Euler.
    def step(q, v, h):
        v = v + h * -np.sin(q)
        return q + h * v, v

    assert symplint.check(step, 1.0, 0.5).kind == "symplectic"

    # A code that starts each step from velocities of the same time, and returns staggered ones, is not the map of a
    # Hamiltonian flow to any order, but it is one: a kick by h/2, then a drift.
    def started_anew(q, v, h):
        v = v + 0.5 * h * -np.sin(q)
        return q + h * v, v

    assert symplint.check(started_anew, 1.0, 0.5).kind == "symplectic"


def test_masses_are_weights_of_velocities():
    mass = np.array([1.0, 3.0])

    def step(q, v, h):
        v = v - h * np.sin(q.sum(axis=1, keepdims=True)) / mass
        return q + h * v, v

    arguments = {"step_sizes": [0.5, 0.25, 0.125]}
    assert symplint.check(step, [1.0, 0.3], [0.5, 0.2], **arguments).kind == "not-symplectic"
    assert symplint.check(step, [1.0, 0.3], [0.5, 0.2], weight=mass, **arguments).kind == "symplectic"


TURN = 2.0 * np.pi


def standard_map(q, p, h):
    p = p + 0.9 * h * np.sin(q)
    return (q + h * p) % TURN, p % TURN


def test_periods_of_momenta():
    # The torus: a loop that lies across p = 2π comes back on both sides of it.
    arguments = {"step_sizes": [2.0, 1.0], "radius": 0.5, "period": TURN}
    report = symplint.check(standard_map, 3.0, 6.0, momentum_period=TURN, **arguments)
    assert report.kind == "symplectic" and report.digits > 12, str(report)
    assert report.to_dict()["config"]["check"]["momentum_period"] == [TURN]
    # Without the period, wrapped momenta are jumps.
    assert symplint.check(standard_map, 3.0, 6.0, **arguments).kind == "broken-loops"

    def contracted(q, p, h):
        return standard_map(q, 0.99 * p, h)

    report = symplint.check(contracted, 3.0, 6.0, momentum_period=TURN, **arguments)
    assert report.kind != "symplectic", str(report)

    # The same numbers as for the system of the library.
    torus = symplint.systems.standard_map(strength=0.9, torus=True, q0=3.0, p0=6.0)
    ours = symplint.check(torus, step_sizes=[2.0, 1.0], radius=0.5, loops=1, jacobian=False)
    theirs = symplint.check(standard_map, 3.0, 6.0, momentum_period=TURN, **arguments, loops=1, jacobian=False)
    assert np.allclose(ours.points["final"], theirs.points["final"], rtol=1e-13, atol=0.0)

    q, p = symplint.circle(3.0, 6.0, radius=0.5)
    q1, p1 = standard_map(q, p, 1.0)
    assert np.ptp(p1) > 6.0
    periods = {"period": TURN, "momentum_period": TURN}
    assert symplint.measure((q, p), (q1, p1), h=1.0, **periods).kind == "symplectic"
    assert symplint.measure((q, p), (q1, p1), h=1.0, period=TURN).kind != "symplectic"
    assert abs(symplint.loop_integral(q1, p1, **periods).value - 0.25 * np.pi) < 1e-13
    # Samples of such a loop as a loop: it leads to the same integral.
    loop = symplint.SampledLoop(q1, p1, **periods)
    report = symplint.check(standard_map, loop=loop, step_sizes=[1.0], loops=1, **periods)
    assert report.kind == "symplectic", str(report)


def test_a_langevin_thermostat_is_not_symplectic():
    # Friction and a noise that is the same for all samples: the map with its noise frozen contracts phase space.
    def step(q, p, h):
        noise = np.random.default_rng(7).standard_normal(q.shape[1])
        p = p - 0.5 * h * np.sin(q)
        q = q + 0.5 * h * p
        p = np.exp(-0.5 * h) * p + np.sqrt(1.0 - np.exp(-h)) * noise
        q = q + 0.5 * h * p
        return q, p - 0.5 * h * np.sin(q)

    report = symplint.check(step, [1.0, 0.2], [0.5, 0.1], step_sizes=[0.5, 0.25, 0.125])
    assert report.kind == "not-symplectic"
    assert report.order == 1


def test_fresh_noise_is_not_called_symplectic():
    random = np.random.default_rng(1)

    def step(q, p, h):
        q, p = verlet(q, p, h)
        return q, p + 0.1 * h * random.standard_normal(p.shape)

    report = symplint.check(step, 1.0, 0.5)
    assert report.kind == "undecided"


def test_state_that_leaks_between_samples_is_named():
    class Thermostat:
        heat = 0.0

        def __call__(self, q, p, h):
            q, p = verlet(q, p, h)
            p = p * (1.0 - 1e-3 * h * self.heat)
            self.heat += float((p**2).mean())
            return q, p

    with pytest.raises(symplint.StepError, match="the result depends on earlier calls") as caught:
        symplint.check(Thermostat(), 1.0, 0.5)
    assert caught.value.h == 0.5 and 0.0 <= caught.value.s < 1.0

    # A reset before every call removes it.
    code = Thermostat()

    def reset():
        code.heat = 1.0

    def of_each(q, p, h):
        q, p = verlet(q, p, h)
        return q, p * (1.0 - 1e-3 * h * code.heat)

    assert symplint.check(of_each, 1.0, 0.5, reset=reset).kind == "not-symplectic"


@pytest.mark.parametrize("kind", ["batches", "per_sample", "make"])
def test_reset_is_called_before_every_call(kind):
    events = []

    def step(q, p, h):
        events.append("step")
        return verlet(q, p, h)

    def make(h):
        return lambda q, p: step(q, p, h)

    # 2,000 samples of 40 degrees of freedom are more than a batch.
    ones = np.ones(40 if kind == "batches" else 1)
    symplint.check(
        make if kind == "make" else step, ones, ones, step_sizes=[0.25], samples=2000 if kind == "batches" else 64,
        loops=1, jacobian=False, budget=20_000, reset=lambda: events.append("reset"),
        **({} if kind == "batches" else {kind: True}),
    )  # fmt: skip
    assert events[::2] == ["reset"] * (len(events) // 2)
    assert events[1::2] == ["step"] * (len(events) // 2)


def test_reset_is_called_while_a_failing_sample_is_looked_for():
    events = []

    def step(q, p, h):
        events.append("step")
        if (q > 1.9).any():
            raise ArithmeticError
        return verlet(q, p, h)

    with pytest.raises(symplint.StepError):
        symplint.check(step, 1.0, 0.5, step_sizes=[0.25], reset=lambda: events.append("reset"))
    assert events == ["reset", "step"] * (len(events) // 2)


def test_a_periodic_position_that_is_wrapped():
    def step(q, p, h):
        q, p = verlet(q, p, h)
        return np.mod(q, 2 * np.pi), p

    sizes = [0.5, 0.25, 0.125]
    assert symplint.check(step, 6.0, 0.5, step_sizes=sizes).kind == "broken-loops"
    assert symplint.check(step, 6.0, 0.5, step_sizes=sizes, period=2 * np.pi).kind == "symplectic"


def test_breaks_are_reported():
    def step(q, p, h):
        p = p - h * np.sign(q)
        return q + h * p, p

    report = symplint.check(step, 0.1, 0.3, step_sizes=[0.5, 0.25])
    assert report.kind == "broken-loops"
    breaks = report.breaks[report.breaks["loop"] == 0]
    # The force changes sign where q does: on the circle q = 0.1 + sin 2πs.
    expected = np.sort(np.mod([np.arcsin(-0.1) / (2 * np.pi), 0.5 - np.arcsin(-0.1) / (2 * np.pi)], 1.0))
    largest = breaks[breaks["step_size"] == 0.5]
    assert np.allclose(np.sort(largest["s"]), expected, atol=1e-12)
    assert np.allclose(np.abs(largest["jump_p"]), 1.0)


def test_many_degrees_of_freedom():
    dof = 300

    def step(q, p, h):
        p = p + h * (-np.sin(q) + 0.3 * (np.roll(q, 1, axis=1) + np.roll(q, -1, axis=1) - 2 * q))
        return q + h * p, p

    q0 = np.linspace(-1.0, 1.0, dof)
    report = symplint.check(step, q0, np.zeros(dof), step_sizes=[0.25, 0.125], loops=3)
    assert report.kind == "symplectic"


def test_many_steps_tell_whether_a_defect_adds_up():
    def damped(q, p, h):
        p -= h * np.sin(q)
        p *= 1 - 0.01 * h
        q += h * p

    report = symplint.check(damped, 0.3, 0.2, radius=0.2, step_sizes=[0.25, 0.125, 0.0625], steps=200)
    found = report.to_dict()["evidence"]["long_time"]
    expected = (1 - 0.01 * 0.25) ** 200 - 1
    assert abs(found["change"] - expected) < 1e-12
    assert abs(found["predicted"][0] - expected) < 1e-12
    assert abs(found["exponent"] - 1) < 0.03
    assert any("adds up in proportion to n, " in sentence for sentence in report.sentences)
    assert report.evaluations < 20_000 + 512 * 200
    with pytest.raises(symplint.InputError, match="steps"):
        symplint.check(damped, 0.3, 0.2, steps=-1)


def test_a_reversal_is_signs_or_a_function():
    def in_a_field(q, p, h):
        def kick(q):
            return -0.5 * h * q * (1.0 + q[:, ::-1] ** 2)

        q = q + 0.5 * h * p
        p = p + kick(q)
        cos, sin = np.cos(0.7 * h), np.sin(0.7 * h)
        p = np.stack([cos * p[:, 0] + sin * p[:, 1], cos * p[:, 1] - sin * p[:, 0]], axis=1)
        p = p + kick(q)
        return q + 0.5 * h * p, p

    def reflected(q, p):
        return q[:, ::-1], -p[:, ::-1]

    arguments = {"q0": [0.1, 0.2], "p0": [0.3, 0.1], "radius": 0.5, "step_sizes": [0.25, 0.125]}
    holds = {}
    reversals = {"none": None, "signs": [1, -1, -1, 1], "function": reflected, "identity": lambda q, p: (q, p)}
    for name, reversal in reversals.items():
        holds[name] = symplint.check(in_a_field, **arguments, reversal=reversal).properties["reversible"].holds
    assert holds == {"none": False, "signs": True, "function": True, "identity": False}
    one = symplint.check(lambda q, p, h: [x[0] for x in in_a_field(q[None], p[None], h)], **arguments, per_sample=True,
                         reversal=lambda q, p: (q[::-1], -p[::-1]))  # fmt: skip
    assert one.properties["reversible"].holds
    with pytest.raises(symplint.InputError, match="is its own inverse"):
        symplint.check(in_a_field, **arguments, reversal=lambda q, p: (q + 1.0, p))
    with pytest.raises(ZeroDivisionError):
        symplint.check(in_a_field, **arguments, reversal=lambda q, p: 1 / 0)
    velocities = symplint.check(in_a_field, **arguments, mass_matrix=np.eye(2), reversal=reflected)
    assert velocities.properties["reversible"].holds
    with pytest.raises(symplint.InputError, match="a step that is a function"):
        symplint.check(symplint.systems.pendulum(), reversal=reflected)


@pytest.mark.parametrize("sequence", [(0, 1, 2, 1, 0), (0, 1, 2)])
def test_a_reversal_of_other_coordinates(sequence):
    """Splittings of a rigid body on the sphere of angular momentum: z → −z reverses the symmetric one."""

    def body(z, h):
        for axis in sequence:
            x, y = (axis + 1) % 3, (axis + 2) % 3
            angle = h * z[:, axis] / (sequence.count(axis) * (axis + 1.0))
            cos, sin = np.cos(angle), np.sin(angle)
            z[:, x], z[:, y] = cos * z[:, x] + sin * z[:, y], cos * z[:, y] - sin * z[:, x]

    def form(z):
        x, y, w = z.T
        return np.column_stack([-y * w, x * w, 0.0 * w]) / (x**2 + y**2)[:, None]

    report = symplint.check(
        body, [0.5, 0.6, 0.7], radius=0.1, form=form, casimir=lambda z: np.sum(z**2, axis=1), reversal=lambda z: -z
    )
    assert report.kind == "symplectic"
    assert report.properties["reversible"].holds == (len(sequence) == 5)
