"""Testing forces and vector fields."""

from __future__ import annotations

import contextlib
import html
import json
import os
import re
from collections.abc import Callable
from typing import Any, NamedTuple, NoReturn

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import Array, coordinates, numbers, vector, whole
from ._check import _absolute, _config, _is_single, _journal, _resumable
from ._errors import InputError, StepError
from ._identity import identity
from ._names import executor_of, one_of, seed_of, tuple_of
from ._report import check_replaceable
from ._shape import broadcast, of_any_shape, shaped
from ._signature import hint
from ._workers import Workers

__all__ = ["Curl", "FieldReport", "WorstPair", "check_field", "check_force"]

#: Evaluations of a force, by default.
BUDGET = 20_000
#: Columns of `FieldReport.loops`.
LOOPS = [
    ("kind", "U11"), ("samples", "i8"), ("integral", "f8"), ("error", "f8"), ("scale", "f8"), ("jumps", "f8"),
]  # fmt: skip


class Curl(NamedTuple):
    """λ = ‖A‖/‖J‖ of a force, with the antisymmetric part A of its Jacobian J in units of the radii.

    Attributes
    ----------
    value, error : float
        λ with half the width of the interval in which it lies.
    pairs : int
        Pairs of directions that were tested.
    all : bool
        Whether they are all pairs of coordinates; otherwise they are random.
    """

    value: float
    error: float
    pairs: int
    all: bool


class WorstPair(NamedTuple):
    """The two coordinates with the largest curl that was found.

    Attributes
    ----------
    first, second : str
        Names such as "q[0]" and "p[2]".
    curl, error : float
        ∂G_second/∂first − ∂G_first/∂second with its error: of the force G = F, or of G = −w f_p for positions and w f_q for
        momenta of weight w.
    """

    first: str
    second: str
    curl: float
    error: float


class FieldReport:
    """The verdict on a force or a vector field, with the measurements behind it.

    Printing it shows a table of the loops, the verdict and the findings.
    """

    def __init__(self, text: str) -> None:
        self._json = text
        self._dict: dict[str, Any] = json.loads(text)

    @property
    def kind(self) -> str:
        """The verdict: "gradient", "not-a-gradient", "hamiltonian", "not-hamiltonian" or "undecided"."""
        return str(self._dict["kind"])

    @property
    def holds(self) -> bool | None:
        """Whether the force is a gradient, or the field Hamiltonian; None if the evidence is not enough."""
        return {"gradient": True, "hamiltonian": True, "undecided": None}.get(self.kind, False)

    @property
    def digits(self) -> float | None:
        """-log10 of the bound on the antisymmetric part of the Jacobian relative to the Jacobian, of a gradient that is not constant."""
        digits: float | None = self._dict["digits"]
        return digits

    @property
    def curl(self) -> Curl | None:
        """The ratio λ with its error; None if no pairs of directions were tested, or the force is constant."""
        found = self._dict["evidence"]["curl"]
        return None if found is None else Curl(**found)

    @property
    def worst(self) -> WorstPair | None:
        """The two coordinates with the largest curl that was found; None if it is zero, or the budget was too small to find them."""
        found = self._dict["evidence"]["worst"]
        if found is None:
            return None
        first, second = (f"{found[of]['coordinate']}[{found[of]['dof']}]" for of in ("first", "second"))
        return WorstPair(first, second, found["curl"], found["error"])

    @property
    def damping(self) -> tuple[float, float] | None:
        """The rate at which a field shrinks the loop integrals of all loops, with its error; None if they do not agree."""
        found = self._dict["evidence"]["damping"]
        return None if found is None else (found[0], found[1])

    @property
    def loops(self) -> npt.NDArray[np.void]:
        """All loops, as a structured array.

        Its fields are ``kind`` ("random", "directions" and "coordinates" for small ellipses, "winding" for a loop around a period),
        ``samples``, ``integral`` (∮F·dq, or ∮(f_q·dp − f_p·dq)), ``error``, ``scale`` (the size that the integral would have if the force
        were a rotation everywhere) and ``jumps`` (how far the power of the force jumps along the loop, or NaN).
        """
        rows = [_row(loop) for loop in self._dict["evidence"]["loops"]]
        return np.array(rows, dtype=LOOPS)

    @property
    def evaluations(self) -> int:
        """Number of states at which the force was evaluated."""
        return int(self._dict["evidence"]["evaluations"])

    @property
    def summary(self) -> str:
        """The reason for the verdict, as a sentence."""
        return str(self._dict["summary"])

    @property
    def sentences(self) -> list[str]:
        """The other findings, as sentences."""
        return list(self._dict["sentences"])

    @property
    def advice(self) -> list[str]:
        """What to do next, as sentences."""
        return list(self._dict["advice"])

    def to_json(self) -> str:
        """The report as JSON, schema ``symplint/field/1``.

        Returns
        -------
        str
            Its text.
        """
        return self._json

    def to_dict(self) -> dict[str, Any]:
        """The report as a dictionary, with the keys of the JSON.

        Returns
        -------
        dict
            The contents of the JSON.
        """
        return self._dict

    def __bool__(self) -> NoReturn:
        """Raise: a report is neither true nor false."""
        raise TypeError("a report has no truth value: test report.holds, which is True, False or None")

    def __reduce__(self) -> tuple[Any, ...]:
        return FieldReport, (self._json,)

    def __str__(self) -> str:
        return str(self._dict["text"])

    def __repr__(self) -> str:
        digits = "" if self.digits is None else f" to {self.digits} digits"
        return f"<symplint.FieldReport: {self.kind}{digits}>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(str(self))}</pre>"


