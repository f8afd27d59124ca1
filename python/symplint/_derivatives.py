"""Derivatives of a step: those of the user, or those that JAX or torch finds."""

from __future__ import annotations

import functools
import importlib
import sys
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from ._arrays import numbers
from ._errors import InputError
from ._names import WithArguments, WithoutStepSize
from ._shape import Shaped
from .adapters import AdaptedStep

__all__ = ["Tangents", "derivatives_of_jax", "given", "traced"]


class Tangents:
    """A step of states together with tangent vectors: arrays of twice as many columns, the states first.

    The states are advanced by the step itself: a compiler may round a step otherwise that it differentiates.

    Parameters
    ----------
    step : callable
        ``step(q, p, h)``.
    jvp : callable
        ``jvp(q, p, h, dq, dp)`` returns the derivative of the step at q, p along dq, dp.
    """

    def __init__(self, step: Callable[..., Any], jvp: Callable[..., Any]) -> None:
        self.step, self.jvp = step, jvp

    def __call__(self, q: Any, p: Any, h: float) -> tuple[Any, Any]:
        """The states and tangent vectors after the step."""
        dof = q.shape[-1] // 2
        states = [rows[..., :dof].copy(order="F") for rows in (q, p)]
        tangents = [rows[..., dof:].copy(order="F") for rows in (q, p)]
        found = self.jvp(*(rows.copy(order="F") for rows in states), h, *tangents)
        if found is None or len(found) != 2:
            raise InputError("jvp returns no pair; return dq and dp, the derivative of q and p after the step along dq and dp before it")
        derivatives = [np.asarray(rows) for rows in found]
        for name, rows, expected in zip(("dq", "dp"), derivatives, tangents, strict=True):
            if rows.shape != expected.shape:
                raise InputError(f"jvp returns {name} of shape {rows.shape}; give one of shape {expected.shape}")
        returned = self.step(*states, h)
        advanced = states if returned is None else [np.asarray(rows) for rows in returned]
        q, p = (np.concatenate(pair, axis=-1) for pair in zip(advanced, derivatives, strict=True))
        return q, p


def given(jvp: Any, others: dict[str, Any], args: tuple[Any, ...], has_step_size: bool) -> Callable[..., Any]:
    """The derivative that the user gave, as ``jvp(q, p, h, dq, dp)``; `others` are arguments that exclude it, by name."""
    if not callable(jvp):
        raise InputError(f"jvp is an object of type {type(jvp).__name__}; give a function jvp(q, p, h, dq, dp)")
    for name, value in others.items():
        if value:
            raise InputError(f"jvp is for a step(q, p, h) in canonical coordinates; with {name}, leave it out")

    def derivative(q: Any, p: Any, h: float, dq: Any, dp: Any) -> Any:
        return jvp(q, p, h, dq, dp, *args) if has_step_size else jvp(q, p, dq, dp, *args)

    return derivative


def _is_compiled(step: Any) -> bool:
    """Whether ``jax.jit`` made the function, below what this package and functools put around it."""
    if isinstance(step, functools.partial):
        return _is_compiled(step.func)
    if isinstance(step, WithArguments | WithoutStepSize | Shaped | AdaptedStep):
        return _is_compiled(step.step)
    return hasattr(step, "lower") and hasattr(step, "eval_shape")


def derivatives_of_jax(step: Callable[..., Any], dof: int, per_sample: bool) -> Callable[..., Any] | None:
    """The derivative ``jvp(q, p, h, dq, dp)`` of a step that ``jax.jit`` compiled; None for others.

    A step that is not compiled may keep what it is called with, and must not get abstract arrays unasked.
    """
    jax = sys.modules.get("jax")
    if jax is None or not _is_compiled(step):
        return None
    try:
        return _traced_by_jax(jax, step, dof, per_sample)
    except Exception:  # Whatever a step raises that cannot be traced.
        return None


def traced(step: Callable[..., Any], dof: int, per_sample: bool) -> Callable[..., Any] | None:
    """The derivative ``jvp(q, p, h, dq, dp)`` of a step that JAX or torch can trace; None, with a warning that has the reasons, for others."""
    reasons = []
    for name, trace in (("jax", _traced_by_jax), ("torch", _traced_by_torch)):
        library = sys.modules.get(name)
        if library is None:
            continue
        try:
            return trace(library, step, dof, per_sample)
        except Exception as error:  # Whatever a step raises that cannot be traced.
            lines = str(error).strip().splitlines() or [type(error).__name__]
            reasons.append(f"{name}: {lines[0]}")
    reason = "; ".join(reasons) or "neither JAX nor torch is imported"
    warnings.warn(
        f'jacobian="auto": the step cannot be traced, and differences give the Jacobian ({reason}); let the step take and return arrays '
        "of JAX, or tensors of torch, in double or single precision (torch.as_tensor(q), not torch.from_numpy(q))",
        stacklevel=4,
    )
    return None


def _image(step: Callable[..., Any], h: float) -> Callable[..., Any]:
    """A step of this size as a function of q and p that returns both."""

    def image(q: Any, p: Any) -> tuple[Any, Any]:
        found = step(q, p, h)
        if found is not None:
            q, p = found
        return q, p

    return image


def _check_traced(found: Any, shape: tuple[int, ...]) -> None:
    """Refuse derivatives of another shape, or with fewer digits than single precision has."""
    for rows in found:
        precision = str(rows.dtype).rsplit(".", 1)[-1]
        if tuple(rows.shape) != shape or precision not in ("float64", "float32"):
            found_as = f"the shape {tuple(rows.shape)} and the type {precision}"
            raise TypeError(f"the results have {found_as}, for states of shape {shape} in double or single precision")


def _traced_by_jax(jax: Any, step: Callable[..., Any], dof: int, per_sample: bool) -> Callable[..., Any]:
    """The derivative by JAX. The step is traced with abstract arrays, which takes no evaluation."""

    def jvp(q: Any, p: Any, h: float, dq: Any, dp: Any) -> Any:
        return jax.jvp(_image(step, h), (q, p), (dq, dp))[1]

    shape = (dof,) if per_sample else (2, dof)
    state = jax.ShapeDtypeStruct(shape, np.float64)
    _check_traced(jax.eval_shape(lambda q, p, dq, dp: jvp(q, p, 0.5, dq, dp), state, state, state, state), shape)
    return jvp


def _traced_by_torch(torch: Any, step: Callable[..., Any], dof: int, per_sample: bool) -> Callable[..., Any]:
    """The derivative by torch. The step is traced with tensors that have no values, which takes no evaluation."""
    # Parameters of a network have values.
    without_values = importlib.import_module("torch._subclasses.fake_tensor").FakeTensorMode(allow_non_fake_inputs=True)

    def derivative(h: float, q: Any, p: Any, dq: Any, dp: Any) -> Any:
        return torch.func.jvp(_image(step, h), (q, p), (dq, dp))[1]

    def jvp(q: Any, p: Any, h: float, dq: Any, dp: Any) -> Any:
        found = derivative(h, *(torch.as_tensor(rows) for rows in (q, p, dq, dp)))
        return tuple(numbers(rows, name) for rows, name in zip(found, ("dq", "dp"), strict=True))

    shape = (dof,) if per_sample else (2, dof)
    with without_values:
        _check_traced(derivative(0.5, *(torch.ones(shape, dtype=torch.float64) for _ in range(4))), shape)
    return jvp
