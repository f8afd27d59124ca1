"""Diagnosing a map."""

from __future__ import annotations

import contextlib
import difflib
import hashlib
import inspect
import json
import math
import os
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import coordinates, cutoffs, vector, whole
from ._compose import Composition, compose
from ._derivatives import Tangents, derivatives_of_jax, given, traced
from ._energy import EnergyOfRows
from ._errors import InputError, NotSymplecticError, StepError, StructureError, UndecidedError
from ._form import CircleOfForm, FormOfRows, Leaf, LoopOfForm, MapOfForm, Projection, one_form
from ._identity import identity
from ._loops import Loop, centre, phases_and_seed, radii
from ._mass_matrix import EnergyOfVelocities, MassMatrix, StepOfVelocities
from ._progress import bar
from ._report import Report, States, check_replaceable
from ._names import Coordinates, WithArguments, WithoutStepSize, executor_of, one_of, seed_of, tuple_of
from ._shape import Shaped, axes, broadcast, of_any_shape
from ._signature import TIMES, check_signature, hint
from ._workers import Workers
from .adapters import AdaptedStep
from .integrators import Integrator, of_system
from .systems import System

__all__ = ["assert_structure", "assert_symplectic", "check"]

#: Evaluations of a map that is called through Python.
BUDGET = 20_000
#: More of them for each of many steps.
BUDGET_OF_A_STEP = 512
#: Evaluations of a system of the library, as the program has it.
BUDGET_COMPILED = 1_000_000
#: Arrays with more numbers than this are not repeated in reports.
MAX_VALUES = 16


