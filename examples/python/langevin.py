"""Velocity Verlet and a Langevin thermostat (BAOAB) for a ring of coupled pendula, in NumPy alone."""

import numpy as np
import symplint

FRICTION, TEMPERATURE = 0.5, 0.3


def force(q):
    return -np.sin(q) + 0.3 * (np.roll(q, 1, axis=1) + np.roll(q, -1, axis=1) - 2.0 * q)


def verlet(q, p, h):
    p = p + 0.5 * h * force(q)
    q = q + h * p
    return q, p + 0.5 * h * force(q)


def langevin(q, p, h):
    # The same noise in every call: a map must not depend on anything but the state and h.
    noise = np.random.default_rng(1).standard_normal(q.shape[1])
    kept = np.exp(-FRICTION * h)
    p = p + 0.5 * h * force(q)
    q = q + 0.5 * h * p
    p = kept * p + np.sqrt((1.0 - kept**2) * TEMPERATURE) * noise
    q = q + 0.5 * h * p
    return q, p + 0.5 * h * force(q)


def report(step):
    """The report on one of both."""
    return symplint.check(step, np.linspace(-1.0, 1.0, 8), np.zeros(8), step_sizes=[0.5, 0.25, 0.125])


if __name__ == "__main__":
    for step in (verlet, langevin):
        found = report(step)
        print(f"{step.__name__}: {found.headline}\n  {found.summary}")
