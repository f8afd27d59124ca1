"""Integrators of Mici."""

from __future__ import annotations

import copy
import importlib
from typing import Any

import numpy as np

from .._errors import InputError
from ._step import AdaptedStep

__all__ = ["mici"]


def mici(integrator: Any, state: Any) -> AdaptedStep:
    """An integrator of Mici.

    Parameters
    ----------
    integrator : mici.integrators.Integrator
        The integrator with its system. It is not changed.
    state : mici.states.ChainState
        Position and momentum of the centre of the loops: one array each, of one dimension.

    Returns
    -------
    AdaptedStep
        One step of size h; a typical step is the step size of the integrator, if it has one. Positions and momenta are canonical.

    Raises
    ------
    InputError
        If the system has constraints.

    Notes
    -----
    Set up once for each h: a copy of the integrator. For each state: a new ``ChainState``, which has no cached values.

    Examples
    --------
    >>> import mici, numpy as np, symplint
    >>> system = mici.systems.EuclideanMetricSystem(lambda q: (q**4).sum(), grad_neg_log_dens=lambda q: 4 * q**3)
    >>> integrator = mici.integrators.LeapfrogIntegrator(system, step_size=0.1)
    >>> state = mici.states.ChainState(pos=np.array([0.5, 0.3]), mom=np.array([0.2, -0.4]), dir=1)
    >>> symplint.check(symplint.adapters.mici(integrator, state), budget=2000, loops=2).kind
    'symplectic'
    """
    if not hasattr(integrator, "step") or not hasattr(integrator, "system"):
        raise InputError(f"integrator is an object of type {type(integrator).__name__}; give one of mici.integrators")
    if "Constrained" in type(integrator).__name__:
        raise InputError(f"{type(integrator).__name__} has constraints; write a step and give project=")
    for name in ("pos", "mom"):
        if np.ndim(getattr(state, name, 0)) != 1:
            raise InputError(f"the state has no array {name} of one dimension; give a mici.states.ChainState with pos, mom and dir")
    chain_state = importlib.import_module("mici.states").ChainState

    def step(q: Any, p: Any, h: float) -> tuple[Any, Any]:
        of_step = copy.copy(integrator)
        of_step.step_size = abs(h)
        found = of_step.step(chain_state(pos=q, mom=p, dir=1 if h > 0 else -1))
        return found.pos, found.mom

    return AdaptedStep(step, f"Mici {type(integrator).__name__}", state.pos, state.mom, typical_step=integrator.step_size)
