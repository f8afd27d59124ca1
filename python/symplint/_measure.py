"""Loops that another code advanced."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import Array, coordinates, cutoffs, is_single, samples
from ._errors import InputError
from ._report import Report

__all__ = ["LoopIntegral", "loop_integral", "measure"]


@dataclasses.dataclass(frozen=True)
class LoopIntegral:
    """The loop integral ∮ p·dq of samples of a loop.

    Attributes
    ----------
    value : float
        The integral.
    quadrature_error : float or None
        Estimated difference from the integral of the sampled loop; None if the samples are too few for an estimate.
    roundoff : float
        Rounding error of the value.
    contributions : tuple of float
        The part of each degree of freedom.
    """

    value: float
    quadrature_error: float | None
    roundoff: float
    contributions: tuple[float, ...]

    def __float__(self) -> float:
        return self.value


def loop_integral(
    q: npt.ArrayLike,
    p: npt.ArrayLike,
    *,
    rule: str | None = "auto",
    cutoff: float | tuple[float, float] = 1000.0,
    period: npt.ArrayLike | None = None,
    momentum_period: npt.ArrayLike | None = None,
    weight: npt.ArrayLike | None = None,
) -> LoopIntegral:
    """The loop integral ∮ p·dq of equispaced samples of a closed loop.

    Parameters
    ----------
    q, p : array_like of shape (samples, dof)
        Row k is the state at s = k/samples. Arrays of double precision in Fortran order are not copied.
    rule : {"auto", "pseudospectral", "finite-difference"}
        Rule that computes the integral. "auto" or None is the pseudospectral rule, with central differences of order 10 or 20 for
        degrees of freedom whose samples are smooth to rounding error.
    cutoff : float or (float, float), optional
        The λ of the finite-difference rule, as in `check`.
    period, momentum_period, weight : float or array_like, optional
        As in `check`.

    Returns
    -------
    LoopIntegral
        The integral with its errors.

    Examples
    --------
    >>> import numpy as np, symplint
    >>> s = np.arange(32) / 32
    >>> integral = symplint.loop_integral(np.sin(2 * np.pi * s), np.cos(2 * np.pi * s))
    >>> abs(integral.value - np.pi) < 1e-14
    True
    """
    rows_q, rows_p = samples(q, "q"), samples(p, "p")
    dof = rows_q.shape[1]
    stated = coordinates(dof, period, momentum_period, weight)
    rule = "auto" if rule is None else rule
    value, quadrature_error, roundoff, contributions = _native.loop_integral(
        rows_q, rows_p, rule, cutoffs(cutoff), stated
    )
    return LoopIntegral(value, quadrature_error, roundoff, tuple(contributions))


def measure(
    before: tuple[npt.ArrayLike, npt.ArrayLike],
    *after: tuple[npt.ArrayLike, npt.ArrayLike],
    h: float | Sequence[float | None] | None = None,
    period: npt.ArrayLike | None = None,
    momentum_period: npt.ArrayLike | None = None,
    weight: npt.ArrayLike | None = None,
) -> Report:
    """Test a step from the samples of a loop before and after it.

    Parameters
    ----------
    before : (q, p)
        The loop before the step, of shape (samples, dof) both: rows in the order of the loop. Equally spaced rows give the most
        digits; rows may also be missing or unequally spaced, which the stated error includes. A last row that repeats the
        first one is left out.
    *after : (q, p)
        The same samples after one step; of several step sizes, each taken from `before`.
    h : float or sequence of float, optional
        Their step sizes.
    period, momentum_period, weight : float or array_like, optional
        As in `check`.

    Returns
    -------
    Report
        The verdict with the measurements behind it.

    Examples
    --------
    >>> import numpy as np, symplint
    >>> q, p = symplint.circle(1.0, 0.5, radius=0.5)
    >>> q1 = q + 0.1 * p
    >>> symplint.measure((q, p), (q1, p - 0.1 * np.sin(q1)), h=0.1).kind
    'symplectic'
    """
    if not after:
        raise InputError("no loop after the step is given; use measure((q, p), (q1, p1))")
    sizes = _step_sizes(h, len(after))
    if len(sizes) != len(after):
        raise InputError(f"h has {len(sizes)} values for {len(after)} loops after the step; give one for each")
    loops = [_loop(states, name) for states, name in [(before, "before"), *((states, "after") for states in after)]]
    dof = loops[0][0].shape[1]
    stated = coordinates(dof, period, momentum_period, weight)
    known = [size if size is not None and math.isfinite(size) else None for size in sizes]
    config = {"measure": {"dof": dof, "samples": loops[0][0].shape[0], "h": known}}
    title = f"measured · {dof} degree{'' if dof == 1 else 's'} of freedom"
    native = _native.measure(loops[0], loops[1:], sizes, stated, title, json.dumps(config))

    def image(size: float, _: int) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        index = sizes.index(size) if size in sizes else 0
        return loops[0][:2], loops[1 + index][:2]

    return Report(native, image)


def _step_sizes(h: Any, count: int) -> list[float | None]:
    """One step size for each loop after the step; None where it is not known."""
    if h is None:
        return [None] * count
    try:
        return [None if size is None else float(size) for size in (h if np.iterable(h) else [h])]
    except (TypeError, ValueError):
        raise InputError(f"h is {h!r}; give a number for each loop after the step") from None


def _loop(states: Any, name: str) -> tuple[Array, Array, bool]:
    """Samples of a loop, and whether they are of single precision."""
    try:
        q, p = states
    except (TypeError, ValueError):
        raise InputError(f"the loop {name} the step is not a pair (q, p) of arrays") from None
    return samples(q, f"q {name} the step"), samples(p, f"p {name} the step"), is_single(q) or is_single(p)
