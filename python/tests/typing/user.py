"""A file as users write it: type checkers accept it, and know every type in it."""

from typing import TYPE_CHECKING, Any, assert_type

import numpy as np
import numpy.typing as npt
import symplint

Array = npt.NDArray[np.float64]


def step(q: Array, p: Array, h: float) -> tuple[Array, Array]:
    p = p - h * np.sin(q)
    return q + h * p, p


def in_place(q: Array, p: Array, h: float) -> None:
    p -= h * np.sin(q)
    q += h * p


report = symplint.check(step, [1.0], 0.5, step_sizes=[0.5, 0.25], radius=(1.0, [2.0]), budget=2000)
assert_type(report, symplint.Report)
assert_type(report.kind, str)
assert_type(report.is_symplectic, bool | None)
assert_type(report.digits, float | None)
assert_type(report.evidence, list[str])
assert_type(report.evaluations, int)
assert_type(report.to_dict(), dict[str, Any])
assert_type(report.to_json(), str)
symplint.assert_symplectic(in_place, 1.0, 0.5, digits=10, loops=3)

integral = symplint.loop_integral(*symplint.circle(0.0, 0.0, radius=1.0, samples=64))
assert_type(integral.value, float)
assert_type(integral.quadrature_error, float | None)

circle = symplint.Circle([0.0, 1.0], [1.0, 0.0], radius=0.1, dofs=[0])
q, p = circle.sample(32)
assert_type(q, Array)
assert_type(symplint.measure((q, p), step(q, p, 0.1), h=0.1), symplint.Report)

strang = symplint.integrators.strang(symplint.systems.pendulum(p0=0.25), variant="position-first")
assert_type(strang, symplint.integrators.Integrator)
assert_type(strang.system.q0, Array)
if TYPE_CHECKING:
    # Choices are types.
    symplint.systems.pendulum(potential="tan")  # type: ignore[arg-type]
    symplint.integrators.strang(symplint.systems.pendulum(), variant="kick-first")  # type: ignore[arg-type]
    symplint.integrators.euler(symplint.systems.pendulum(), tolerance=1e-9)  # type: ignore[call-arg]
assert_type(strang([1.0], [0.5], 0.1), tuple[Array, Array])
assert_type(symplint.check(strang, h=0.1).order, float | None)

force = symplint.check_force(np.negative, [1.0, 0.5], radius=0.1, budget=1000)
assert_type(force, symplint.FieldReport)
assert_type(force.holds, bool | None)
assert_type(force.evaluations, int)
assert_type(symplint.check_field(lambda q, p: (p, -q), 1.0, 0.5, weight=2.0).damping, tuple[float, float] | None)
if (curl := force.curl) is not None:
    assert_type(curl.value, float)

try:
    symplint.check(step, 1.0, 0.5)
except symplint.StepError as error:
    assert_type(error.h, float | None)
    assert_type(error.sample, int | None)
except symplint.NotSymplecticError as error:
    assert_type(error.report, symplint.Report)
