"""States of several axes: q0 of shape (atoms, 3), and arrays of shape (samples, atoms, 3) for the step."""

import json

import numpy as np
import pytest

import symplint

ATOMS = (4, 3)
MASSES = np.array([1.0, 2.0, 0.5, 3.0])
RANDOM = np.random.default_rng(5)
Q0, P0 = RANDOM.normal(size=ATOMS), RANDOM.normal(size=ATOMS)


def force(q):
    """Springs between all pairs, with a cubic term, and a spring to the origin."""
    d = q[..., :, None, :] - q[..., None, :, :]
    return -q - np.sum(d + 0.1 * d**3, axis=-2)


def verlet(q, v, h):
    q = q + 0.5 * h * v
    v = v + h * force(q) / MASSES[:, None]
    return q + 0.5 * h * v, v


def in_place(q, v, h):
    q += 0.5 * h * v
    v += h * force(q) / MASSES[:, None]
    q += 0.5 * h * v


def of_rows(q, v, h):
    shape = (len(q), *ATOMS)
    q, v = verlet(q.reshape(shape), v.reshape(shape), h)
    return q.reshape(len(q), -1), v.reshape(len(v), -1)


def check(step, q0=Q0, p0=P0, **arguments):
    arguments = {"radius": 0.2, "weight": MASSES[:, None], "step_sizes": [0.05, 0.025], "loops": 2, "budget": 8000} | arguments
    return symplint.check(step, q0, p0, **arguments)


def result(report):
    found = json.loads(report.to_json())
    return found["verdict"], found["evidence"]


def test_reports_are_those_of_rows():
    rows = result(check(of_rows, Q0.ravel(), P0.ravel(), weight=np.repeat(MASSES, 3)))
    assert rows[0]["kind"] == "symplectic"
    for step, arguments in ((verlet, {}), (in_place, {}), (lambda h: lambda q, v: verlet(q, v, h), {"make": True})):
        assert result(check(step, **arguments)) == rows
    assert result(check(verlet, per_sample=True))[0]["kind"] == "symplectic"


def test_all_functions_get_states_of_the_shape():
    seen = set()

    def energy(q, v):
        seen.add(q.shape[1:])
        kinetic = 0.5 * np.sum(MASSES[:, None] * v**2, axis=(1, 2))
        d = q[:, :, None] - q[:, None]
        return kinetic + 0.5 * np.sum(q**2, axis=(1, 2)) + np.sum(0.25 * d**2 + 0.0125 * d**4, axis=(1, 2, 3))

    def reversal(q, v):
        seen.add(q.shape[1:])
        return q, -v

    def loop(s):
        s = 2.0 * np.pi * s[:, None, None]
        return Q0 + 0.2 * np.sin(s + Q0), P0 + 0.2 * np.cos(s + P0)

    report = check(verlet, energy=energy, reversal=reversal, loop=loop, radius=None)
    assert report.kind == "symplectic"
    assert seen == {ATOMS}
    assert report.properties["reversible"].holds
    assert 0.0 < report.properties["energy"].defect < 0.1


def test_a_derivative_of_the_user():
    def jvp(q, v, h, dq, dv):
        assert q.shape[1:] == dv.shape[1:] == ATOMS
        dq = dq + 0.5 * h * dv
        q = q + 0.5 * h * v
        d, dd = q[:, :, None] - q[:, None], dq[:, :, None] - dq[:, None]
        dv = dv + h * (-dq - np.sum(dd + 0.3 * d**2 * dd, axis=2)) / MASSES[:, None]
        return dq + 0.5 * h * dv, dv

    report = check(verlet, jvp=jvp)
    assert report.kind == "symplectic"
    assert json.loads(report.to_json())["evidence"]["jacobian"]["method"]["kind"] == "tangent-map"


def test_parts_and_maps_without_step_size():
    def drift(q, v):
        q += 0.05 * v

    def kick(q, v):
        v += 0.05 * force(q) / MASSES[:, None]

    def friction(q, v):
        v *= 0.99

    report = symplint.check(
        substeps=[("drift", drift), ("kick", kick), ("friction", friction)], q0=Q0, p0=P0, step_sizes="none", radius=np.full(3, 0.2),
        weight=MASSES[:, None], budget=8000,
    )  # fmt: skip
    assert report.kind == "not-symplectic"
    assert "substep 3 (friction)" in " ".join(report.sentences)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"p0": P0.ravel()}, r"q0 has the shape \(4, 3\) and p0 \(12,\)"),
        ({"weight": MASSES}, r"weight has the shape \(4,\) and q0 \(4, 3\)"),
        ({"radius": [0.1, 0.2]}, r"radius has the shape \(2,\) and q0 \(4, 3\)"),
        ({"radius": -1.0}, "radius is -1.0"),
        ({"mass_matrix": np.eye(12), "weight": None}, r"q0 has the shape \(4, 3\).*q0.ravel"),
        ({"step": lambda z, h: z, "form": lambda z: z, "p0": None, "weight": None}, r"q0 has the shape \(4, 3\).*q0.ravel"),
    ],
)
def test_arguments_of_another_shape_are_refused(arguments, message):
    with pytest.raises(symplint.InputError, match=message):
        check(**({"step": verlet} | arguments))


def test_results_of_another_shape_are_refused():
    with pytest.raises(symplint.StepError, match="shape"):
        check(lambda q, v, h: (q[:, 0], v[:, 0]))
    with pytest.raises(symplint.InputError, match="shape"):
        symplint.check(symplint.systems.pendulum(), [[1.0]], [[0.5]])


def test_steps_that_jax_compiled_are_differentiated():
    jax = pytest.importorskip("jax")

    @jax.jit
    def step(q, v, h):
        q = q + 0.5 * h * v
        v = v - h * (q + 0.1 * q**3) / MASSES[:, None]
        return q + 0.5 * h * v, v

    report = check(step)
    assert report.kind == "symplectic"
    assert json.loads(report.to_json())["evidence"]["jacobian"]["method"]["kind"] == "tangent-map"
