"""Steps in velocities whose canonical momenta are M(q) v."""

import numpy as np
import pytest
import symplint

STATE = ([1.0, -0.4], [0.5, 0.2])
SIZES = {"step_sizes": [0.1, 0.05], "radius": 0.2, "budget": 4000, "loops": 3}


def masses(q):
    """The mass matrix of a double pendulum of unit masses and lengths."""
    coupling = np.cos(q[..., 0] - q[..., 1])
    one = np.ones_like(coupling)
    return np.stack([np.stack([2 * one, coupling], axis=-1), np.stack([coupling, one], axis=-1)], axis=-2)


def rates(q, v):
    swing = np.sin(q[..., 0] - q[..., 1])
    force = np.stack([-swing * v[..., 1] ** 2 - 2 * np.sin(q[..., 0]), swing * v[..., 0] ** 2 - np.sin(q[..., 1])], axis=-1)
    return v, np.linalg.solve(masses(q), force[..., None])[..., 0]


def rk4(q, v, h):
    k1 = rates(q, v)
    k2 = rates(q + h / 2 * k1[0], v + h / 2 * k1[1])
    k3 = rates(q + h / 2 * k2[0], v + h / 2 * k2[1])
    k4 = rates(q + h * k3[0], v + h * k3[1])
    return (start + h / 6 * (a + 2 * b + 2 * c + d) for start, a, b, c, d in zip((q, v), k1, k2, k3, k4, strict=True))


def flow(q, v, h):
    """The flow to rounding: small steps of a method of order 4."""
    for _ in range(150):
        q, v = rk4(q, v, h / 150)
    return q, v


def energy(q, v):
    kinetic = 0.5 * (v[..., None, :] @ masses(q) @ v[..., None])[..., 0, 0]
    return kinetic - 2 * np.cos(q[..., 0]) - np.cos(q[..., 1])


def test_a_flow_is_symplectic_in_momenta_and_not_in_velocities():
    report = symplint.check(flow, *STATE, mass_matrix=masses, energy=energy, **SIZES)
    assert report.is_symplectic and report.digits > 10, report
    assert report.properties["energy"].holds
    assert symplint.check(flow, *STATE, **SIZES).is_symplectic is False


def test_one_state_at_a_time_is_the_same():
    one = SIZES | {"budget": 400, "mass_matrix": masses}
    assert symplint.check(rk4, *STATE, per_sample=True, **one).kind == symplint.check(rk4, *STATE, **one).kind == "not-symplectic"


def test_a_function_of_many_states_gets_no_single_one():
    def columns(q):
        coupling = np.cos(q[:, 0] - q[:, 1])
        return np.moveaxis(np.array([[2.0 + 0.0 * coupling, coupling], [coupling, 1.0 + 0.0 * coupling]]), -1, 0)

    assert symplint.check(rk4, *STATE, mass_matrix=columns, **SIZES).kind == "not-symplectic"


def test_a_method_that_is_not_symplectic_is_found():
    def euler(q, v, h):
        dq, dv = rates(q, v)
        return q + h * dq, v + h * dv

    grouped = symplint.Coordinates(mass_matrix=masses)
    report = symplint.check(euler, *STATE, coordinates=grouped, radius=0.2, budget=4000)
    assert report.is_symplectic is False and report.order == pytest.approx(2.0, abs=0.2)
    made = symplint.check(lambda h: lambda q, v: euler(q, v, h), *STATE, make=True, coordinates=grouped, radius=0.2, budget=4000)
    assert made.digits == report.digits and made.order == report.order


def test_one_matrix_for_all_states():
    matrix = np.array([[2.0, 0.5], [0.5, 1.0]])

    def drift(q, v, h):
        q += h * v

    def kick(q, v, h):
        v -= h * np.sin(q) @ np.linalg.inv(matrix)

    parts = [("drift", drift), ("kick", kick)]
    assert symplint.check(substeps=parts, q0=STATE[0], p0=STATE[1], mass_matrix=matrix).is_symplectic
    assert symplint.check(substeps=parts, q0=STATE[0], p0=STATE[1]).is_symplectic is False
    without_size = symplint.check(lambda q, v: rk4(q, v, 1.0), *STATE, step_sizes="none", mass_matrix=matrix, radius=0.2)
    assert without_size.is_symplectic is False


def test_mistakes_are_named(tmp_path):
    for arguments, words in (
        ({"mass_matrix": np.ones((3, 3))}, r"mass_matrix has the shape \(3, 3\)"),
        ({"mass_matrix": lambda q: q}, r"mass_matrix\(q\) has the shape"),
        ({"mass_matrix": masses, "weight": 2.0}, "weight is for steps in q and p"),
        ({"mass_matrix": masses, "form": lambda z: z}, "form is for steps"),
    ):
        step = (lambda z, h: z) if "form" in arguments else rk4
        with pytest.raises(symplint.InputError, match=words):
            symplint.check(step, *STATE, **SIZES, **arguments)
    with pytest.raises(symplint.InputError, match="give it, or leave mass_matrix out"):
        symplint.check(symplint.systems.double_pendulum(), mass_matrix=masses)
    with pytest.raises(symplint.StepError, match="ingular"):
        symplint.check(rk4, *STATE, mass_matrix=np.zeros((2, 2)), **SIZES)
    # Another matrix is another run.
    symplint.check(rk4, STATE[0], [0.0, 0.0], mass_matrix=np.eye(2), run_dir=tmp_path, **SIZES)
    with pytest.raises(symplint.InputError, match="mass_matrix"):
        symplint.check(rk4, STATE[0], [0.0, 0.0], mass_matrix=2.0 * np.eye(2), run_dir=tmp_path, **SIZES)