def check(
    step: Callable[..., Any] | Integrator | System | AdaptedStep | None = None,
    q0: npt.ArrayLike | None = None,
    p0: npt.ArrayLike | None = None,
    *,
    substeps: list[tuple[str, Callable[..., Any]]] | None = None,
    args: tuple[Any, ...] = (),
    step_sizes: npt.ArrayLike | None = None,
    typical_step: float | None = None,
    repeat: int = 1,
    radius: Any = None,
    phases: str = "staggered",
    loop: Loop | Callable[..., Any] | None = None,
    loops: int = 8,
    rng: Any = None,
    rule: str | None = "auto",
    cutoff: float | tuple[float, float] = 1000.0,
    samples: int | str = "auto",
    budget: int | str | None = None,
    coordinates: Coordinates | None = None,
    period: npt.ArrayLike | None = None,
    momentum_period: npt.ArrayLike | None = None,
    weight: npt.ArrayLike | None = None,
    project: Callable[..., Any] | None = None,
    form: Callable[..., Any] | None = None,
    casimir: Callable[..., Any] | list[Callable[..., Any]] | None = None,
    mass_matrix: Callable[..., Any] | npt.ArrayLike | None = None,
    per_sample: bool = False,
    make: bool = False,
    reset: Callable[[], object] | None = None,
    dtype: npt.DTypeLike | None = None,
    jacobian: bool | str = True,
    jvp: Callable[..., Any] | None = None,
    properties: bool = True,
    reversal: npt.ArrayLike | Callable[..., Any] | None = None,
    symmetric: bool = False,
    energy: Callable[..., Any] | None = None,
    steps: int = 0,
    workers: Any = 1,
    threads: int | None = None,
    run_dir: str | os.PathLike[str] | None = None,
    key: str | None = None,
    progress: bool | Callable[[int, int, float | None], object] | None = None,
    maxfev: int | None = None,
    seed: int | None = None,
    executor: Any = None,
    out: str | os.PathLike[str] | None = None,
    h: float | None = None,
    **settings: Any,
) -> Report:
    """Test whether a time-advance map is symplectic.

    symplint sends closed loops of states through one step of the map, at several step sizes, and compares the loop integrals ∮ p·dq
    before and after the step.

    Parameters
    ----------
    step : callable
        ``step(q, p, h)`` gets two arrays of shape (samples, dof), or (samples, *q0.shape) if `q0` has several axes. It returns two new
        arrays, or changes them in place and returns None. Each row is one state. The new state of a row must depend on this row and h
        only. The arrays are in Fortran order and have 1, 4, 16, … or 16384 rows (powers of four), so that JAX compiles few versions.
        Rows that fill a batch are copies of the last row, and do not count as evaluations. The step may keep the arrays. Results may be arrays of any order and library, including torch and JAX.
        Integrators of `symplint.integrators` run without Python, and so do systems of `symplint.systems` with their default
        integrator. A step of `symplint.adapters` supplies its own centre, weights and step sizes.
    q0, p0 : array_like
        Centre of the loops: one number for each degree of freedom, in arrays of any shape, such as (atoms, 3). The report numbers them
        as ``q0.ravel()`` does. Not needed for an integrator of the library, for a step of `symplint.adapters`, or with a `loop` of the
        library.
    substeps : list of (str, callable), optional
        The parts of the step with their names, instead of `step`. The first part is applied first: see `compose`. If the whole step
        has a defect, symplint sends one loop through all parts, and names the parts that cause the defect.
    args : tuple
        Further arguments of `step`, after h.
    step_sizes : array_like or "none", optional
        Step sizes to try, 2^-1 … 2^-10 by default. Random loops and the Jacobian are tested at the largest one. "none" is for a map
        without a step size, such as a kicker or one turn of a ring: the step is then ``step(q, p)``.
    typical_step : float, optional
        A step size of your simulation, instead of `step_sizes`. From this size, symplint finds the largest step that moves the loop by
        about a radian, and halves it.
    repeat : int
        The step is composed with itself this number of times.
    radius : float, array_like, pair of them or "auto", optional
        Radius of the loop: a number, or an array with one radius for each degree of freedom. A tuple has the radius in q and the
        radius in p. "auto" takes the size of the loop from the map. The default is 1, or the radius of a step of
        `symplint.adapters`. Not together with `loop`.
    phases : {"staggered", "equal", "random"}
        The point of the circle at which each degree of freedom starts: multiples of the golden ratio, the same point, or random points.
        "equal" is the circle of the paper. All particles then move together, and forces between pairs stay constant. Not together with
        `loop`.
    loop : Circle, FourierLoop, SampledLoop or callable, optional
        A loop instead of the circle around (q0, p0). A function gets an array of s in [0, 1), and returns (q, p) of shape
        (len(s), dof).
    loops : int
        Number of loops, at most 10,000: your loop, and random ones.
    rng : int or numpy.random.Generator, optional
        Seed or generator for random loops and random phases (SPEC 7). The default is 1, so that results repeat.
    rule : {"auto", "pseudospectral", "finite-difference", "piecewise", "streaming"}, optional
        Rule that computes the loop integrals. None means "auto".
    cutoff : float or (float, float), optional
        The λ of the finite-difference rule, or λ_q and λ_p. The rule skips a cell of the loop if |dq/ds| exceeds λ_q times the largest
        |q|, or if |dp/ds| exceeds λ_p times the largest |p|.
    samples : int or "auto"
        Samples of each loop.
    budget : int or "auto", optional
        Largest number of evaluations (states advanced by one step), at least 200. The default is 20,000. "auto" is 1,000,000 for
        integrators of the library, and 20,000 for other steps.
    coordinates : Coordinates, optional
        The next seven arguments in one object.
    period : float or array_like, optional
        Periods of the positions, 0 for positions that are not periodic.
    momentum_period : float or array_like, optional
        Periods of the momenta, as for the standard map on the torus. Loops must not wind around such a torus, because ∮ p·dq has no
        value there.
    weight : float or array_like, optional
        The canonical momentum is weight × p. If p are velocities, pass the masses.
    project : callable, optional
        ``project(q, p)`` puts states on the constraint manifold of the map. It returns or changes them as `step` does. With `form`, it is
        ``project(z)``.
    form : callable, optional
        The one-form ϑ of non-canonical coordinates z. Its derivative is the symplectic form. ``form(z)`` gets an array of shape
        (samples, n) and returns an array of the same shape. The step is then ``step(z, h)``, and returns one array or changes it in
        place. `q0` is the centre z0 of n numbers, `radius` has one number for each of them, and `loop` is a function of s that returns z.
        The loop integral is ∮ ϑ(z)·dz. Degree of freedom i of the report is the coordinate z_i.
    casimir : callable or list of callables, optional
        The Casimir functions of a degenerate (Lie–Poisson) `form`, such as the lengths of spins. Each gets an array of shape (samples, n)
        and returns an array of shape (samples,). Loops and tangent vectors stay on the leaf through `q0`, on which these functions are
        constant. ``project(z)`` is an alternative, if you know the leaf in another way.
    mass_matrix : callable or array_like, optional
        The mass matrix M(q), if the canonical momentum is M(q) v and the step is ``step(q, v, h)``. ``mass_matrix(q)`` returns an array of
        shape (samples, dof, dof). A constant matrix may be passed as an array. `p0` and the second argument of `energy` are then
        velocities. Loops lie in q and M(q) v, and `radius` and `loop` describe these momenta.
    per_sample : bool
        Whether `step`, `project`, `form` and `casimir` take and return one state: arrays of shape (dof,), or of the shape of `q0`.
    make : bool
        Whether `step` is a factory: ``step(h)`` returns ``advance(q, p)``. It is called once for each h.
    reset : callable, optional
        Called before each call of `step`, for codes that keep state.
    dtype : "float32", optional
        For a step that computes in single precision: it gets arrays of this type.
    jacobian : bool or "auto"
        Whether the Jacobian of one step is also tested. If False, it is tested at one point, and only if a loop integral changes. "auto"
        also calls the step with arrays of JAX or tensors of torch, if it takes and returns them. ``jax.jvp`` or ``torch.func.jvp`` then
        gives the exact Jacobian. A step that cannot be traced causes a warning. A step that ``jax.jit`` compiled does not need "auto".
    jvp : callable, optional
        ``jvp(q, p, h, dq, dp)`` returns the derivative of the step at (q, p) along (dq, dp), as two arrays. The Jacobian is then exact,
        and needs fewer evaluations. symplint compares the derivative with differences first. `args` follow dp. Without a step size, the
        function is ``jvp(q, p, dq, dp)``. A step that ``jax.jit`` compiled does not need it.
    properties : bool
        Whether other properties of the map are also tested: see `Report.properties`. This takes 40 evaluations, or 8 if the budget is
        small.
    reversal : array_like or callable, optional
        Time reversal: signs 1 or -1 of all positions, then of all momenta. By default, the momenta change their signs. A function
        ``reversal(q, p)`` returns the reversed q and p, and must be its own inverse. With `form`, it is ``reversal(z)``, and with
        `mass_matrix` ``reversal(q, v)``.
    symmetric : bool
        Whether symplint tests that a step of size -h undoes a step of size h. This takes 20 evaluations, and calls `step` with negative h.
    energy : callable, optional
        ``energy(q, p)`` returns the energy of each state, of shape (samples,), or another function that a step may conserve. With `form`,
        it is ``energy(z)``. The report states whether a step conserves it, on your loop and inside, and the order k of a change that
        is proportional to h^k. This takes 80 evaluations. With `steps`, the report also states whether the energy stays bounded
        or drifts.
    steps : int
        Your loop is also followed for this number of steps of the largest size. The report states whether the defect accumulates.
        This takes `steps` evaluations for each sample of the loop (256 to 8192). If `budget` is not given, it grows by 512 for each step.
    workers : int, callable or executor, optional
        Runs the steps: a number of processes (-1 for one per processor), a function or an executor. A function is like the built-in
        `map`, for example ``pool.map``. An executor has a method `submit` or `map` as in `concurrent.futures`, for example a client
        of Dask or an ``MPIPoolExecutor``. Each ensemble is cut into at most 64 arcs, or into single states with `per_sample`, and
        `step` is called for each arc. Results do not depend on the number of workers. If a worker dies, the check ends with an
        error. With `run_dir`, it can be resumed.
    threads : int, optional
        Number of threads of the library. The default is one thread for a function, and one per core for an integrator of the library.
        More threads for a function only help with very many degrees of freedom. `step` is always called from the calling thread.
        Results do not depend on the number of threads. A number above the number of processors is reduced, with a warning.
    run_dir : path, optional
        Folder for the report, as `Report.save` writes it. Each result of `step` is also stored there as soon as it returns. A check that
        was stopped resumes when it is run again, and gives the same report. The folder is refused if it holds another run: with other
        arguments, another version of symplint, or a step whose module has another source text. It is also refused if it has files of the
        same names that symplint did not write.
    key : str, optional
        With `run_dir`, a text that identifies everything that the source text of the step does not show. Examples are parameters
        from a file, the state of an object, and compiled code. Another key means another run.
    progress : bool or callable, optional
        True shows the progress and the time left on standard error, if this is a terminal. A function gets the number of points
        measured, the number planned, and the step size of the last point.

    Returns
    -------
    Report
        The verdict with the measurements behind it.

    Other Parameters
    ----------------
    maxfev, seed, executor, out : optional
        Other names of `budget`, `rng`, `workers` and `run_dir`.
    h : float, optional
        The old name of `typical_step`.
    **settings
        Further keys of the section ``[diagnostic]`` of a configuration, such as ``closure="chords"`` or
        ``sample_sweep={"from": 64, "to": 4096}``. ``symplint init pendulum --all`` prints all of them.

    Raises
    ------
    InputError
        If an argument is not valid.
    StepError
        If the map fails on your loop, or returns states that are not finite, or if its results depend on earlier calls or on other
        rows of the batch. Without a step size, also if the map returns None and changes no state. An exception of `step` is the cause
        of the error. If the map fails at some step sizes only, symplint measures the other step sizes first, and the error has the
        report on them.

    Examples
    --------
    >>> import numpy as np, symplint
    >>> def leapfrog(q, p, h):
    ...     q = q + 0.5 * h * p
    ...     p = p - h * np.sin(q)
    ...     return q + 0.5 * h * p, p
    >>> report = symplint.check(leapfrog, 1.0, 0.5)
    >>> report.kind
    'symplectic'

    The explicit midpoint rule is not:

    >>> def midpoint(q, p, h):
    ...     dq, dp = p - 0.5 * h * np.sin(q), -np.sin(q + 0.5 * h * p)
    ...     return q + h * dq, p + h * dp
    >>> report = symplint.check(midpoint, 1.0, 0.5)
    >>> report.kind, report.order
    ('not-symplectic', 3.0)

    Lotka–Volterra in the populations x and y, in which the symplectic form is dx∧dy/(xy):

    >>> def splitting(z, h):
    ...     x, y = z.T
    ...     x *= np.exp(h * (1.0 - y))
    ...     y *= np.exp(h * (x - 1.0))
    >>> def form(z):
    ...     x, y = z.T
    ...     return np.column_stack([-np.log(y) / x, 0.0 * y])
    >>> symplint.check(splitting, [1.0, 1.5], radius=0.4, form=form).kind
    'symplectic'
    """
    # Tracebacks of pytest end where the test calls this.
    __tracebackhide__ = True
    typical_step = one_of("typical_step", typical_step, "h", h, None, deprecated=True)
    budget = one_of("budget", budget, "maxfev", maxfev, None)
    rng = one_of("rng", rng, "seed", seed, None)
    workers = one_of("workers", workers, "executor", executor, 1)
    run_dir = one_of("run_dir", run_dir, "out", out, None)
    canonical = {
        "period": period, "momentum_period": momentum_period, "weight": weight, "project": project, "form": form,
        "casimir": casimir, "mass_matrix": mass_matrix,
    }  # fmt: skip
    if coordinates is not None:
        canonical = Coordinates._merged(coordinates, canonical)
    if isinstance(step, AdaptedStep):
        q0 = step.q0 if q0 is None else q0
        p0 = step.p0 if p0 is None else p0
        if canonical["weight"] is None:
            canonical["weight"] = step.weight
        if step_sizes is None and typical_step is None:
            step_sizes, typical_step = step.step_sizes, step.typical_step
        if radius is None and loop is None:
            radius = step.radius
        per_sample = step.per_sample
        dtype = step.dtype if dtype is None else dtype
        if run_dir is not None and key is None:
            remedy = 'identify it by a text of yours, as in key="3 bodies, version 2"'
            raise InputError(f"run_dir is given, and {step.__name__} has no source text; {remedy}")
    radius = 1.0 if radius is None else radius
    if substeps is not None:
        if step is not None:
            raise InputError("both step and substeps are given; a step is either one whole or has parts")
        step = compose(*substeps)
    if settings:
        _check_names(settings)
    args = tuple_of(args)
    with executor_of(workers) as pool:
        return _check(
            step, q0, p0, args=args, step_sizes=step_sizes, typical_step=typical_step, repeat=repeat, radius=radius,
            phases=phases, loop=loop, loops=loops, seed=1 if rng is None else seed_of(rng), rule=rule, cutoff=cutoff,
            samples=samples, budget=budget, per_sample=per_sample, make=make, reset=reset, dtype=dtype, jacobian=jacobian, jvp=jvp,
            properties=properties, reversal=reversal, symmetric=symmetric, energy=energy, steps=steps, executor=pool, threads=threads,
            run_dir=run_dir, key=key, progress=progress, further=settings, **canonical,
        )  # fmt: skip