def check_force(
    force: Callable[..., Any],
    q0: npt.ArrayLike,
    *,
    args: tuple[Any, ...] = (),
    radius: Any = "auto",
    loops: int = 4,
    budget: int | None = None,
    period: npt.ArrayLike | None = None,
    per_sample: bool = False,
    dtype: npt.DTypeLike | None = None,
    rng: Any = None,
    workers: Any = 1,
    threads: int | None = None,
    run_dir: str | os.PathLike[str] | None = None,
    key: str | None = None,
    maxfev: int | None = None,
    seed: int | None = None,
    executor: Any = None,
    out: str | os.PathLike[str] | None = None,
) -> FieldReport:
    """Test whether a force is a gradient.

    The work ∮F·dq around each loop is zero if the force F is a gradient. If it is not a gradient, no step with this
    force is symplectic, and the energy drifts. Such a force is the usual reason for a defect of lower order than the order of the
    method. The test needs no step. The number of evaluations does not depend on the degrees of freedom.

    Parameters
    ----------
    force : callable
        ``force(q)`` gets an array of shape (samples, dof), or (samples, *q0.shape) if `q0` has several axes, and returns one of the
        same shape. The force of a row must depend on this row only. A batch may end with copies of its last row. Results may be
        arrays of any library.
    q0 : array_like
        The centre of the loops: positions of any shape, such as (atoms, 3).
    args : tuple
        Further arguments of `force`.
    radius : float, array_like or "auto"
        Size of the loops: one number, or an array like `q0`. A coordinate with radius 0 is fixed. "auto" is the distance on which the
        force is nearly linear, and at most a tenth of the size of `q0`. Every second loop is four times as large.
    loops : int
        Number of random loops.
    budget : int, optional
        Largest number of states at which the force is evaluated, at least 100. The default is 20,000. A smooth force takes some hundreds.
    period : float or array_like, optional
        Periods of the positions, 0 for positions that are not periodic. The test then also follows loops around up to eight of the
        periods: a constant force on a ring is not a gradient.
    per_sample : bool
        Whether `force` takes and returns one state: arrays of the shape of `q0`.
    dtype : "float32", optional
        If the force computes in single precision: `force` then gets arrays of it.
    rng : int or numpy.random.Generator, optional
        Seed of the random loops and directions; 1 by default.
    workers : int, callable or executor, optional
        Processes or an executor that evaluate the force, as in `check`.
    threads : int, optional
        Threads for the work of the library, as in `check`.
    run_dir, key : optional
        A folder for report.json and for every result of `force`: a test that was stopped resumes there, as in `check`.
    maxfev, seed, executor, out : optional
        Other names of `budget`, `rng`, `workers` and `run_dir`.

    Returns
    -------
    FieldReport
        The verdict, whose `holds` is True, False or None.

    Raises
    ------
    InputError
        If an argument is not valid, or the force does not have a stated period.
    StepError
        If the force fails or is not finite on a loop. Exceptions of `force` are the cause.

    Notes
    -----
    Discontinuous forces, such as forces with a cut-off, give fewer digits and take more evaluations. Their loop integrals are zero if the
    potential is continuous. Otherwise the report shows the jump. The jumps of a solver that stops at a tolerance look like a small curl.
    A curl below a thousandth is therefore reported only if larger loops show no such jumps.

    Examples
    --------
    >>> import numpy as np, symplint
    >>> def force(q, curl):
    ...     x, y = q.T
    ...     return np.column_stack([-x * y**2 - curl * y, -(x**2) * y + curl * x])
    >>> symplint.check_force(force, [1.0, 0.5], args=(0.0,)).kind
    'gradient'
    >>> report = symplint.check_force(force, [1.0, 0.5], args=(1e-9,))
    >>> report.kind
    'not-a-gradient'
    >>> report.worst.first, report.worst.second, f"{report.worst.curl:.4g}"
    ('q[0]', 'q[1]', '2e-09')
    """
    __tracebackhide__ = True
    centre = of_any_shape(q0, "q0")
    step = _Force(force, args, centre.shape, per_sample)
    if not callable(force):
        raise InputError(f"force is an object of type {type(force).__name__}; give a function force(q)")
    sizes = None if _is_auto(radius) else broadcast(radius, "radius", centre.shape)
    return _run(
        step, centre.ravel(), None, radius=sizes, period=None if period is None else broadcast(period, "period", centre.shape), weight=None,
        loops=loops, budget=one_of("budget", budget, "maxfev", maxfev, None), per_sample=per_sample, dtype=dtype,
        rng=one_of("rng", rng, "seed", seed, None), workers=one_of("workers", workers, "executor", executor, 1), threads=threads,
        run_dir=one_of("run_dir", run_dir, "out", out, None), key=key,
    )  # fmt: skip


