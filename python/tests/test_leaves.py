"""Degenerate forms: maps that are symplectic on the leaves of Lie–Poisson coordinates, and maps that project."""

import numpy as np
import pytest
import symplint

INERTIA = np.array([1.0, 2.0, 3.0])
CENTRE = np.array([0.6, 0.5, 0.4])


def form(m):
    """m_z dφ, whose derivative is the area form of every sphere."""
    squared = m[:, 0] ** 2 + m[:, 1] ** 2
    return np.stack([-m[:, 2] * m[:, 1] / squared, m[:, 2] * m[:, 0] / squared, 0.0 * squared], axis=1)


def rotated(m, axis, angle):
    j, k = (axis + 1) % 3, (axis + 2) % 3
    cos, sin, after = np.cos(angle), np.sin(angle), m.copy()
    after[:, j] = cos * m[:, j] + sin * m[:, k]
    after[:, k] = cos * m[:, k] - sin * m[:, j]
    return after


def splitting(m, h):
    """A free rigid body: exact flows of m_i²/(2 I_i)."""
    for axis, part in [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)]:
        m = rotated(m, axis, part * h * m[:, axis] / INERTIA[axis])
    return m


def on_sphere(m):
    return m * np.linalg.norm(CENTRE) / np.linalg.norm(m, axis=1, keepdims=True)


def midpoint_on_sphere(m, h):
    """The explicit midpoint rule, put back on the sphere of its state: not symplectic."""
    half = m + 0.5 * h * np.cross(m, m / INERTIA)
    after = m + h * np.cross(half, half / INERTIA)
    return after * np.linalg.norm(m, axis=1, keepdims=True) / np.linalg.norm(after, axis=1, keepdims=True)


def damped_spin(m, h):
    """Precession about z, and relaxation towards it, on the sphere of the state."""
    after = rotated(m, 2, h) + 0.2 * h * (np.array([0.0, 0.0, 1.0]) - m)
    return after * np.linalg.norm(m, axis=1, keepdims=True) / np.linalg.norm(after, axis=1, keepdims=True)


def squared(m):
    return (m**2).sum(axis=1)


def loop_on_leaf(s):
    size = np.linalg.norm(CENTRE)
    axis = CENTRE / size
    a = np.cross(axis, [0.0, 0.0, 1.0])
    a /= np.linalg.norm(a)
    angle = 2.0 * np.pi * np.asarray(s)[:, None]
    return size * (np.cos(0.4) * axis + np.sin(0.4) * (np.cos(angle) * a + np.sin(angle) * np.cross(axis, a)))


LEAVES = [{"casimir": squared}, {"casimir": [squared]}, {"project": on_sphere}, {"casimir": lambda m: np.exp(squared(m))}]


@pytest.mark.parametrize("leaf", LEAVES)
def test_on_its_leaf_a_rigid_body_is_symplectic(leaf):
    report = symplint.check(splitting, CENTRE, radius=0.2, form=form, **leaf)
    assert report.kind == "symplectic" and report.digits > 12.0, report
    assert any("Loops and Jacobian agree" in text for text in report.sentences)
    given = symplint.check(splitting, CENTRE, loop=loop_on_leaf, form=form, **leaf)
    assert given.kind == "symplectic" and given.digits > 12.0, given


@pytest.mark.parametrize("step", [midpoint_on_sphere, damped_spin])
@pytest.mark.parametrize("leaf", LEAVES)
def test_on_its_leaf_a_map_that_is_not_symplectic_is_convicted(step, leaf):
    report = symplint.check(step, CENTRE, radius=0.2, form=form, **leaf)
    assert report.kind == "not-symplectic", report
    assert any("Loops and Jacobian agree" in text for text in report.sentences)


@pytest.mark.parametrize("step", [splitting, midpoint_on_sphere, damped_spin])
def test_off_its_leaf_nothing_is_convicted(step):
    report = symplint.check(step, CENTRE, radius=0.2, form=form)
    assert report.kind == "undecided", report
    assert "rank 2 of 3" in report.summary
    assert any("casimir" in advice and "project" in advice for advice in report.advice)


def test_a_given_loop_on_the_leaf_is_not_outvoted():
    arguments = {"loop": loop_on_leaf, "form": form}
    report = symplint.check(splitting, CENTRE, **arguments)
    assert report.kind == "undecided" and "your loop is conserved to" in report.summary, report
    assert symplint.check(splitting, CENTRE, loops=1, jacobian=False, **arguments).kind == "symplectic"


def two_spins(z, h):
    """Two spins that precess about their sum: the exact flow."""
    a, b = z[:, :3], z[:, 3:]
    total = a + b
    size = np.linalg.norm(total, axis=1, keepdims=True)
    axis, cos, sin = total / size, np.cos(h * size), np.sin(h * size)

    def turned(x):
        return x * cos + np.cross(x, axis) * sin + axis * (x * axis).sum(axis=1, keepdims=True) * (1.0 - cos)

    return np.concatenate([turned(a), turned(b)], axis=1)


def form_of_two(z):
    return np.concatenate([form(z[:, :3]), form(z[:, 3:])], axis=1)