def _check(
    step: Any,
    q0: Any,
    p0: Any,
    *,
    args: tuple[Any, ...],
    step_sizes: Any,
    typical_step: float | None,
    repeat: int,
    radius: Any,
    phases: str,
    loop: Any,
    loops: int,
    seed: int,
    rule: str | None,
    cutoff: float | tuple[float, float],
    samples: int | str,
    budget: int | str | None,
    period: Any,
    momentum_period: Any,
    weight: Any,
    project: Any,
    form: Any,
    casimir: Any,
    mass_matrix: Any,
    per_sample: bool,
    make: bool,
    reset: Any,
    dtype: Any,
    jacobian: bool | str,
    jvp: Any,
    properties: bool,
    reversal: Any,
    symmetric: bool,
    energy: Any,
    steps: int,
    executor: Any,
    threads: int | None,
    run_dir: str | os.PathLike[str] | None,
    key: str | None,
    progress: bool | Callable[[int, int, float | None], object] | None,
    further: dict[str, Any],
) -> Report:
    """`check` with one name for each argument."""
    __tracebackhide__ = True
    folder = None if run_dir is None else _absolute(run_dir)
    if folder is not None:
        # Before the check: its report would be lost.
        check_replaceable(folder)
    if isinstance(step, System):
        step = of_system(step)
    if casimir is not None and form is None:
        raise InputError("casimir is for non-canonical coordinates; give a form as well")
    if isinstance(step_sizes, str):
        _check_none(step_sizes, make)
    if args and isinstance(step, Composition):
        raise InputError("args are for a function, and a composed step takes none; bind them in its parts, by functools.partial or a lambda")
    _check_signature(step, form is not None, step_sizes, make, len(args))
    name, functions = _name(step), {"step": step, "jvp": jvp, "form": form, "project": project, "reset": reset, "energy": energy}
    if callable(reversal):
        functions["reversal"] = reversal
    if callable(mass_matrix):
        functions["mass_matrix"] = mass_matrix
    if args:
        if not callable(step) or isinstance(step, Integrator | AdaptedStep):
            raise InputError("args are for a function; give it, or leave args out")
        step = WithArguments(step, args)
    stated: dict[str, Any] = {"args": repr(args)} if args else {}
    has_step_size = not (isinstance(step_sizes, str) and step_sizes == "none")
    is_given = callable(step) and not isinstance(step, Integrator | AdaptedStep)
    if is_given and form is None and mass_matrix is None and axes(q0) > 1:
        q0, p0 = of_any_shape(q0, "q0"), of_any_shape(p0, "p0")
        if q0.shape != p0.shape:
            raise InputError(f"q0 has the shape {q0.shape} and p0 {p0.shape}; give one of both for each degree of freedom")
        shape = stated["shape"] = q0.shape

        def of_rows(function: Any, per_sample: bool = per_sample, **arguments: Any) -> Any:
            return Shaped(function, shape, per_sample, **arguments) if callable(function) else function

        if isinstance(step, Composition):
            step = compose(*((part, of_rows(function)) for part, function in step.parts))
        else:
            step = of_rows(step, make=make)
        project, energy, reversal = of_rows(project), of_rows(energy), of_rows(reversal)
        jvp = of_rows(jvp, states=(0, 1, 3, 4) if has_step_size else (0, 1, 2, 3))
        if not isinstance(loop, Loop):
            loop = of_rows(loop, per_sample=False, states=())
        if isinstance(radius, tuple) and len(radius) == 2:
            radius = tuple(broadcast(of, "radius", shape) for of in radius)
        elif not isinstance(radius, str | int | float):
            radius = broadcast(radius, "radius", shape)
        period, momentum_period, weight = (
            None if value is None else broadcast(value, what, shape)
            for what, value in (("period", period), ("momentum_period", momentum_period), ("weight", weight))
        )
        q0, p0 = q0.ravel(), p0.ravel()
    if mass_matrix is not None:
        others = {"form": form, "weight": weight, "project": project, "momentum_period": momentum_period, "jvp": jvp, "dtype": dtype}
        step, p0, energy, reversal = _of_velocities(mass_matrix, step, q0, p0, energy, reversal, make, per_sample, others)
    if form is not None:
        step, q0, p0, radius, loop, project = _of_form(
            form, step, q0, p0, radius=radius, phases=phases, loop=loop, project=project, casimir=casimir,
            momentum_period=momentum_period, weight=weight, per_sample=per_sample, make=make,
        )  # fmt: skip
        if callable(reversal):
            reversal = MapOfForm(reversal, form, make=False)
    if isinstance(step_sizes, str):
        step = _without_step_size(step)
    subject = _subject(
        step, q0, p0, radius=radius, phases=phases, seed=seed, loop=loop, project=project, period=period,
        momentum_period=momentum_period, weight=weight, per_sample=per_sample, make=make, reset=reset, dtype=dtype,
        threads=threads, executor=executor,
    )  # fmt: skip
    compiled = subject["integrator"] is not None
    if energy is not None:
        if compiled or not callable(energy):
            raise InputError("energy is for a step that is a function; give a function of q and p, or leave it out")
        if not properties:
            raise InputError("energy is given, and properties is False; leave one of them out")
        subject["energy"] = EnergyOfRows(energy, form is not None)
    if callable(reversal):
        if compiled:
            raise InputError("reversal as a function is for a step that is a function; give signs, or leave it out")
        subject["reversal"] = reversal
    if isinstance(jacobian, str) and jacobian != "auto":
        raise InputError(f'jacobian is "{jacobian}"; give True, False or "auto"')
    others = {"an integrator of the library": compiled, "make": make, "form": form, "project": project}
    if jvp is not None:
        jvp = given(jvp, others, args, has_step_size)
    elif jacobian and executor is None and not (subject["single"] or any(others.values())):
        jvp = (traced if jacobian == "auto" else derivatives_of_jax)(step, subject["dof"], bool(per_sample))
    if jvp is not None:
        subject["tangents"] = Tangents(step, jvp)
    if step_sizes is not None and typical_step is not None:
        raise InputError("both step_sizes and typical_step are given; step sizes are searched from a typical one")
    steps, repeat = whole(steps, "steps", 0), whole(repeat, "repeat", 1)
    if budget is None:
        budget = BUDGET + BUDGET_OF_A_STEP * steps
    elif isinstance(budget, str) and budget == "auto" and not compiled:
        budget = BUDGET
    of_q, of_p = cutoffs(cutoff)
    settings: dict[str, Any] = {
        "step_sizes": "none" if not has_step_size else None if step_sizes is None else vector(step_sizes, "step_sizes").tolist(),
        "step_size": None if typical_step is None else _number(typical_step, "typical_step"),
        "repeat": repeat,
        "loops": loops,
        "seed": seed,
        "rule": rule,
        "cutoff_q": of_q,
        "cutoff_p": of_p,
        "samples": samples,
        "budget": budget,
        "jacobian": bool(jacobian),
        "properties": bool(properties),
        "reversal": None if reversal is None or callable(reversal) else vector(reversal, "reversal").tolist(),
        "symmetric": bool(symmetric),
        "steps": steps,
    } | further
    settings = {setting: value for setting, value in settings.items() if value is not None}
    if mass_matrix is not None and not callable(mass_matrix):
        stated["mass_matrix"] = hashlib.sha256(np.asarray(mass_matrix, dtype=np.float64).tobytes()).hexdigest()[:16]
    config = _config(name, subject, settings | stated, loop)
    dof = subject["dof"]
    of_states = "coordinates" if form is not None else f"degree{'' if dof == 1 else 's'} of freedom"
    title = f"{name} · {dof} {of_states}"
    journal = None if folder is None or compiled else _journal(folder, identity(functions, key), config, subject)
    workers = contextlib.nullcontext() if subject["workers"] is None else contextlib.closing(subject["workers"])
    with bar(progress) as watch, _resumable(folder if journal else None), workers:
        try:
            native, failed = _native.check(subject, settings, title, json.dumps(_finite(config)), watch, journal)
        except StepError as error:
            if remedy := hint(error, bool(per_sample)):
                error.args = (f"{error}; {remedy}",)
            raise
    if isinstance(step, WithoutStepSize) and step.is_idle:
        remedy = "return q, p, or write the results into the arrays"
        raise StepError(f"{name} returned nothing and left its arrays as they were; {remedy}")
    if subject["workers"] is not None:
        subject["workers"].warn()
    subject["workers"] = None

    def image(size: float, samples: int) -> tuple[States, States]:
        return _native.image(subject, size if has_step_size else 1.0, samples, repeat)

    report = Report(native, image)
    if folder is not None:
        report.save(folder)
    if failed is not None:
        failed.report = report
        raise failed
    return report