def check_field(
    field: Callable[..., Any],
    q0: npt.ArrayLike,
    p0: npt.ArrayLike,
    *,
    args: tuple[Any, ...] = (),
    radius: Any = "auto",
    loops: int = 4,
    budget: int | None = None,
    period: npt.ArrayLike | None = None,
    weight: npt.ArrayLike | None = None,
    per_sample: bool = False,
    dtype: npt.DTypeLike | None = None,
    rng: Any = None,
    workers: Any = 1,
    threads: int | None = None,
    run_dir: str | os.PathLike[str] | None = None,
    key: str | None = None,
    maxfev: int | None = None,
    seed: int | None = None,
    executor: Any = None,
    out: str | os.PathLike[str] | None = None,
) -> FieldReport:
    """Test whether the vector field (q, p)' = f(q, p) is Hamiltonian in these variables.

    The integral ∮(f_q·dp − f_p·dq) around each loop is zero if the field is Hamiltonian. If it is not Hamiltonian, an accurate integrator
    cannot be symplectic. The test needs no step.

    Parameters
    ----------
    field : callable
        ``field(q, p)`` gets arrays of shape (samples, dof), or (samples, *q0.shape). It returns two arrays of the same shape: the rates of
        q and the rates of p.
    q0, p0 : array_like
        The centre of the loops, two arrays of one shape.
    args : tuple
        Further arguments of `field`.
    radius : float, array_like, pair of them or "auto"
        Size of the loops: one number, an array like `q0`, or a tuple of the sizes in q and in p. "auto" is the distance on which the field
        is nearly linear. The field then also determines the ratio of the sizes in q and in p.
    loops, budget, period : optional
        As in `check_force`.
    weight : float or array_like, optional
        The canonical momentum is weight × p: masses, if p are velocities.
    per_sample, dtype, rng, workers, threads, run_dir, key, maxfev, seed, executor, out : optional
        As in `check_force`.

    Returns
    -------
    FieldReport
        The verdict, whose `holds` is True, False or None.

    Raises
    ------
    InputError, StepError
        As in `check_force`.

    Examples
    --------
    >>> import numpy as np, symplint
    >>> def pendulum(q, p, friction):
    ...     return p, -np.sin(q) - friction * p
    >>> symplint.check_field(pendulum, 1.0, 0.5, args=(0.0,)).kind
    'hamiltonian'
    >>> report = symplint.check_field(pendulum, 1.0, 0.5, args=(0.1,))
    >>> report.kind, round(report.damping[0], 9)
    ('not-hamiltonian', 0.1)
    """
    __tracebackhide__ = True
    of_q, of_p = of_any_shape(q0, "q0"), of_any_shape(p0, "p0")
    if of_q.shape != of_p.shape:
        raise InputError(f"q0 has the shape {of_q.shape} and p0 {of_p.shape}; give one of both for each degree of freedom")
    if not callable(field):
        raise InputError(f"field is an object of type {type(field).__name__}; give a function field(q, p)")
    step = _Field(field, args, of_q.shape, per_sample)
    sizes = None
    if not _is_auto(radius):
        pair = radius if isinstance(radius, tuple) and len(radius) == 2 else (radius, radius)
        sizes = np.concatenate([broadcast(of, "radius", of_q.shape) for of in pair])
    return _run(
        step, of_q.ravel(), of_p.ravel(), radius=sizes, period=None if period is None else broadcast(period, "period", of_q.shape),
        weight=None if weight is None else broadcast(weight, "weight", of_q.shape), loops=loops,
        budget=one_of("budget", budget, "maxfev", maxfev, None), per_sample=per_sample, dtype=dtype,
        rng=one_of("rng", rng, "seed", seed, None), workers=one_of("workers", workers, "executor", executor, 1), threads=threads,
        run_dir=one_of("run_dir", run_dir, "out", out, None), key=key,
    )  # fmt: skip


