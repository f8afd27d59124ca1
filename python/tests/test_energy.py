"""Whether a step conserves the energy that the user gives."""

import numpy as np
import pytest
import symplint

SIZES = {"step_sizes": [0.25, 0.125, 0.0625]}
CENTRE = ([0.3, 0.5], [0.5, 0.1])


def energy(q, p):
    return 0.5 * (p**2).sum(axis=-1) + 0.25 * (q**4).sum(axis=-1)


def leapfrog(q, p, h):
    p = p - 0.5 * h * q**3
    q = q + h * p
    return q, p - 0.5 * h * q**3


def average_vector_field(q0, p0, h):
    """G. R. W. Quispel and D. I. McLaren, J. Phys. A 41, 045206 (2008), for a quartic potential."""
    q, p = q0, p0
    for _ in range(60):
        force = -0.25 * (q0**3 + q0**2 * q + q0 * q**2 + q**3)
        q, p = q0 + 0.5 * h * (p0 + p), p0 + h * force
    return q, p


@pytest.mark.parametrize("per_sample", [False, True])
def test_energy_is_conserved_or_changes(per_sample):
    arguments = SIZES | {"energy": energy, "per_sample": per_sample, "budget": 5000}
    report = symplint.check(average_vector_field, *CENTRE, **arguments)
    assert report.kind == "not-symplectic"
    found = report.properties["energy"]
    assert found.holds and found.defect < 1e-14, found
    report = symplint.check(leapfrog, *CENTRE, **arguments)
    found = report.properties["energy"]
    assert report.kind == "symplectic" and found.holds is False
    # The defect of leapfrog goes as h^3 if h is small.
    large, half = (
        symplint.check(leapfrog, *CENTRE, **(arguments | {"step_sizes": [h, h / 2]})).properties["energy"] for h in (0.02, 0.01)
    )
    assert large.defect / half.defect == pytest.approx(8, rel=0.1)
    small = symplint.check(leapfrog, *CENTRE, step_sizes=[0.04, 0.02, 0.01], energy=energy).properties["energy"]
    assert small.order == 3 and "in proportion to h³" in small.text, small
    assert report.properties["energy"].defect > 0 and large.order is None
    assert "energy" not in symplint.check(leapfrog, *CENTRE, **SIZES).properties


def test_many_steps_show_whether_the_energy_drifts():
    def runge_kutta(q, p, h):
        q_half, p_half = q + 0.5 * h * p, p - 0.5 * h * q**3
        return q + h * p_half, p - h * q_half**3

    for step, growth, words in (
        (leapfrog, "bounded", "the change stays bounded"),
        (runge_kutta, "grows", "the energy drifts"),
    ):
        arguments = SIZES | {"radius": 0.3, "steps": 200, "loops": 1}
        report = symplint.check(step, *CENTRE, **arguments, energy=energy)
        found = report.properties["energy"]
        assert found.growth == growth and words in found.text, found.text
        more = report.evaluations - symplint.check(step, *CENTRE, **arguments).evaluations
        assert 0 <= more <= 80


def test_few_evaluations_are_for_the_order_alone():
    sizes = {"step_sizes": [2.0**-k for k in range(2, 10)]}
    without = symplint.check(leapfrog, *CENTRE, **sizes).evaluations
    with_energy = symplint.check(leapfrog, *CENTRE, **sizes, energy=energy)
    assert without < with_energy.evaluations <= without + 80
    conserved = [symplint.check(average_vector_field, *CENTRE, **SIZES, energy=of).evaluations for of in (energy, None)]
    assert conserved[0] == conserved[1]


def test_an_energy_in_non_canonical_coordinates():
    def splitting(z, h):
        x, y = z.T
        x *= np.exp(h * (1.0 - y))
        y *= np.exp(h * (x - 1.0))

    def form(z):
        x, y = z.T
        return np.column_stack([-np.log(y) / x, 0.0 * y])

    def conserved(z):
        return (z - np.log(z)).sum(axis=1)

    report = symplint.check(splitting, [1.0, 1.5], radius=0.4, form=form, energy=conserved)
    assert report.properties["energy"].holds is False

    def unchanged(z, h):
        return z

    report = symplint.check(unchanged, [1.0, 1.5], radius=0.4, form=form, energy=conserved)
    assert report.properties["energy"].holds


def test_what_is_refused():
    for arguments, words in (
        ({"energy": 3}, "give a function of q and p"),
        ({"energy": energy, "properties": False}, "properties is False"),
        ({"energy": lambda q, p: p}, "energy returns an array of shape"),
    ):
        with pytest.raises(symplint.InputError, match=words):
            symplint.check(leapfrog, *CENTRE, **SIZES, **arguments)

    def fails(q, p):
        raise ZeroDivisionError("mass 0")

    with pytest.raises(ZeroDivisionError, match="mass 0"):
        symplint.check(leapfrog, *CENTRE, **SIZES, energy=fails)
    report = symplint.check(leapfrog, *CENTRE, **SIZES, energy=lambda q, p: np.full(len(q), np.nan))
    assert "energy" not in report.properties
    assert any("is not finite" in sentence for sentence in report.sentences)