def assert_symplectic(
    step: Callable[..., Any] | Integrator | System,
    q0: npt.ArrayLike | None = None,
    p0: npt.ArrayLike | None = None,
    *,
    digits: float | None = None,
    **arguments: Any,
) -> Report:
    """Fail unless a map is symplectic.

    Parameters
    ----------
    step : callable
        The map, as `check` takes it.
    q0, p0 : array_like
        The centre of the loops, as in `check`.
    digits : float, optional
        Digits to which the loop integral must be conserved.
    **arguments
        Further arguments of `check`.

    Returns
    -------
    Report
        The report of the check.

    Raises
    ------
    NotSymplecticError
        If the map is not symplectic, breaks loops, or conserves fewer digits.
    UndecidedError
        If the evidence is not enough for a verdict. Both errors are AssertionErrors and have the report.

    Examples
    --------
    >>> import numpy as np, symplint
    >>> def kick_and_drift(q, p, h):
    ...     p -= h * np.sin(q)
    ...     q += h * p
    >>> report = symplint.assert_symplectic(kick_and_drift, 1.0, 0.5, digits=10)
    >>> def with_friction(q, p, h):
    ...     kick_and_drift(q, p, h)
    ...     p *= 1.0 - 0.01 * h
    >>> symplint.assert_symplectic(with_friction, 1.0, 0.5)
    Traceback (most recent call last):
        ...
    symplint.NotSymplecticError: with_friction is not symplectic: The map changes loop integrals by up to 0.005 at h = 0.5, in proportion to h.
    ...
    """
    __tracebackhide__ = True
    least = None if digits is None else _number(digits, "digits")
    report = check(step, q0, p0, **arguments)
    enough = least is None or (report.digits is not None and report.digits >= least)
    if report.kind == "symplectic" and enough:
        return report
    name = _name(step)
    match report.kind:
        case "symplectic":
            hint = " (double precision allows about 14)" if least is not None and least > 14 else ""
            text = f"{name} is symplectic to {report.digits} digits only, not to {digits}{hint}: "
        case "undecided":
            raise UndecidedError(f"the evidence on {name} is not enough for a verdict: {report.reasons()}", report)
        case _:
            text = f"{name} is not symplectic: "
    raise NotSymplecticError(text + report.reasons(), report)