class _Force:
    """A force as a step without a step size: positions stay, and momenta become the force."""

    what = "force"

    def __init__(self, function: Callable[..., Any], args: tuple[Any, ...], shape: tuple[int, ...], per_sample: bool) -> None:
        self.function = function
        self.args = tuple_of(args)
        self.shape = shape
        self.per_sample = per_sample
        self.__name__ = str(getattr(function, "__name__", type(function).__name__))

    def __call__(self, q: Any, p: Any, _: float) -> Any:
        # The function may change its argument.
        return q, self.rates(self.function(self.states(q.copy()), *self.args), q, f"{self.what}(q)")

    def states(self, rows: Any) -> Any:
        """States as the function takes them."""
        return rows if len(self.shape) <= 1 else shaped(rows, self.shape, self.per_sample)

    def rates(self, found: Any, rows: Any, name: str) -> Array:
        """What the function returned, as rows."""
        if found is None:
            raise TypeError(f"{name} returned None; return an array")
        array = numbers(found, name)
        # One degree of freedom may be returned without its axis.
        expected = self.states(rows).shape
        if array.shape != expected and not (array.size == rows.size and array.ndim <= 1 and rows.size == max(rows.shape)):
            raise ValueError(f"{name} returned an array of shape {array.shape} for states of shape {expected}; return the same shape")
        return array.reshape(rows.shape)


class _Field(_Force):
    """A vector field as a step without a step size: it returns rates instead of states."""

    what = "field"

    def __call__(self, q: Any, p: Any, _: float) -> Any:
        found = self.function(self.states(q.copy()), self.states(p.copy()), *self.args)
        if not isinstance(found, tuple | list) or len(found) != 2:
            raise TypeError(f"field(q, p) returned an object of type {type(found).__name__}; return two arrays")
        return tuple(self.rates(rates, q, f"field(q, p)[{of}]") for of, rates in enumerate(found))


