"""Sun, Jupiter and Saturn in a plane, by three integrators of REBOUND (pip install rebound).

A state is positions and velocities of the three bodies; velocities times masses are the canonical momenta, so the masses
are weights. A new simulation for each state keeps nothing of the one before.
"""

import numpy as np
import rebound
import symplint

MASSES = [1.0, 9.5e-4, 2.9e-4]
# Astronomical units, and velocities in units in which the Earth has 1.
Q0 = [-4e-3, 1e-3, 5.2, 0.0, 0.0, 9.6]
P0 = [-8e-5, -4e-4, 0.0, 0.439, -0.323, 0.0]


def step_of(integrator):
    def step(q, v, h):
        simulation = rebound.Simulation()
        simulation.integrator = integrator
        simulation.dt = h
        for mass, (x, y), (vx, vy) in zip(MASSES, q.reshape(3, 2), v.reshape(3, 2), strict=True):
            simulation.add(m=mass, x=x, y=y, vx=vx, vy=vy)
        if integrator == "ias15":
            simulation.integrate(h)
        else:
            simulation.steps(1)
            simulation.synchronize()
        bodies = simulation.particles
        return [c for body in bodies for c in (body.x, body.y)], [c for body in bodies for c in (body.vx, body.vy)]

    step.__name__ = integrator
    return step


def report(integrator):
    """The report on one of them. Radii differ with the masses, so that all bodies have actions of one size."""
    radius = np.repeat([1e-3, 0.1, 0.1], 2)
    return symplint.check(
        step_of(integrator), Q0, P0, step_sizes=[4.0, 2.0, 1.0], radius=(radius, 0.05 * radius),
        weight=np.repeat(MASSES, 2), per_sample=True, budget=4000, loops=3,
    )  # fmt: skip


if __name__ == "__main__":
    for name in ("whfast", "leapfrog", "ias15"):
        print(f"{name}: {report(name).headline}")