def assert_structure(
    step: Callable[..., Any] | Integrator | System,
    q0: npt.ArrayLike | None = None,
    p0: npt.ArrayLike | None = None,
    *,
    symplectic: bool | None = None,
    conformal: bool | None = None,
    volume: bool | None = None,
    reversible: bool | None = None,
    symmetric: bool | None = None,
    **arguments: Any,
) -> Report:
    """Fail unless a map has the stated properties.

    Parameters
    ----------
    step : callable
        The map, as `check` takes it.
    q0, p0 : array_like
        The centre of the loops, as in `check`.
    symplectic, conformal, volume, reversible, symmetric : bool, optional
        Whether the map should have this property: see `Report.properties`. None, the default, allows both. At least one is given.
    **arguments
        Further arguments of `check`.

    Returns
    -------
    Report
        The report of the check.

    Raises
    ------
    StructureError
        If a property is not as stated, or could not be tested. It is an AssertionError and has the report.

    Examples
    --------
    >>> import numpy as np, symplint
    >>> def damped(q, p, h):
    ...     p -= h * np.sin(q)
    ...     p *= np.exp(-0.1 * h)
    ...     q += h * p
    >>> report = symplint.assert_structure(damped, [1.0, 0.3], [0.5, 0.2], conformal=True, volume=False)
    >>> round(report.properties["conformal"].rate, 9)
    0.1
    """
    __tracebackhide__ = True
    wanted = {
        "symplectic": symplectic,
        "conformal": conformal,
        "volume": volume,
        "reversible": reversible,
        "symmetric": symmetric,
    }
    for prop, holds in wanted.items():
        if holds not in (True, False, None):
            raise InputError(f"{prop} is {holds!r}; give True, False or None")
    if all(holds is None for holds in wanted.values()):
        raise InputError("no property is given; give one of " + ", ".join(wanted))
    report = check(step, q0, p0, symmetric=symmetric is not None, **arguments)
    found = report.properties
    name = _name(step)
    for prop, holds in wanted.items():
        if holds is None:
            continue
        if prop not in found or found[prop].holds is None:
            reason = found[prop].text if prop in found else f"{prop}: not tested"
            raise StructureError(f"the evidence on {name} is not enough: {reason}\n{report.reasons()}", report)
        if found[prop].holds != holds:
            raise StructureError(f"{name} is not as stated: {found[prop].text}\n{report.reasons()}", report)
    return report


