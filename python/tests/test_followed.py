"""The advice of failing maps, followed to a verdict."""

import numpy as np
import pytest
import symplint

WALL = {"step_sizes": [1.0, 0.5, 0.25], "radius": 0.4}


def fold(q, p, h):
    q = q + h * p
    outside = q < 0
    return np.where(outside, -q, q), np.where(outside, -p, p)


def clip(q, p, h):
    q = q + h * p
    outside = q < 0
    return np.where(outside, 0.0, q), np.where(outside, -p, p)


def freeze(q, p, h):
    moved = q + h * p
    outside = moved < 0
    return np.where(outside, q, moved), np.where(outside, 0.0, p)


@pytest.mark.parametrize(("step", "kind"), [(fold, "wall"), (clip, "clipped"), (freeze, "clipped")])
def test_a_loop_away_from_the_wall(step, kind):
    report = symplint.check(step, [0.5], [-0.5], **WALL)
    assert report.kind == "broken-loops" and report.cause.kind == kind
    assert "no state reaches" in report.advice[0]
    assert symplint.check(step, [3.0], [-0.5], **WALL).kind == "symplectic"


def coupled(masses):
    def step(q, v, h):
        q = q + 0.5 * h * v
        difference = q[:, :, None] - q[:, None, :]
        v = v + h * (-(np.sin(difference) * masses).sum(2) - 0.5 * np.sin(q))
        return q + 0.5 * h * v, v

    return step


def test_weights_that_are_printed():
    step, centre = coupled(np.array([1.0, 1e-4, 1e-2])), ([0.3, 1.0, 2.0], [0.2, -0.1, 0.4])
    report = symplint.check(step, *centre, radius=0.5)
    assert report.cause.kind == "velocities-for-momenta"
    name, weight = report.cause.setting.split(" = ")
    assert name == "weight"
    assert symplint.check(step, *centre, radius=0.5, weight=np.fromstring(weight.strip("[]"), sep=",")).is_symplectic


SIGNS = np.array([1.0, -1.0])


def of_other_sign(q, p, h):
    a = q * SIGNS
    p = p - h * np.stack([np.sin(a[:, 0] - a[:, 1]), np.sin(a[:, 1] - a[:, 0])], 1)
    return (a + h * p) * SIGNS, p


def test_the_sign_of_a_pair():
    centre = ([0.3, 1.0], [0.2, -0.1])
    report = symplint.check(of_other_sign, *centre, radius=0.5)
    assert report.cause.kind == "sign-of-a-pair" and report.cause.setting == "weight = [1, -1]"
    with pytest.raises(symplint.InputError, match="whose radii differ"):
        symplint.check(of_other_sign, *centre, radius=0.5, weight=[1, -1])
    assert symplint.check(of_other_sign, *centre, radius=[0.5, 0.3], weight=[1, -1]).is_symplectic

    def changed(q, p, h):
        q, p = of_other_sign(q * SIGNS, p, h)
        return q * SIGNS, p

    assert symplint.check(changed, *centre, radius=0.5).is_symplectic


def yee(e, b, h):
    b = b - h * (np.roll(e, -1, 1) - e)
    return e - h * (b - np.roll(b, 1, 1)), b


def test_the_fields_of_yee():
    dof = 3
    report = symplint.check(yee, np.zeros(dof), np.ones(dof), radius=0.5)
    assert report.cause.kind == "fields" and "steps of 0.5 alone" in report.advice[0]
    matrix = np.zeros((2 * dof, 2 * dof))
    for entry in report.to_dict()["evidence"]["preserved_form"]["entries"]:
        a, b = entry["coordinates"]
        matrix[a, b], matrix[b, a] = entry["value"], -entry["value"]

    def of_form(z, h):
        return np.concatenate(yee(z[:, :dof], z[:, dof:], h), 1)

    z0 = np.repeat([0.0, 1.0], dof)
    found = symplint.check(of_form, z0, radius=0.5, step_sizes=[0.5], form=lambda z: z @ matrix / 2)
    assert found.is_symplectic

    def of_potential(a, e, h):
        a = a - h * e
        b = np.roll(a, -1, 1) - a
        return a, e - h * (b - np.roll(b, 1, 1))

    assert symplint.check(of_potential, np.zeros(dof), np.ones(dof), radius=0.5).is_symplectic


def kicked(q, p, h):
    q = q + h * p
    return q, p - h * np.sin(q)


@pytest.mark.parametrize("factor", [lambda h: 1 / (1 + 0.01 * h), lambda h: 1 - 0.01 * h])
def test_one_factor_of_all_momenta(factor):
    def step(q, p, h):
        q, p = kicked(q, p, h)
        return q, factor(h) * p

    def multiplied(q, p, h):
        q, p = step(q, p, h)
        return q, p / factor(h)

    centre = ([0.3, 1.0], [0.2, -0.1])
    report = symplint.check(step, *centre, radius=0.5)
    assert report.cause.kind == "friction" and report.properties["conformal"].holds
    assert symplint.check(multiplied, *centre, radius=0.5).is_symplectic


MASSES = np.array([1.0, 2.0, 3.0])


def without_drift(q, p):
    return q, p - MASSES * p.sum(-1, keepdims=True) / MASSES.sum()


def chain(q, p, h):
    def force(q):
        a, b = np.sin(q[:, 0] - q[:, 1]), np.sin(q[:, 1] - q[:, 2])
        return np.stack([-a, a - b, b], -1)

    p = p + 0.5 * h * force(q)
    q = q + h * p / MASSES
    return without_drift(q, p + 0.5 * h * force(q))


def on_manifold(s):
    """A loop of states whose momenta have the sum 0."""
    turns = 2 * np.pi * s[:, None]
    first, second = np.array([1.0, -1.0, 0.0]), np.array([0.0, 1.0, -1.0])
    q = 0.3 * np.sin(turns) * first + 0.2 * np.cos(turns) * second
    p = 0.3 * np.cos(turns) * first + 0.2 * np.sin(turns) * second
    return [0.5, -0.3, 0.1] + q, [0.2, 0.1, -0.3] + p


def test_a_projection_and_loops_on_its_manifold():
    centre = ([0.5, -0.3, 0.1], [0.2, 0.1, -0.3])
    report = symplint.check(chain, *centre)
    assert report.cause.kind == "projection" and "rank 5 of 6" in report.cause.text
    assert "loops = 1 and jacobian = false" in report.advice[0]
    assert symplint.check(chain, *centre, project=without_drift).is_symplectic
    found = symplint.check(chain, *centre, loop=on_manifold, loops=1, jacobian=False)
    assert found.is_symplectic, found
