"""Integrators of BlackJAX."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from .._errors import InputError
from ._step import AdaptedStep

__all__ = ["blackjax"]


def blackjax(
    log_density: Callable[..., Any],
    position: npt.ArrayLike,
    momentum: npt.ArrayLike,
    *,
    integrator: Callable[..., Any] | None = None,
    inverse_mass_matrix: npt.ArrayLike | None = None,
) -> AdaptedStep:
    """An integrator of BlackJAX.

    Parameters
    ----------
    log_density : callable
        The logarithm of the density, a function of one position of shape (dof,).
    position, momentum : array_like
        The centre of the loops.
    integrator : callable, optional
        One of ``blackjax.mcmc.integrators``; by default ``velocity_verlet``.
    inverse_mass_matrix : array_like, optional
        As ``blackjax.nuts`` takes it: an array of one or two dimensions. By default, 1.

    Returns
    -------
    AdaptedStep
        One step of size h, compiled by JAX. In double precision, its Jacobian is exact. Positions and momenta are canonical.

    Raises
    ------
    InputError
        If `log_density` or `integrator` is not a function.

    Notes
    -----
    Set up once: the compiled function, for all states at once. For each state: its density and gradient are computed anew. JAX computes in
    single precision unless ``jax.config.update("jax_enable_x64", True)`` was called.

    Examples
    --------
    >>> import blackjax, jax, symplint
    >>> jax.config.update("jax_enable_x64", True)
    >>> step = symplint.adapters.blackjax(lambda q: -(q**4).sum(), [0.5, 0.3], [0.2, -0.4])
    >>> symplint.check(step).kind
    'symplectic'
    """
    jax, library = importlib.import_module("jax"), importlib.import_module("blackjax.mcmc.integrators")
    metrics = importlib.import_module("blackjax.mcmc.metrics")
    method: Any = library.velocity_verlet if integrator is None else integrator
    for name, function in (("log_density", log_density), ("integrator", method)):
        if not callable(function):
            raise InputError(f"{name} is an object of type {type(function).__name__}; give a function")
    q0, p0 = np.atleast_1d(position), np.atleast_1d(momentum)
    inverse = jax.numpy.asarray(np.ones(q0.size) if inverse_mass_matrix is None else inverse_mass_matrix)
    # Isokinetic integrators take the matrix, and return the change of the kinetic energy as well.
    takes_matrix = "inverse_mass_matrix" in inspect.signature(method).parameters
    one_step = method(log_density, inverse if takes_matrix else metrics.default_metric(inverse).kinetic_energy)

    def of_one(q: Any, p: Any, h: Any) -> Any:
        found = one_step(library.new_integrator_state(log_density, q, p), h)
        state = found if hasattr(found, "position") else found[0]
        return state.position, state.momentum

    step = jax.jit(jax.vmap(of_one, (0, 0, None)))
    dtype = None if jax.config.jax_enable_x64 else "float32"
    # Most integrators of BlackJAX have the name of the function that made them.
    name = next((name for name, function in vars(library).items() if function is method), "integrator")
    return AdaptedStep(step, f"BlackJAX {name}", q0, p0, per_sample=False, dtype=dtype)