def test_two_spins_have_two_casimirs():
    centre = [0.6, 0.5, 0.4, -0.3, 0.6, 0.5]
    casimirs = [lambda z: squared(z[:, :3]), lambda z: squared(z[:, 3:])]
    arguments = {"radius": 0.15, "form": form_of_two}
    for casimir, words in [(None, "rank 4 of 6"), (casimirs[:1], "rank 4 of 5")]:
        report = symplint.check(two_spins, centre, casimir=casimir, **arguments)
        assert report.kind == "undecided" and words in report.summary, report
    # A function of the others adds nothing.
    redundant = [*casimirs, lambda z: squared(z[:, :3]) + squared(z[:, 3:])]
    for casimir in (casimirs, redundant):
        report = symplint.check(two_spins, centre, casimir=casimir, **arguments)
        assert report.kind == "symplectic" and report.digits > 12.0, report


def test_one_state_at_a_time():
    def step(m, h):
        return splitting(m[None, :], h)[0]

    arguments = {"radius": 0.2, "step_sizes": [0.5, 0.25]}
    one = symplint.check(
        step, CENTRE, form=lambda m: form(m[None, :])[0], casimir=lambda m: m @ m, per_sample=True, **arguments
    )
    of_rows = symplint.check(splitting, CENTRE, form=form, casimir=squared, **arguments)
    assert one.kind == of_rows.kind == "symplectic", one
    assert np.allclose(one.points["defect"], of_rows.points["defect"], atol=1e-13)


def test_units_do_not_matter():
    units = np.array([1e-6, 1e4, 1.0])

    def step(z, h):
        return splitting(z / units, h) * units

    report = symplint.check(
        step, CENTRE * units, radius=0.2 * units, form=lambda z: form(z / units) / units, casimir=lambda z: squared(z / units)
    )
    assert report.kind == "symplectic" and report.digits > 12.0, report


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"casimir": 3, "form": form}, "casimir is an object of type int"),
        ({"casimir": [squared, None], "form": form}, "casimir is an object of type NoneType"),
        ({"casimir": lambda m: m, "form": form}, r"casimir\(z\) has shape \(1, 3\); return an array of shape \(1,\)"),
        ({"casimir": lambda m: np.log(-squared(m)), "form": form}, "not finite at q0"),
        ({"casimir": squared}, "give a form as well"),
        ({"project": lambda m: m[:, :1], "form": form}, r"project\(z\) has shape"),
    ],
)
def test_bad_input_is_an_error(arguments, message):
    with np.errstate(all="ignore"), pytest.raises(symplint.InputError, match=message):
        symplint.check(splitting, CENTRE, **({"form": None} | arguments), p0=None if "form" in arguments else CENTRE)


MASSES = np.array([1.0, 2.0, 3.0])


def without_drift(q, p):
    return q, p - MASSES * p.sum(-1, keepdims=True) / MASSES.sum()


def forces(q):
    a, b = np.sin(q[:, 0] - q[:, 1]), np.sin(q[:, 1] - q[:, 2])
    return np.stack([-a, a - b, b], axis=-1)


def verlet(q, p, h):
    p = p + 0.5 * h * forces(q)
    q = q + h * p / MASSES
    return without_drift(q, p + 0.5 * h * forces(q))


def midpoint(q, p, h):
    half_q, half_p = q + 0.5 * h * p / MASSES, p + 0.5 * h * forces(q)
    return without_drift(q + h * half_p / MASSES, p + h * forces(half_q))


def test_a_step_that_removes_the_centre_of_mass_projects():
    centre = [0.5, -0.3, 0.1], [0.2, 0.1, -0.3]
    for step, kind in ((verlet, "symplectic"), (midpoint, "not-symplectic")):
        report = symplint.check(step, *centre)
        assert report.kind == "not-symplectic", report
        assert "rank 5 of 6" in str(report)
        assert any("project" in advice for advice in report.advice)
        assert not any("wrong sign" in advice for advice in report.advice)
        projected = symplint.check(step, *centre, project=without_drift)
        assert projected.kind == kind, projected


def curl(q, p, h):
    """A force between two particles that is not a gradient."""
    force = 0.3 * np.stack([q[:, 0] - q[:, 1], q[:, 0] - q[:, 1]], axis=1) ** 2 * [1.0, -1.0]
    force += 0.2 * np.stack([-q[:, 1], q[:, 0]], axis=1)
    p = p + h * force
    return q + h * p, p


def test_the_default_circle_tests_pairs():
    centre = [0.3, -0.4], [0.1, 0.2]
    staggered = symplint.check(curl, *centre, loops=1, jacobian=False)
    assert staggered.kind == "not-symplectic" and staggered.points["defect"].max() > 1e-2, staggered
    equal = symplint.check(curl, *centre, phases="equal", loops=1, jacobian=False)
    assert equal.points["defect"].max() < 1e-13, equal
    with pytest.raises(symplint.InputError, match="phases is 'golden'|phases is \"golden\""):
        symplint.check(curl, *centre, phases="golden")
    with pytest.raises(symplint.InputError, match="both loop and phases"):
        symplint.check(curl, *centre, phases="equal", loop=symplint.Circle(*centre))