def _subject(
    step: Any,
    q0: Any,
    p0: Any,
    *,
    radius: Any,
    phases: Any,
    seed: Any,
    loop: Any,
    project: Any,
    period: Any,
    momentum_period: Any,
    weight: Any,
    per_sample: bool,
    make: bool,
    reset: Any,
    dtype: Any,
    threads: int | None,
    executor: Any = None,
) -> dict[str, Any]:
    """What is tested, as the native module takes it."""
    integrator = step if isinstance(step, Integrator) else None
    if step is None:
        raise InputError("step is missing; give a function step(q, p, h), or substeps")
    if integrator is None and not callable(step):
        raise InputError(f"step is an object of type {type(step).__name__}; give a function step(q, p, h)")
    for name, function in (("project", project), ("reset", reset)):
        if function is not None and not callable(function):
            raise InputError(f"{name} is an object of type {type(function).__name__}; give a function")
    if integrator is not None:
        of_steps = {
            "project": project, "period": period, "momentum_period": momentum_period, "weight": weight, "reset": reset,
            "dtype": dtype, "per_sample": per_sample or None, "make": make or None, "executor": executor,
        }  # fmt: skip
        if refused := [name for name, value in of_steps.items() if value is not None]:
            raise InputError(f"{refused[0]} is for functions; an integrator of symplint states its own")
        q0 = integrator.system.q0 if q0 is None else q0
        p0 = integrator.system.p0 if p0 is None else p0
    centres: tuple[list[float], list[float]] = ([], [])
    native_loop = loop._native if isinstance(loop, Loop) else None
    if loop is not None and native_loop is None and not callable(loop):
        raise InputError(f"loop is an object of type {type(loop).__name__}; give a symplint.Circle or a function of s")
    if q0 is None and p0 is None and native_loop is not None:
        dof = native_loop.dof
    else:
        if q0 is None or p0 is None:
            raise InputError("q0 and p0 are missing; give the centre of the loops")
        rows = centre(q0, p0)
        dof, centres = rows[0].size, (rows[0].tolist(), rows[1].tolist())
    for other, found in (("the loop", native_loop), ("the system", integrator)):
        if found is not None and found.dof != dof:
            raise InputError(f"q0 has {dof} values and {other} {found.dof} degrees of freedom; they must agree")
    if loop is not None and not (isinstance(radius, int | float) and radius == 1.0):
        raise InputError("both loop and radius are given; the loop has its size")
    start = phases_and_seed(phases, seed)
    if loop is not None and phases != "staggered":
        raise InputError("both loop and phases are given; the loop has its own")
    if isinstance(radius, str) and radius != "auto":
        raise InputError(f'radius is "{radius}"; give a number, or "auto"')
    of_circle = None
    if loop is None and not isinstance(radius, str):
        of_circle = tuple(row.tolist() for row in radii(radius, dof))
    return {
        "integrator": None if integrator is None else integrator._native,
        "step": None if integrator is not None else step,
        "tangents": None,
        "energy": None,
        "reversal": None,
        # Workers make whole steps.
        "parts": _parts(step, make) if executor is None else [],
        "per_sample": bool(per_sample),
        "make": bool(make),
        "reset": reset,
        "single": _is_single(dtype),
        "project": project,
        "form": isinstance(project, Projection),
        "dof": dof,
        "coordinates": coordinates(dof, period, momentum_period, weight),
        "native_loop": native_loop,
        "phase_loop": loop if native_loop is None else None,
        "q0": centres[0],
        "p0": centres[1],
        "radii": of_circle,
        "phases": start,
        "threads": None if threads is None else whole(threads, "threads", 1),
        "workers": None
        if executor is None
        else Workers(
            executor, step, per_sample=bool(per_sample), make=bool(make), single=_is_single(dtype), reset=reset
        ),
    }


