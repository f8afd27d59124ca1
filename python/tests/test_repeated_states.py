"""Steps whose results depend on earlier calls or on the batch, are rounded or random, or ignore h."""

import numpy as np
import pytest
import symplint


def leapfrog(q, p, h):
    q = q + 0.5 * h * p
    p = p - h * np.sin(q)
    return q + 0.5 * h * p, p


def network(kind):
    """Leapfrog with the gradient of a network as its force: matrix products round differently in batches of other sizes."""
    random = np.random.default_rng(0)
    first = random.normal(size=(3, 64)).astype(kind)
    bias = random.normal(size=64).astype(kind)
    last = (random.normal(size=64) / 64).astype(kind)

    def step(q, p, h):
        q, p, h = q.astype(kind), p.astype(kind), kind(h)
        q = q + h / 2 * p
        p = p - h * (((1 - np.tanh(q @ first + bias) ** 2) * last) @ first.T + q)
        return q + h / 2 * p, p

    return step


@pytest.mark.parametrize("arguments", [{}, {"dtype": "float32"}, {"per_sample": True}])
def test_rounding_in_single_precision_that_depends_on_the_batch_is_no_memory(arguments):
    report = symplint.check(network(np.float32), np.zeros(3), np.full(3, 0.3), **arguments)
    assert report.kind == "symplectic" and 5.9 < report.digits < 8.5
    damped = network(np.float32)

    def step(q, p, h):
        q, p = damped(q, p, h)
        return q, np.float32(0.98) * p

    assert symplint.check(step, np.zeros(3), np.full(3, 0.3), **arguments).kind == "not-symplectic"


def test_cancellation_in_a_stiffness_matrix_is_no_memory():
    random = np.random.default_rng(1)
    factor = random.normal(size=(60, 60))
    stiffness = 1e4 * factor @ factor.T

    def step(q, p, h):
        p = p - h * q @ stiffness
        return q + h * p, p

    h = 0.5 / np.sqrt(np.linalg.norm(stiffness, 2))
    report = symplint.check(step, np.ones(60), np.zeros(60), radius=0.3, step_sizes=[h, h / 2, h / 4])
    assert report.kind == "symplectic"


def sorts_rows(q, p, h):
    q, p = leapfrog(q, p, h)
    order = np.argsort(q[:, 0])
    return q[order], p[order]


def removes_mean(least):
    def step(q, p, h):
        q, p = leapfrog(q, p, h)
        return q, p - 0.1 * p.mean(0) if len(q) > least else p

    return step


def damps_remainder(width):
    def step(q, p, h):
        q, p = leapfrog(q, p, h)
        p = p.copy()
        p[len(q) - len(q) % width :] *= 0.99
        return q, p

    return step


def mixes_neighbours(q, p, h):
    q, p = leapfrog(q, p, h)
    return q, p + (0.1 * np.roll(q, 1, axis=0) if len(q) > 20 else 0)


@pytest.mark.parametrize(
    "step", [sorts_rows, removes_mean(16), removes_mean(100), damps_remainder(32), damps_remainder(64), mixes_neighbours]
)
def test_rows_that_mix_are_refused(step):
    with pytest.raises(symplint.StepError, match="depends on .*the other rows of the batch"):
        symplint.check(step, 1.0, 0.5)


@pytest.mark.parametrize("after", [100, 1000, 4000])
@pytest.mark.parametrize("change", [lambda p: p + 0.1, lambda p: 0.999 * p])
def test_a_late_change_is_refused(after, change):
    states = 0

    def step(q, p, h):
        nonlocal states
        states += len(q)
        q, p = leapfrog(q, p, h)
        return q, change(p) if states > after else p

    with pytest.raises(symplint.StepError, match="depends on earlier calls"):
        symplint.check(step, 1.0, 0.5)


class LennardJones:
    """Three atoms in the plane; the pairs of a neighbour list interact."""

    def __init__(self, cutoff=2.25, skin=0.15):
        self.cutoff, self.skin, self.reference = cutoff, skin, None

    def force(self, x):
        apart = x[:, None] - x[None]
        squared = (apart**2).sum(-1) + np.eye(3)
        if self.reference is None or abs(x - self.reference).max() > self.skin / 2:
            self.reference = x.copy()
            self.pairs = (squared < (self.cutoff + self.skin) ** 2) & ~np.eye(3, dtype=bool)
        return (np.where(self.pairs, 48 * squared**-7 - 24 * squared**-4, 0.0)[..., None] * apart).sum(1).ravel()

    def step(self, q, p, h):
        p = p + h / 2 * self.force(q.reshape(3, 2))
        q = q + h * p
        return q, p + h / 2 * self.force(q.reshape(3, 2))


@pytest.mark.parametrize("radius", [(0.1, 0.3), (np.array([0.1, 0.02, 0.05, 0.1, 0.02, 0.08]), 0.3)])
def test_a_neighbour_list_that_is_kept_is_refused(radius):
    q0 = np.array([0, 0, 1.25, 0, 1.9, 1.45])
    p0 = np.array([0.1, 0, -0.1, 0.2, 0, -0.1])
    arguments = {"per_sample": True, "radius": radius, "step_sizes": [0.08, 0.04, 0.02]}
    with pytest.raises(symplint.StepError, match="depends on earlier calls"):
        symplint.check(LennardJones().step, q0, p0, **arguments)
    fresh = symplint.check(lambda q, p, h: LennardJones().step(q, p, h), q0, p0, **arguments)
    assert fresh.kind == "broken-loops"


@pytest.mark.parametrize("size", [1e-2, 1e-3, 1e-4, 1e-6])
def test_random_numbers_are_named_and_the_same_ones_decide(size):
    random = np.random.default_rng(0)

    def step(q, p, h):
        p = p - h * np.sin(q)
        q = q + h * p
        return q, p + size * np.sqrt(h) * random.normal(size=p.shape)

    report = symplint.check(step, 1.0, 0.5)
    assert report.kind == "undecided"
    assert "draws random numbers" in report.summary
    assert len(report.advice) == 1 and "give every row and every call the same ones" in report.advice[0]

    def followed(q, p, h):
        p = p - h * np.sin(q)
        q = q + h * p
        return q, p + size * np.sqrt(h) * np.random.default_rng(0).normal(size=p.shape[1])

    assert symplint.check(followed, 1.0, 0.5).kind == "symplectic"


def test_a_step_that_ignores_h_is_named():
    report = symplint.check(lambda q, p, h: leapfrog(q, p, 0.3), 1.0, 0.5)
    assert any("ignores h" in sentence for sentence in report.evidence)
    assert not any("ignores h" in sentence for sentence in symplint.check(leapfrog, 1.0, 0.5).evidence)


def test_a_random_loop_is_named():
    random = np.random.default_rng(0)

    def loop(s):
        angle = 2 * np.pi * np.asarray(s)[:, None]
        return 1.0 + 0.3 * np.sin(angle), 0.5 + 0.3 * np.cos(angle) + 1e-3 * random.normal(size=angle.shape)

    with pytest.raises(symplint.InputError, match="the loop function is random"):
        symplint.check(leapfrog, 1.0, 0.5, loop=loop)
