"""What is wrong with a step that was written for another library."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from ._errors import InputError, StepError

__all__ = ["check_signature", "hint"]

#: Names of a step size or a time.
TIMES = {"h", "dt", "t", "time", "tau", "delta_t", "step_size", "stepsize", "timestep", "time_step"}
POSITIONS = {"q", "x", "pos", "position", "positions", "r"}
MOMENTA = {"p", "v", "vel", "velocity", "velocities", "momentum", "momenta"}
ALL_AT_ONCE = {"z", "y", "u", "state", "states", "w"}

ONE_STATE = "{what} gets arrays of shape (samples, dof); write it with numpy functions, or for one state and give per_sample=True"
OF_NUMBERS = "{arrays} of shape (dof,): take q[0], or write the {what} with numpy functions"

#: Words of exceptions that steps raise which are written for one state.
OF_ONE_STATE = (
    "only 0-dimensional arrays can be converted", "only length-1 arrays can be converted",
    "only size-1 arrays can be converted", "only integer scalar arrays", "must be real number, not",
    "truth value of an array", "unsupported operand", "setting an array element with a sequence",
)  # fmt: skip


def check_signature(step: Callable[..., Any], expected: tuple[str, ...], extra: int = 0, is_part: bool = False) -> None:
    """Refuse a step whose arguments are those of another convention.

    Parameters
    ----------
    step : callable
        The function of the user.
    expected : tuple of str
        The names of the arguments that it is called with: ("q", "p", "h"), for example.
    extra : int
        Arguments that follow them.
    is_part : bool
        Whether it is a part of a composed step, to which no further arguments are passed.

    Raises
    ------
    InputError
        If the number of arguments does not fit, or their names show another order.
    """
    try:
        parameters = list(inspect.signature(step).parameters.values())
    except (TypeError, ValueError):
        return
    by_place = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    names = [of.name for of in parameters if of.kind in by_place]
    required = [of.name for of in parameters if of.kind in by_place and of.default is inspect.Parameter.empty]
    takes_more = any(of.kind is inspect.Parameter.VAR_POSITIONAL for of in parameters)
    name = getattr(step, "__name__", type(step).__name__)
    call = f"step({', '.join(expected)})"
    stated = f"{name}({', '.join(names)}) is called as {call}"
    count = len(expected) + extra
    fits = len(required) <= count and (takes_more or count <= len(names))
    lower = [of.lower() for of in names]
    if expected == ("q", "p", "h") and lower[:1] and lower[0] in TIMES:
        if len(lower) == 2 and lower[1] in ALL_AT_ONCE | POSITIONS:
            raise InputError(
                f"{stated}: it looks like a right-hand side f(t, y); give a step of an integrator, "
                f"such as symplint.from_ode({name}) of SciPy, or test f by symplint.check_field"
            )
        if len(lower) == 3:
            order = f"{name}(h, q, p)"
            raise InputError(f"{stated}: its first argument is a step size; give lambda q, p, h: {order}")
    if expected[:2] == ("q", "p") and len(lower) >= 2 and lower[0] in MOMENTA and lower[1] in POSITIONS:
        rest = ", ".join(expected[2:])
        rest = f", {rest}" if rest else ""
        raise InputError(
            f"{stated}: its first argument is a momentum; give a function of q and p that returns q and p in this order, "
            f"def step(q, p{rest}): p, q = {name}(p, q{rest}); return q, p"
        )
    if fits:
        return
    keyword = next((of.name for of in parameters if of.kind is of.KEYWORD_ONLY and of.name.lower() in TIMES), None)
    if len(expected) > 1 and expected[-1] == "h" and keyword is not None:
        states = ", ".join(expected[:-1])
        raise InputError(f"{stated}: {keyword} is keyword-only; give lambda {states}, h: {name}({states}, {keyword}=h)")
    if expected == ("q", "p", "h") and len(required) == 2 and lower[0] in POSITIONS:
        raise InputError(f'{stated}: it has no step size; give step_sizes="none" if that is so, or a function of q, p and h')
    if expected == ("q", "p", "h") and lower[:1] and lower[0] in ALL_AT_ONCE:
        raise InputError(
            f"{stated}: it takes all coordinates at once; split them, lambda q, p, h: numpy.split({name}(numpy.hstack([q, p]), h), 2, "
            "axis=1), or give form= for non-canonical coordinates"
        )
    remedy = "bind others by functools.partial or a lambda" if is_part else "pass others on by args="
    raise InputError(f"{stated}; give a function with these arguments, or {remedy}")


def hint(error: StepError, per_sample: bool, what: str = "step") -> str | None:
    """What to do about an exception of a step, or of another function, that is written for one state, if it looks like one."""
    cause = error.__cause__
    if cause is None:
        return None
    if any(words in str(cause) for words in OF_ONE_STATE):
        arrays = "q is an array" if what == "force" else "q and p are arrays"
        return (OF_NUMBERS if per_sample else ONE_STATE).format(what=what, arrays=arrays)
    if per_sample:
        return None
    # JAX raises a TypeError for shapes that cannot be broadcast.
    if isinstance(cause, IndexError) or (isinstance(cause, ValueError | TypeError) and "broadcast" in str(cause)):
        return f"{ONE_STATE.format(what=what)}; q[:, i] is degree of freedom i of all samples"
    return None