def _check_signature(step: Any, has_form: bool, step_sizes: Any, make: bool, extra: int) -> None:
    """Refuse a step with the arguments of another convention."""
    if not callable(step) or isinstance(step, Integrator | AdaptedStep):
        return
    if make:
        return None if isinstance(step, Composition) else check_signature(step, ("h",), extra)
    has_step_size = not (isinstance(step_sizes, str) and step_sizes == "none")
    arguments = (("z",) if has_form else ("q", "p")) + (("h",) if has_step_size else ())
    is_composed = isinstance(step, Composition)
    for function in [function for _, function in step.parts] if is_composed else [step]:
        check_signature(function, arguments, extra, is_composed)


def _parts(step: Any, make: bool) -> list[tuple[str, Callable[..., Any]]]:
    """The names and functions of the parts of a step, if it has any."""
    if isinstance(step, AdaptedStep):
        return step.parts
    if not isinstance(step, Composition):
        return []
    if make:
        raise InputError("make does not work with substeps; give parts as functions f(q, p, h)")
    return [(name, step.part(number)) for number, (name, _) in enumerate(step.parts)]


def _of_velocities(
    mass_matrix: Any, step: Any, q0: Any, v0: Any, energy: Any, reversal: Any, make: bool, per_sample: bool, others: dict[str, Any]
) -> tuple[Any, ...]:
    """What is tested if a mass matrix is given: step, p0, energy and reversal in the canonical momenta."""
    if refused := [name for name, value in others.items() if value is not None]:
        raise InputError(f"{refused[0]} is for steps in q and p; with mass_matrix, p is M(q) v, and {refused[0]} has no meaning")
    if not callable(step) or isinstance(step, Integrator | AdaptedStep):
        raise InputError("mass_matrix is for a function step(q, v, h); give it, or leave mass_matrix out")
    if q0 is None or v0 is None:
        raise InputError("q0 and p0 are missing; with mass_matrix, give positions and velocities")
    matrix = MassMatrix(mass_matrix)
    q0, v0 = centre(q0, v0)
    if isinstance(step, Composition):
        step = compose(*((name, StepOfVelocities(part, matrix)) for name, part in step.parts))
    else:
        step = StepOfVelocities(step, matrix, make)
    energy = EnergyOfVelocities(energy, matrix) if callable(energy) else energy
    reversal = StepOfVelocities(reversal, matrix) if callable(reversal) else reversal
    # The function takes states as the step does.
    p0 = matrix.momenta(q0, v0) if per_sample else matrix.momenta(q0[None], v0[None])[0]
    return step, p0, energy, reversal


def _of_form(
    form: Any,
    step: Any,
    z0: Any,
    p0: Any,
    *,
    radius: Any,
    phases: Any,
    loop: Any,
    project: Any,
    casimir: Any,
    momentum_period: Any,
    weight: Any,
    per_sample: bool,
    make: bool,
) -> tuple[Any, ...]:
    """What is tested where a one-form is given: step, q0, p0, radius, loop and project of canonical coordinates."""
    for name, function in (("form", form), ("step", step)):
        if not callable(function) or isinstance(function, Integrator):
            raise InputError(f"{name} is an object of type {type(function).__name__}; with a form, give a function")
    casimirs = [] if casimir is None else list(casimir) if isinstance(casimir, list | tuple) else [casimir]
    for name, function in [("casimir", function) for function in casimirs] + [("project", project)]:
        if not callable(function) and (function is not None or name == "casimir"):
            raise InputError(f"{name} is an object of type {type(function).__name__}; give a function of z")
    canonical = {"p0": p0, "momentum_period": momentum_period, "weight": weight}
    if refused := [name for name, value in canonical.items() if value is not None]:
        raise InputError(f"{refused[0]} is for canonical coordinates; with a form, pass only z0, period and form")
    if loop is not None and (isinstance(loop, Loop) or not callable(loop)):
        raise InputError("loop is of canonical coordinates; with a form, give a function of s that returns z")
    if phases != "staggered":
        raise InputError("phases is for canonical coordinates; with a form, give a loop")
    if isinstance(radius, tuple | str):
        raise InputError(f"radius is {radius!r}; with a form, give a number, or one for each coordinate")
    if z0 is None:
        raise InputError("q0 is missing; with a form, give the centre z0 of the loops")
    z0 = vector(z0, "q0")
    of_rows = FormOfRows(form) if per_sample else form
    size = radii(radius, z0.size)[0]
    if loop is None:
        loop, radius = CircleOfForm(z0, size, of_rows), 1.0
    else:
        loop = LoopOfForm(loop, of_rows)
    leaves = [] if project is None else [project]
    if casimirs:
        leaves.append(Leaf(casimirs, z0, size, per_sample))
    p0 = one_form(of_rows, z0[None, :])[0]
    return MapOfForm(step, form, make), z0, p0, radius, loop, Projection(form, leaves)


