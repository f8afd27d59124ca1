"""Integrators of REBOUND."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from .._errors import InputError
from ._step import AdaptedStep, radii_of_bodies

__all__ = ["rebound"]

#: Integrators that choose their steps.
ADAPTIVE = ("ias15", "bs")


def rebound(simulation: Any, *, prepare: Callable[[Any], object] | None = None) -> AdaptedStep:
    """The integrator of a simulation of REBOUND.

    Parameters
    ----------
    simulation : rebound.Simulation
        The bodies, the integrator with its options, and dt, a typical step size. It is not changed.
    prepare : callable, optional
        ``prepare(simulation)`` sets on a copy what REBOUND does not copy: functions such as ``additional_forces``.

    Returns
    -------
    AdaptedStep
        One step of size h; the integrators "ias15" and "bs" integrate over h and choose their steps, the first of which is dt. States are
        positions and velocities in the inertial frame, x, y and z of the first body first. The masses are weights.

    Raises
    ------
    InputError
        If a body has no mass, there are variational particles, or REBOUND is older than version 5.

    Notes
    -----
    Set up once for each h: a copy of the simulation with its options. MERCURIUS also computes its critical radii once, from the bodies of
    `simulation`: radii that follow the state would make it lose its symplecticity. For each state: a copy of this copy, which gets
    positions and velocities.

    Examples
    --------
    >>> import rebound, symplint
    >>> simulation = rebound.Simulation()
    >>> simulation.add(m=1.0)
    >>> simulation.add(m=1e-3, a=1.0, e=0.1)
    >>> simulation.integrator, simulation.dt = "leapfrog", 0.05
    >>> symplint.check(symplint.adapters.rebound(simulation), budget=4000, loops=2).kind
    'symplectic'
    """
    if not hasattr(simulation, "did_modify_particles"):
        raise InputError(f"simulation is an object of type {type(simulation).__name__}; give a rebound.Simulation of REBOUND 5 or later")
    if simulation.N_var:
        raise InputError(f"the simulation has {simulation.N_var} variational particles; remove them")
    count = simulation.N
    masses = np.array([simulation.particles[i].m for i in range(count)])
    if not (masses > 0.0).all():
        body = int(np.argmin(masses > 0.0))
        raise InputError(f"particle {body} has the mass {masses[body]:g}: its momentum is zero; give it a mass, or remove it")
    if not count:
        raise InputError("the simulation has no particles; add some")
    name = str(simulation.integrator)
    ready: dict[float, Any] = {}

    def copied(original: Any) -> Any:
        with warnings.catch_warnings():
            # That functions are not copied: `prepare` sets them.
            warnings.filterwarnings("ignore", "You have to reset function pointers", RuntimeWarning)
            copy = original.copy()
        if prepare is not None:
            prepare(copy)
        return copy

    def for_step(h: float) -> Any:
        if h not in ready:
            copy = copied(simulation)
            if name not in ADAPTIVE:
                copy.dt = h
            if name == "mercurius":
                # The first step computes the critical radii.
                copy.steps(1)
            ready[h] = copy
        return ready[h]

    def step(q: Any, v: Any, h: float) -> tuple[Any, Any]:
        state = copied(for_step(h))
        state.set_serialized_particle_data(xyz=np.ascontiguousarray(q), vxvyvz=np.ascontiguousarray(v))
        if name != "mercurius":
            # Coordinates that the integrator keeps are those of the original.
            state.did_modify_particles = 1
        if name in ADAPTIVE:
            state.integrate(state.t + h)
        else:
            state.steps(1)
            state.synchronize()
        if state.N != count:
            raise RuntimeError(f"the step leaves {state.N} particles of {count}; switch collisions and boundaries off")
        q, v = np.empty((count, 3)), np.empty((count, 3))
        state.serialize_particle_data(xyz=q, vxvyvz=v)
        return q.ravel(), v.ravel()

    initial = copied(simulation)
    initial.synchronize()
    q0, v0 = np.empty((count, 3)), np.empty((count, 3))
    initial.serialize_particle_data(xyz=q0, vxvyvz=v0)
    return AdaptedStep(
        step, f"REBOUND {name}", q0.ravel(), v0.ravel(), weight=np.repeat(masses, 3),
        radius=radii_of_bodies(q0, masses, simulation.dt), typical_step=simulation.dt,
    )  # fmt: skip
