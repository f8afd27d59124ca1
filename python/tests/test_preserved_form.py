"""Steps in other variables than canonical ones: the report names the form that the step preserves, and its setting is the remedy."""

import json

import numpy as np
import pytest
import symplint

MASSES = np.array([1.0, 1e-4, 1e-2])
THREE = ([0.3, 1.0, 2.0], [0.2, -0.1, 0.4])
TWO = ([0.3, 1.0], [0.2, -0.1])


def bodies(q, v, h):
    q = q + 0.5 * h * v
    distance = q[:, :, None] - q[:, None, :]
    v = v + h * (-(np.sin(distance) * MASSES[None, None, :]).sum(2) - 0.5 * np.sin(q))
    return q + 0.5 * h * v, v


def other_sign(q, p, h):
    a = q * np.array([1.0, -1.0])
    p = p - h * np.stack([np.sin(a[:, 0] - a[:, 1]), np.sin(a[:, 1] - a[:, 0])], 1)
    a = a + h * p
    return a * np.array([1.0, -1.0]), p


def permuted(q, p, h):
    a = p[:, [1, 0]]
    a = a - h * np.stack([np.sin(q[:, 0] - q[:, 1]) + np.sin(q[:, 0]), np.sin(q[:, 1] - q[:, 0])], 1)
    return q + h * a, a[:, [1, 0]]


def in_field(x, v, h):
    """The push of Boris in a uniform field."""
    x = x + 0.5 * h * v
    kick = -0.5 * h * np.stack([x[:, 0] + 2 * x[:, 0] * x[:, 1], x[:, 1] + x[:, 0] ** 2 - x[:, 1] ** 2], 1)
    v = v + kick
    t = 0.35 * h
    s = 2 * t / (1 + t * t)
    turned = v + t * np.stack([v[:, 1], -v[:, 0]], 1)
    v = v + s * np.stack([turned[:, 1], -turned[:, 0]], 1) + kick
    return x + 0.5 * h * v, v


def yee(E, B, h):
    B = B - h * (np.roll(E, -1, 1) - E)
    return E - h * (B - np.roll(B, 1, 1)), B


def over_reference(q, p, h):
    q = q + h * p
    p = p - h * np.sin(q)
    return q, p / (1 + 0.01 * h)


def friction(q, p, h):
    q = q + h * p
    return q, (p - h * np.sin(q)) * (1 - 0.01 * h)


def curl(q, p, h):
    p = p - h * np.stack([np.sin(q[:, 0] - q[:, 1]) + q[:, 0] ** 3 + 0.1 * q[:, 1], np.sin(q[:, 1] - q[:, 0]) - 0.1 * q[:, 0]], 1)
    return q + h * p, p


@pytest.mark.parametrize(
    ("step", "centre", "kind", "setting"),
    [
        (bodies, THREE, "velocities-for-momenta", "weight = [1, 0.0001, 0.01]"),
        (other_sign, TWO, "sign-of-a-pair", "weight = [1, -1]"),
        (permuted, TWO, "pairs-permuted", "p = p[:, [1, 0]]"),
        (in_field, TWO, "kinetic-momenta", None),
        (yee, (np.zeros(6), np.ones(6)), "fields", None),
        (over_reference, TWO, "friction", None),
        (friction, TWO, "friction", None),
        (curl, TWO, "force-with-curl", None),
    ],
)
def test_the_form_is_named(step, centre, kind, setting):
    report = symplint.check(step, *centre, radius=0.5)
    assert report.kind == "not-symplectic"
    assert report.cause.kind == kind, report.cause
    if setting is not None:
        assert report.cause.setting == setting
        assert f"symplectic to {report.cause.digits} digits with {setting}" in report.headline
    assert report.advice[0] == report.cause.remedy


def test_the_setting_makes_the_step_symplectic():
    assert symplint.check(bodies, *THREE, radius=0.5, weight=[1, 0.0001, 0.01]).is_symplectic
    assert symplint.check(other_sign, *TWO, radius=[0.5, 0.4], weight=[1, -1]).is_symplectic


def test_the_matrix_of_a_form_is_a_one_form():
    report = symplint.check(in_field, *TWO, radius=0.5)
    setting = report.cause.setting
    assert setting.startswith("form = lambda z: z @ Ω / 2 with Ω = [[")
    omega = np.array(json.loads(setting.split("Ω = ")[1]))
    h = report.to_dict()["evidence"]["preserved_form"]["step_size"]

    def of_all(z, h):
        return np.concatenate(in_field(z[:, :2], z[:, 2:], h), axis=1)

    found = symplint.check(of_all, np.concatenate(TWO), radius=0.5, form=lambda z: z @ omega / 2, step_sizes=[h])
    assert found.is_symplectic, str(found)
