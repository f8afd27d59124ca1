"""Steps of the integrators of SciPy."""

from __future__ import annotations

import importlib.util
import inspect
from collections.abc import Callable
from typing import Any

import numpy as np

from ._errors import InputError

__all__ = ["OdeStep", "from_ode"]

#: Methods with steps that need no tolerance: explicit Runge–Kutta methods.
EXPLICIT = ("RK23", "RK45", "DOP853")
#: All methods of `scipy.integrate.solve_ivp`.
METHODS = (*EXPLICIT, "Radau", "BDF", "LSODA")


class OdeStep:
    """A step that integrates an ordinary differential equation: what `from_ode` returns."""

    __signature__ = inspect.Signature(
        [inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD) for name in ("q", "p", "h")]
    )

    def __init__(self, f: Callable[..., Any], solver: Any, t0: float, fixed_steps: int | None, options: dict[str, Any]) -> None:
        # The source text of f identifies the step in a run folder.
        self.__wrapped__ = f
        self.solver, self.t0, self.fixed_steps, self.options = solver, t0, fixed_steps, options
        name = solver if isinstance(solver, str) else solver.__name__
        self.__name__ = f"{getattr(f, '__name__', type(f).__name__)} by {name}"

    def __call__(self, q: Any, p: Any, h: float) -> tuple[Any, Any]:
        """The states at t0 + h."""
        # It need not be installed where types are checked.
        solve_ivp = importlib.import_module("scipy.integrate").solve_ivp
        options = self.options
        if self.fixed_steps is not None:
            # With such a tolerance the method accepts every step.
            size = abs(h) / self.fixed_steps
            options = options | {"first_step": size, "max_step": size, "rtol": 1e300, "atol": 1e300}
        # Only methods with adaptive steps recover from such values, by smaller steps, and only after the first value.
        recovers = self.fixed_steps is None and self.solver != "LSODA"
        found_last = ""

        def rates(t: float, y: Any, *args: Any) -> Any:
            nonlocal found_last
            dy = np.asarray(self.__wrapped__(t, y, *args), dtype=float)
            if dy.size != y.size:
                values = f"{dy.size} value{'' if dy.size == 1 else 's'}"
                raise ValueError(f"f(t, y) returned {values} for {y.size} coordinates; return the rates of all positions, then of all momenta")
            if not np.isfinite(dy).all():
                first = np.argwhere(~np.isfinite(dy))[0]
                value = "NaN" if np.isnan(dy[tuple(first)]) else "infinite"
                found_last = f"f(t, y) is {value} in dy/dt[{first[0]}] at t = {t:.6g}"
                if not recovers or t == self.t0:
                    raise ValueError(found_last)
            return dy

        before = np.concatenate([q, p], axis=-1)
        after = np.empty_like(before)
        for state in np.ndindex(before.shape[:-1]):
            found_last = ""
            found = solve_ivp(rates, (self.t0, self.t0 + h), before[state], method=self.solver, **options)
            # An event may end it, too.
            if found.status != 0:
                reason = f"{found.message} {found_last}".strip()
                raise RuntimeError(f"{self.__name__} stops at t = {found.t[-1]:.6g}: {reason}")
            after[state] = found.y[:, -1]
        q, p = np.split(after, 2, axis=-1)
        return q, p

    def __repr__(self) -> str:
        return f"<step: {self.__name__}>"


def from_ode(
    f: Callable[..., Any], solver: Any = "RK45", *, t0: float = 0.0, fixed_steps: int | None = None, **options: Any
) -> OdeStep:
    """A step that integrates an ordinary differential equation from t0 to t0 + h by SciPy.

    Each state is integrated separately. A method with adaptive steps chooses its steps for this state only.

    Parameters
    ----------
    f : callable
        The right-hand side ``f(t, y)``, as `scipy.integrate.solve_ivp` takes it. y has all positions, then all momenta.
    solver : str or scipy.integrate.OdeSolver
        The method, as `scipy.integrate.solve_ivp` takes it: "RK45", "DOP853", "Radau" and others, or a class.
    t0 : float
        The time at which each step begins.
    fixed_steps : int, optional
        The method takes this number of steps of equal size without control of the error: with 1, the step is one step of the method.
        For "RK23", "RK45" and "DOP853". By default, the method chooses its steps.
    **options
        Further arguments of `scipy.integrate.solve_ivp`: rtol, atol, jac, args and others.

    Returns
    -------
    OdeStep
        A function ``step(q, p, h)`` for `check`.

    Raises
    ------
    InputError
        If `f` is not a function, the method is unknown, the method or an option has no steps of fixed size, or an option is not an
        option of a step.
    RuntimeError
        Raised by the step, if the method or a terminal event stops before t0 + h.
    ValueError
        Raised by the step, if `f` returns a wrong number of values, or a value that is not finite and that the method cannot avoid
        by smaller steps.

    Notes
    -----
    A method that controls its error conserves loop integrals only to about its tolerance: loops break at states for which the
    number of steps changes. Set `rtol` and `atol` to test a simulation with these tolerances. Set `fixed_steps` to test the method.

    Examples
    --------
    >>> import numpy as np, symplint
    >>> def pendulum(t, y):
    ...     return [y[1], -np.sin(y[0])]
    >>> step = symplint.from_ode(pendulum, "RK23", fixed_steps=1)
    >>> report = symplint.check(step, 1.0, 0.5, step_sizes=[0.5, 0.25, 0.125, 0.0625], budget=2000)
    >>> report.kind
    'not-symplectic'
    """
    if not callable(f):
        raise InputError(f"f is an object of type {type(f).__name__}; give a function f(t, y)")
    if not isinstance(solver, type) and solver not in METHODS:
        raise InputError(f"solver is {solver!r}; give one of {', '.join(METHODS)}, or a class derived from scipy.integrate.OdeSolver")
    if known := options.keys() & {"method", "t_span", "y0", "t_eval"}:
        raise InputError(f"{min(known)} is given; the solver, the times and the states of a step are known")
    if importlib.util.find_spec("scipy") is None:
        raise InputError("from_ode integrates by scipy, which is not installed: pip install scipy")
    if fixed_steps is not None:
        if not isinstance(fixed_steps, int | np.integer) or fixed_steps < 1:
            raise InputError(f"fixed_steps is {fixed_steps!r}; give a whole number, 1 or more")
        if isinstance(solver, str) and solver not in EXPLICIT:
            raise InputError(f"{solver} has no steps of fixed size, as its equations are solved to rtol; give one of {', '.join(EXPLICIT)}")
        if refused := [name for name in ("rtol", "atol", "max_step", "first_step") if name in options]:
            raise InputError(f"both fixed_steps and {refused[0]} are given; steps of fixed size have no tolerance")
    return OdeStep(f, solver, float(t0), fixed_steps, options)
