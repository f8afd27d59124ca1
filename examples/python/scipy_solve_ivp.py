"""A pendulum by solve_ivp of SciPy, with its default tolerances: one call is one step (pip install scipy)."""

import numpy as np
import symplint
from scipy.integrate import solve_ivp


def step(q, p, h):
    solution = solve_ivp(lambda _, z: (z[1], -np.sin(z[0])), (0.0, h), (q[0], p[0]), method="RK45")
    return solution.y[0, -1], solution.y[1, -1]


def report():
    """The solver chooses its own steps within one of size h, and adapts them to the state."""
    return symplint.check(step, 1.0, 0.5, step_sizes=[2.0, 1.0, 0.5], per_sample=True, budget=4000, loops=3)


if __name__ == "__main__":
    print(report())
