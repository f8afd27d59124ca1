"""Maps in non-canonical coordinates: `form=`."""

from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
import symplint


def form(z):
    """ϑ = −(ln y / x) dx of Lotka–Volterra: dϑ = dx∧dy/(xy)."""
    x, y = z.T
    return np.column_stack([-np.log(y) / x, 0.0 * y])


def splitting(z, h):
    x, y = z.T
    x *= np.exp(h * (1.0 - y))
    y *= np.exp(h * (x - 1.0))


def midpoint(z, h):
    def field(z):
        x, y = z.T
        return np.column_stack([x * (1.0 - y), y * (x - 1.0)])

    return z + h * field(z + 0.5 * h * field(z))


def canonical(step):
    """The same step of u = ln x and v = −ln y."""

    def of_logarithms(u, v, h):
        z = np.column_stack([np.exp(u), np.exp(-v)])
        after = step(z, h)
        x, y = (z if after is None else after).T
        return np.log(x)[:, None], -np.log(y)[:, None]

    return of_logarithms


def circle(s):
    return np.column_stack([1.0 + 0.4 * np.sin(2 * np.pi * s), 1.5 + 0.4 * np.cos(2 * np.pi * s)])


def circle_of_logarithms(s):
    x, y = circle(s).T
    return np.log(x)[:, None], -np.log(y)[:, None]


@pytest.mark.parametrize(("step", "kind", "order"), [(splitting, "symplectic", None), (midpoint, "not-symplectic", 3.0)])
def test_numbers_are_those_of_canonical_coordinates(step, kind, order):
    step_sizes = [0.5, 0.25, 0.125, 0.0625]
    of_form = symplint.check(step, [1.0, 1.5], form=form, loop=circle, step_sizes=step_sizes)
    of_logarithms = symplint.check(canonical(step), 0.0, -0.4, loop=circle_of_logarithms, step_sizes=step_sizes)
    for report in (of_form, of_logarithms):
        assert report.kind == kind and report.order == order, report
    # Random loops are others.
    given = [report.points[report.points["loop"] == 0]["signed_defect"] for report in (of_form, of_logarithms)]
    assert len(given[0]) == 4 and np.allclose(*given, rtol=0.0, atol=1e-13)
    assert "2 coordinates" in str(of_form)
    assert any("Loops and Jacobian agree" in text for text in of_form.sentences), of_form


def test_a_circle_has_an_area_in_every_plane():
    # Three coordinates: ω = dx∧dy, z is conserved by rotations about it.
    def rotation(z, h):
        x, y, axis = z.T
        return np.column_stack([x * np.cos(h) - y * np.sin(h), x * np.sin(h) + y * np.cos(h), axis])

    def area(z):
        x, y, _ = z.T
        return np.column_stack([-0.5 * y, 0.5 * x, 0.0 * x])

    report = symplint.check(rotation, [0.5, 0.2, 0.1], radius=[0.3, 0.3, 0.2], form=area, casimir=lambda z: z[:, 2], jacobian=False)
    assert report.kind == "symplectic" and report.digits > 12, report


def test_one_state_at_a_time_and_factories():
    def one(z, h):
        z = z.copy()
        splitting(z[None, :], h)
        return z

    def of_one(z):
        return form(z[None, :])[0]

    arguments = {"radius": 0.4, "form": of_one, "per_sample": True, "step_sizes": [0.5, 0.25]}
    of_steps = symplint.check(one, [1.0, 1.5], **arguments)
    made = symplint.check(lambda h: lambda z: one(z, h), [1.0, 1.5], make=True, **arguments)
    whole = symplint.check(splitting, [1.0, 1.5], radius=0.4, form=form, step_sizes=[0.5, 0.25])
    assert of_steps.kind == "symplectic"
    assert of_steps.points.tobytes() == made.points.tobytes() == whole.points.tobytes()


def test_runs_go_on_and_processes_take_steps(tmp_path):
    arguments = {"radius": 0.4, "form": form, "step_sizes": [0.5, 0.25]}
    first = symplint.check(midpoint, [1.0, 1.5], out=tmp_path, **arguments)
    again = symplint.check(midpoint, [1.0, 1.5], out=tmp_path, **arguments)
    assert again.to_dict()["provenance"]["replayed"] == first.evaluations
    with pytest.raises(symplint.InputError, match="step"):
        symplint.check(splitting, [1.0, 1.5], out=tmp_path, **arguments)

    def other(z):
        return 2.0 * form(z)

    with pytest.raises(symplint.InputError):
        symplint.check(midpoint, [1.0, 1.5], out=tmp_path, **(arguments | {"form": other}))
    with ProcessPoolExecutor(2) as pool:
        found = symplint.check(midpoint, [1.0, 1.5], executor=pool, **arguments)
    assert found.points.tobytes() == symplint.check(midpoint, [1.0, 1.5], **arguments).points.tobytes()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"form": 3}, "form is an object of type int"),
        ({"form": lambda z: z[:, :1]}, r"form\(z\) has shape \(1, 1\) and z \(1, 2\)"),
        ({"p0": [1.0]}, "p0 is for canonical coordinates; with a form, pass only z0, period and form"),
        ({"weight": 2.0}, "weight is for canonical coordinates"),
        ({"project": 3}, "project is an object of type int"),
        ({"radius": "auto"}, "radius is 'auto'"),
        ({"loop": symplint.Circle(0.0, 0.0)}, "give a function of s that returns z"),
        ({"radius": 2.0, "loop": circle}, "both loop and radius"),
    ],
)
def test_bad_input_is_an_error(arguments, message):
    with pytest.raises(symplint.InputError, match=message):
        symplint.check(splitting, [1.0, 1.5], **({"form": form} | arguments))
