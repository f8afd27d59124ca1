"""Integrators of OpenMM."""

from __future__ import annotations

from typing import Any

import numpy as np

from .._errors import InputError
from ._step import AdaptedStep, radii_of_bodies

__all__ = ["openmm"]


def openmm(context: Any) -> AdaptedStep:
    """The integrator of a context of OpenMM.

    Parameters
    ----------
    context : openmm.Context or openmm.app.Simulation
        The system, the integrator and a state. Only the platform "Reference" computes in double precision. Its state changes.

    Returns
    -------
    AdaptedStep
        One step of size h in ps; a typical step is the step size of the integrator. States are positions in nm and velocities in nm/ps, x, y
        and z of the first particle first. The masses are weights.

    Raises
    ------
    InputError
        If the system has constraints, virtual sites or particles without mass, or the integrator chooses its step sizes.

    Notes
    -----
    Set up once: the context and a checkpoint of it. For each state: the checkpoint is loaded, and positions and velocities are set. If
    the integrator draws random numbers, the context is initialized again instead, so that each state gets the same noise.
    ``VerletIntegrator`` is the leapfrog method with velocities half a step before the positions. (q(t), v(t - h/2)) is a canonical pair
    also.

    Examples
    --------
    >>> import openmm, symplint
    >>> system, bond = openmm.System(), openmm.HarmonicBondForce()
    >>> for mass in (1.0, 16.0):
    ...     number = system.addParticle(mass)
    >>> number = bond.addBond(0, 1, 0.1, 4e5), system.addForce(bond)
    >>> platform = openmm.Platform.getPlatformByName("Reference")
    >>> context = openmm.Context(system, openmm.VerletIntegrator(0.001), platform)
    >>> context.setPositions([[0.0, 0.0, 0.0], [0.11, 0.0, 0.0]])
    >>> symplint.check(symplint.adapters.openmm(context), budget=4000, loops=2).kind
    'symplectic'
    """
    context = getattr(context, "context", context)
    if not hasattr(context, "createCheckpoint"):
        raise InputError(f"context is an object of type {type(context).__name__}; give an openmm.Context or openmm.app.Simulation")
    system, integrator = context.getSystem(), context.getIntegrator()
    count = system.getNumParticles()
    if constraints := system.getNumConstraints():
        raise InputError(f"the system has {constraints} constraints; make it flexible: createSystem(constraints=None, rigidWater=False)")
    masses = np.array([system.getParticleMass(i)._value for i in range(count)])
    if not (masses > 0.0).all():
        particle = int(np.argmin(masses > 0.0))
        raise InputError(f"particle {particle} has no mass: a fixed particle or a virtual site; give it a mass, or remove it")
    name = type(integrator).__name__
    if name.startswith("Variable"):
        raise InputError(f"{name} chooses its step sizes, and has no step of size h; give an integrator with a fixed step size")
    draws = _draws_random_numbers(integrator)
    if draws and integrator.getRandomNumberSeed() == 0:
        # 0 is a new seed for each initialization.
        integrator.setRandomNumberSeed(1)
    everything = {"positions": True, "velocities": True, "parameters": True, "integratorParameters": True}
    beginning = context.getState(**everything) if draws else context.createCheckpoint()

    def step(q: Any, v: Any, h: float) -> tuple[Any, Any]:
        if draws:
            # A checkpoint does not have all of the random generator.
            context.reinitialize(preserveState=False)
            context.setState(beginning)
        else:
            context.loadCheckpoint(beginning)
        integrator.setStepSize(h)
        context.setPositions(q.reshape(count, 3))
        context.setVelocities(v.reshape(count, 3))
        integrator.step(1)
        return state()

    def state() -> tuple[Any, Any]:
        found = context.getState(positions=True, velocities=True)
        return found.getPositions(asNumpy=True)._value.ravel(), found.getVelocities(asNumpy=True)._value.ravel()

    dtype = None if context.getPlatform().getName() == "Reference" else "float32"
    typical_step = integrator.getStepSize()._value
    q0, v0 = state()
    return AdaptedStep(
        step, f"OpenMM {name}", q0, v0, weight=np.repeat(masses, 3), typical_step=typical_step, dtype=dtype,
        radius=radii_of_bodies(q0.reshape(count, 3), masses, typical_step),
    )  # fmt: skip


def _draws_random_numbers(integrator: Any) -> bool:
    """Whether a step draws random numbers; integrators made of expressions may."""
    if not hasattr(integrator, "getRandomNumberSeed"):
        return False
    if not hasattr(integrator, "getComputationStep"):
        return True
    steps = [integrator.getComputationStep(number)[2] for number in range(integrator.getNumComputations())]
    return any(word in text for text in steps for word in ("gaussian", "uniform"))
