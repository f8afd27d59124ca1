"""A pendulum by solve_ivp of SciPy, with its default tolerances: one call is one step (pip install scipy)."""

import numpy as np
import symplint


def pendulum(_, z):
    return z[1], -np.sin(z[0])


def report():
    """The solver chooses its own steps within one of size h, and adapts them to the state."""
    step = symplint.from_ode(pendulum, "RK45")
    return symplint.check(step, 1.0, 0.5, step_sizes=[2.0, 1.0, 0.5], budget=4000, loops=3)


if __name__ == "__main__":
    print(report())
