"""A flexible molecule of water in OpenMM, by its Verlet and by its Langevin dynamics (pip install openmm).

Lengths are in nm, times in ps and masses in daltons. OpenMM has velocities, so the masses are weights: the canonical momentum is
mass times velocity. The platform Reference computes in double precision. `VerletIntegrator` is the leapfrog, with velocities
half a step before positions: (q at t, v at t - h/2) to (q at t + h, v at t + h/2) is the map that is tested.
"""

import numpy as np
import openmm
import symplint

MASSES = [15.999, 1.008, 1.008]
LENGTH, ANGLE = 0.09572, 1.82421813
POSITIONS = LENGTH * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [np.cos(ANGLE), np.sin(ANGLE), 0.0]])


def water():
    system = openmm.System()
    for mass in MASSES:
        system.addParticle(mass)
    bonds, angles = openmm.HarmonicBondForce(), openmm.HarmonicAngleForce()
    for hydrogen in (1, 2):
        bonds.addBond(0, hydrogen, LENGTH, 462750.4)
    angles.addAngle(1, 0, 2, ANGLE, 836.8)
    system.addForce(bonds)
    system.addForce(angles)
    return system


def step_of(make_integrator):
    """One step of an integrator; a new context for each state keeps nothing of the one before."""
    system, platform = water(), openmm.Platform.getPlatformByName("Reference")

    def step(q, v, h):
        context = openmm.Context(system, make_integrator(h), platform)
        context.setPositions(q.reshape(3, 3))
        context.setVelocities(v.reshape(3, 3))
        context.getIntegrator().step(1)
        state = context.getState(positions=True, velocities=True)
        return state.getPositions(asNumpy=True)._value.ravel(), state.getVelocities(asNumpy=True)._value.ravel()

    return step


def verlet(h):
    return openmm.VerletIntegrator(h)


def langevin(h):
    integrator = openmm.LangevinMiddleIntegrator(300.0, 1.0, h)
    # The same noise for every state: a map must not depend on anything but the state and h.
    integrator.setRandomNumberSeed(1)
    return integrator


def report(make_integrator):
    return symplint.check(
        step_of(make_integrator), POSITIONS.ravel(), np.zeros(9), step_sizes=[1e-3, 5e-4, 2.5e-4], radius=(2e-3, 1.0),
        weight=np.repeat(MASSES, 3), per_sample=True, budget=2500, loops=3,
    )  # fmt: skip


if __name__ == "__main__":
    for make_integrator in (verlet, langevin):
        found = report(make_integrator)
        print(f"{make_integrator.__name__}: {found.headline}\n  {found.summary}")