def _check_none(step_sizes: str, make: bool) -> None:
    """Reject texts for step sizes other than "none"."""
    if step_sizes != "none":
        raise InputError(f'step_sizes is "{step_sizes}"; give step sizes, or "none" for a map without one')
    if make:
        raise InputError('make is for steps with a step size; with step_sizes="none", give step(q, p)')


def _without_step_size(step: Any) -> Any:
    """The same step, for a map that has no step size."""
    if isinstance(step, Composition):
        return step.without_step_size()
    # An integrator of the library, a step of an adapter, or what `_subject` refuses.
    return step if isinstance(step, Integrator | AdaptedStep) or not callable(step) else WithoutStepSize(step)


def _absolute(run_dir: str | os.PathLike[str]) -> str:
    """The folder for the report, which stays the same where a step changes the working directory."""
    folder = os.fsdecode(run_dir)
    if not folder:
        raise InputError("run_dir is an empty path; give a folder")
    try:
        return os.path.abspath(folder)
    except OSError as error:
        message = f"run_dir is {folder!r}, relative to a working directory that cannot be found"
        raise InputError(f"{message}: {error.strerror}; give an absolute path") from None


def _journal(folder: str, known: dict[str, Any], config: dict[str, Any], subject: dict[str, Any]) -> tuple[str, str]:
    """The file of results, and the run that they are of."""
    try:
        os.makedirs(folder, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {folder!r}: {error.strerror}; give run_dir another one") from None
    run: dict[str, Any] = {"symplint": _native.__version__, **config, **known}
    if subject["workers"] is not None and not subject["per_sample"]:
        # Calls of arcs are not those of whole sets of states.
        run["arcs"] = True
    # The configuration leaves out long arrays.
    centre = {name: np.asarray(subject[name]).tobytes() for name in ("q0", "p0")}
    run["centre"] = {name: hashlib.sha256(row).hexdigest() for name, row in centre.items()}
    return os.path.join(folder, "journal"), json.dumps(_finite(run))


@contextlib.contextmanager
def _resumable(folder: str | None) -> Iterator[None]:
    """Adds to Ctrl-C how the check resumes."""
    try:
        yield
    except KeyboardInterrupt as stopped:
        if folder is not None:
            stopped.add_note(f"the same check with run_dir={folder!r} resumes from here")
        raise


def _config(name: str, subject: dict[str, Any], settings: dict[str, Any], loop: Any) -> dict[str, Any]:
    """The arguments, for the report."""
    own = ("dof", "per_sample", "make", "single", "q0", "p0", "radii")
    if loop is None:
        settings = {"phases": subject["phases"][0]} | settings
    arguments = {key: subject[key] for key in own} | subject["coordinates"] | settings
    arguments = {
        key: value
        for key, value in arguments.items()
        if not isinstance(value, list | tuple) or len(value) <= MAX_VALUES
    }
    config: dict[str, Any] = {"check": {"step": name} | arguments}
    if loop is not None:
        config["check"]["loop"] = type(loop).__name__ if isinstance(loop, Loop) else _name(loop)
    if (integrator := subject["integrator"]) is not None:
        config["system"] = json.loads(integrator.system.config())
        config["integrator"] = json.loads(integrator.config())
    return config


def _finite(value: Any) -> Any:
    """The same for JSON, which has no other numbers: those that are refused later are null."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _name(step: Any) -> str:
    """What a step is called in a report."""
    if isinstance(step, Integrator):
        return f"{step.system.name} · {step.name}"
    return str(getattr(step, "__name__", type(step).__name__))


def _is_single(dtype: Any) -> bool:
    if dtype is None:
        return False
    # Of torch and JAX, too.
    name = str(getattr(dtype, "__name__", dtype)).rsplit(".", 1)[-1]
    if name in ("float32", "float64"):
        return name == "float32"
    try:
        found = np.dtype(dtype)
    except TypeError:
        found = None
    if found is None or found not in (np.float32, np.float64):
        smaller = "; a step that computes with fewer bits gets float32" if "float" in name else ""
        raise InputError(f'dtype is {name}; give "float32" or "float64"{smaller}')
    return bool(found == np.float32)


def _number(value: Any, name: str) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise InputError(f"{name} is {value!r}; give a number") from None


def _check_names(settings: dict[str, Any]) -> None:
    """Refuse further settings that do not exist, as Python refuses arguments."""
    arguments = inspect.signature(check).parameters
    # The key `step_size` of configurations is `typical_step` here: as an argument, it would be mistaken for the step sizes.
    known = [name for name in _native.settings() if name not in arguments and name != "step_size"]
    for name in settings:
        if name not in known:
            near = difflib.get_close_matches(name, [*arguments, *known], 1) or ["typical_step"] * (name.lower() in TIMES)
            remedy = f"; did you mean '{near[0]}'?" if near else ""
            raise TypeError(f"check() got an unexpected keyword argument '{name}'{remedy}")
