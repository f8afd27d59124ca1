"""Solvers of Diffrax."""

from __future__ import annotations

import dataclasses
import importlib
from typing import Any

import numpy as np
import numpy.typing as npt

from .._errors import InputError
from ._step import AdaptedStep

__all__ = ["diffrax"]


def diffrax(
    terms: Any, solver: Any, q0: npt.ArrayLike, p0: npt.ArrayLike, *, args: Any = None, t0: float = 0.0, controller: Any = None
) -> AdaptedStep:
    """A solver of Diffrax.

    Parameters
    ----------
    terms : diffrax term or tuple of terms
        The vector field, as ``diffrax.diffeqsolve`` takes it, on y = (q, p): a pair of arrays of shape (dof,). For ``SemiImplicitEuler``,
        a pair of terms.
    solver : diffrax.AbstractSolver
        The method.
    q0, p0 : array_like
        The centre of the loops.
    args : optional
        The arguments of the vector field.
    t0 : float
        The time at which each step begins.
    controller : diffrax.AbstractStepSizeController, optional
        Chooses the steps between t0 and t0 + h. By default, there is one step of size h.

    Returns
    -------
    AdaptedStep
        One step of size h, compiled by JAX. In double precision, its Jacobian is exact.

    Raises
    ------
    InputError
        If `solver` is not one of Diffrax.

    Notes
    -----
    Set up once: the compiled function, for all states at once. For each state: the solver begins anew, without a state of the solver. A
    method of two steps such as ``LeapfrogMidpoint`` therefore makes its first step. JAX computes in single precision unless
    ``jax.config.update("jax_enable_x64", True)`` was called.

    Examples
    --------
    >>> import diffrax, jax, symplint
    >>> jax.config.update("jax_enable_x64", True)
    >>> velocity = diffrax.ODETerm(lambda t, p, args: p)
    >>> force = diffrax.ODETerm(lambda t, q, args: -jax.numpy.sin(q))
    >>> step = symplint.adapters.diffrax((velocity, force), diffrax.SemiImplicitEuler(), [1.0], [0.5])
    >>> symplint.check(step).kind
    'symplectic'
    """
    library, jax = importlib.import_module("diffrax"), importlib.import_module("jax")
    if not isinstance(solver, library.AbstractSolver):
        raise InputError(f"solver is an object of type {type(solver).__name__}; give a solver of Diffrax")

    def explicit(y: Any, h: Any) -> Any:
        # `diffeqsolve` gives the same, and takes ten times as long to compile.
        found, _, _, _, result = solver.step(terms, t0, t0 + h, y, args, solver.init(terms, t0, t0 + h, y, args), made_jump=False)
        return found, result == library.RESULTS.successful

    def general(y: Any, h: Any) -> Any:
        found = library.diffeqsolve(
            terms, solver, t0, t0 + h, h if controller is None else None, y, args, throw=False,
            stepsize_controller=library.ConstantStepSize() if controller is None else controller,
            # Forward derivatives give the Jacobian.
            adjoint=library.ForwardMode(),
        )  # fmt: skip
        return jax.tree.map(lambda rows: rows[0], found.ys), found.result == library.RESULTS.successful

    is_implicit = isinstance(solver, library.AbstractImplicitSolver)
    solve = explicit if controller is None and not is_implicit else general
    if isinstance(solver, library.AbstractRungeKutta):
        # The loop over stages that has forward derivatives, as `ForwardMode` chooses it.
        solver = dataclasses.replace(solver, scan_kind="lax")

    def of_one(q: Any, p: Any, h: Any) -> Any:
        found, succeeds = solve((q, p), h)
        # If a solver fails, its state is NaN.
        return jax.tree.map(lambda rows: jax.numpy.where(succeeds, rows, jax.numpy.nan), found)

    step = jax.jit(jax.vmap(of_one, (0, 0, None)))
    dtype = None if jax.config.jax_enable_x64 else "float32"
    name = f"Diffrax {type(solver).__name__}"
    return AdaptedStep(step, name, np.atleast_1d(q0), np.atleast_1d(p0), per_sample=False, dtype=dtype)
