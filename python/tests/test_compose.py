"""Steps made of named parts: a lattice of thousands of elements, of which the wrong ones are named."""

import numpy as np
import pytest
import symplint


def drift(q, p, h):
    return q + h * p, p


def kick(q, p, h):
    return q, p - h * np.sin(q)


def friction(q, p, h):
    p *= 1 - 0.01 * h


def lattice(cells, wrong=None):
    """A FODO lattice of `cells` cells of two planes, with four elements each; a fringe of the cell `wrong` bends x by a function of y."""

    def drift(q, p):
        return q + 0.1 * p, p

    def quad(k):
        return lambda q, p: (q, p - k * q * np.array([1.0, -1.0]))

    def fringe(q, p):
        kick = np.zeros_like(p)
        kick[:, 0] = 1e-7 * q[:, 1] ** 2
        return q, p + kick

    parts = []
    for cell in range(cells):
        parts += [
            (f"qf{cell}", quad(0.3)),
            (f"d{cell}", drift),
            (f"qd{cell}", fringe if cell == wrong else quad(-0.3)),
            (f"e{cell}", drift),
        ]
    return parts


CENTRE = [1e-3, 2e-3], [0.0, 1e-3]


def test_the_part_that_has_the_defect_is_named():
    parts = [("drift", drift), ("kick", kick), ("friction", friction)]
    report = symplint.check(symplint.compose(*parts), 1.0, 0.5)
    assert report.kind == "not-symplectic"
    found = report.to_dict()["evidence"]["localisation"]["substeps"]
    assert [part["name"] for part in found] == ["drift", "kick", "friction"]
    assert abs(found[2]["change"] + 0.005) < 1e-12
    assert max(abs(part["change"]) for part in found[:2]) < 1e-13
    # A defect of a part is the defect of the same part given alone.
    same = symplint.check(None, 1.0, 0.5, substeps=parts)
    assert same.to_dict()["evidence"]["localisation"]["substeps"] == found


def test_one_wrong_fringe_among_a_thousand_elements_is_named_in_one_more_pass():
    plain = symplint.check(symplint.compose(*lattice(250, 137)), *CENTRE, radius=1e-2, step_sizes="none")
    assert plain.kind == "not-symplectic"
    text = " ".join(plain.sentences)
    assert "Of the 1000 substeps in one application, substep 551 (qd137) changes the loop integral by" in text

    def whole(q, p):
        return symplint.compose(*lattice(250, 137)).without_step_size()(q, p)

    without = symplint.check(whole, *CENTRE, radius=1e-2, step_sizes="none")
    assert plain.evaluations <= 1.5 * without.evaluations
    right = symplint.check(symplint.compose(*lattice(250)), *CENTRE, radius=1e-2, step_sizes="none")
    assert right.kind == "symplectic"
    assert right.to_dict()["evidence"]["localisation"] is None


def test_a_part_that_breaks_loops_is_named():
    def wall(q, p, h):
        o = q < 0
        return np.where(o, -q, q), np.where(o, -p, p)

    report = symplint.check(None, 0.5, -0.5, substeps=[("flight", drift), ("wall", wall)], radius=0.4)
    assert report.kind == "broken-loops"
    assert "substep 2 (wall) breaks the loop" in " ".join(report.sentences)


def test_parts_take_one_state_at_a_time_or_change_it_in_place():
    def rotate(q, p):
        q[0], p[0] = q[0] * np.cos(0.1) + p[0] * np.sin(0.1), p[0] * np.cos(0.1) - q[0] * np.sin(0.1)

    def squeeze(q, p):
        return 2 * q, p / 1.9

    step = symplint.compose(("rotate", rotate), ("squeeze", squeeze))
    report = symplint.check(step, [0.2], [0.1], per_sample=True, step_sizes="none")
    assert "substep 2 (squeeze) changes" in " ".join(report.sentences)
    q, p = step.without_step_size()(np.array([1.0]), np.array([0.0]))
    assert np.allclose([q[0], p[0]], [2 * np.cos(0.1), -np.sin(0.1) / 1.9])


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ([], "no parts are given"),
        ([drift], "part 0 is <function drift"),
        ([("drift", 3)], r"part 0 \(drift\) is an object of type int"),
        ([(3, drift)], "the name of part 0 is 3"),
    ],
)
def test_parts_are_pairs_of_a_name_and_a_function(parts, words):
    with pytest.raises(symplint.InputError, match=words):
        symplint.compose(*parts)
    with pytest.raises(symplint.InputError, match=words):
        symplint.check(None, 1.0, 0.5, substeps=parts)


def test_the_wrong_entry_of_a_linear_element_is_named_and_not_friction():
    def element(x, y):
        def step(q, p):
            new_q = np.stack([x[0] * q[:, 0] + x[1] * p[:, 0], y[0] * q[:, 1] + y[1] * p[:, 1]], 1)
            return new_q, np.stack([x[2] * q[:, 0] + x[3] * p[:, 0], y[2] * q[:, 1] + y[3] * p[:, 1]], 1)

        return step

    angle = 0.3
    focus = [np.cos(angle), np.sin(angle), -np.sin(angle), np.cos(angle)]
    defocus = [np.cosh(angle), np.sinh(angle), np.sinh(angle), np.cosh(angle)]
    # The sine instead of the hyperbolic sine.
    wrong = [np.cosh(angle), np.sin(angle), np.sinh(angle), np.cosh(angle)]
    parts = [("QF", element(focus, defocus)), ("QF wrong", element(focus, wrong)), ("QD", element(defocus, focus))]
    report = symplint.check(None, [0.0, 0.0], [0.0, 0.0], substeps=parts, step_sizes="none")
    assert report.cause.kind == "substep"
    assert "substep 2 (QF wrong)" in report.cause.text


def test_an_error_of_a_part_names_the_part():
    step = symplint.compose(("drift", drift), ("bad", lambda q, p, h: q))
    with pytest.raises(symplint.StepError, match=r"part 1 \(bad\) returned an object of type ndarray; return q and p"):
        symplint.check(step, 1.0, 0.5)

    def fails(q, p, h):
        raise RuntimeError("no table")

    with pytest.raises(RuntimeError, match="no table") as raised:
        symplint.compose(("drift", drift), ("fails", fails))(np.ones((4, 1)), np.ones((4, 1)), 0.1)
    assert raised.value.__notes__ == ["in part 1 (fails)"]


def test_a_step_is_given_once():
    with pytest.raises(symplint.InputError, match="both step and substeps"):
        symplint.check(drift, 1.0, 0.5, substeps=[("drift", drift)])
    with pytest.raises(symplint.InputError, match="step is missing"):
        symplint.check(q0=1.0, p0=0.5)
    with pytest.raises(symplint.InputError, match="make does not work with substeps"):
        symplint.check(symplint.compose(("drift", drift)), 1.0, 0.5, make=True)