def _is_auto(radius: Any) -> bool:
    if isinstance(radius, str):
        if radius != "auto":
            raise InputError(f'radius is "{radius}"; give a number, or "auto"')
        return True
    return False


def _run(
    step: _Force,
    q0: Array,
    p0: Array | None,
    *,
    radius: Array | None,
    period: Array | None,
    weight: Array | None,
    loops: int,
    budget: int | None,
    per_sample: bool,
    dtype: Any,
    rng: Any,
    workers: Any,
    threads: int | None,
    run_dir: str | os.PathLike[str] | None,
    key: str | None,
) -> FieldReport:
    __tracebackhide__ = True
    folder = None if run_dir is None else _absolute(run_dir)
    if folder is not None:
        check_replaceable(folder, ("report.json",))
    dof, single = q0.size, _is_single(dtype)
    at_rest = [0.0] * dof
    momenta = at_rest if p0 is None else p0.tolist()
    subject: dict[str, Any] = {
        "integrator": None,
        "step": step,
        "tangents": None,
        "parts": [],
        "per_sample": bool(per_sample),
        "make": False,
        "reset": None,
        "single": single,
        "project": None,
        "energy": None,
        "reversal": None,
        "form": False,
        "dof": dof,
        "coordinates": coordinates(dof, period, None, weight),
        "native_loop": None,
        "phase_loop": None,
        "q0": q0.tolist(),
        "p0": momenta,
        "radii": (at_rest, at_rest),
        "phases": ("staggered", 0),
        "threads": None if threads is None else whole(threads, "threads", 1),
        "workers": None,
    }
    settings = {
        "is_force": p0 is None,
        "q0": q0.tolist(),
        "p0": momenta,
        "radius": None if radius is None else vector(radius, "radius").tolist(),
        "loops": whole(loops, "loops", 1),
        "budget": whole(BUDGET if budget is None else budget, "budget", 100),
        "seed": whole(1 if rng is None else seed_of(rng), "rng", 0),
    }
    with executor_of(workers) as executor, contextlib.ExitStack() as stack:
        if executor is not None:
            pool = Workers(executor, step, per_sample=bool(per_sample), make=False, single=single, reset=None)
            subject["workers"] = stack.enter_context(contextlib.closing(pool))
        journal = None
        if folder is not None:
            config = _config(step.__name__, subject, settings | {"test": step.what, "args": repr(step.args)}, None)
            journal = _journal(folder, identity({step.what: step.function}, key), config, subject)
        stack.enter_context(_resumable(folder))
        try:
            report = FieldReport(_native.check_field(subject, settings, journal))
        except StepError as error:
            text = _of_force(str(error), step.what)
            if remedy := hint(error, bool(per_sample), step.what):
                text = f"{text}; {remedy}"
            raise StepError(text, None, error.s, error.sample) from error.__cause__
    if subject["workers"] is not None:
        subject["workers"].warn()
    if folder is not None:
        path = os.path.join(folder, "report.json")
        with open(f"{path}.part", "w", encoding="utf-8") as file:
            file.write(report.to_json())
        os.replace(f"{path}.part", path)
    return report


def _of_force(text: str, what: str) -> str:
    """The text of an error in the words of a force or a field."""
    if what == "force":
        text = re.sub(r"^p\[(\d+)\]", r"F[\1]", text)
    else:
        text = re.sub(r"^([qp])\[(\d+)\]", r"f_\1[\2]", text)
    return text.replace("the map", f"the {what}")


def _row(loop: dict[str, Any]) -> tuple[Any, ...]:
    """A loop of the JSON as a row."""
    kind = loop["kind"] if isinstance(loop["kind"], str) else next(iter(loop["kind"]))
    error = loop["quadrature_error"] + loop["noise"]
    jumps = np.nan if loop["jumps"] is None else loop["jumps"]
    return kind, loop["samples"], loop["integral"], error, loop["scale"], jumps
