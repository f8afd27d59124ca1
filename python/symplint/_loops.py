"""Closed curves of initial states."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from . import _native
from ._arrays import Array, coordinates, samples, vector, whole
from ._errors import InputError

__all__ = ["Circle", "FourierLoop", "Loop", "SampledLoop", "circle"]


def centre(q0: npt.ArrayLike, p0: npt.ArrayLike) -> tuple[Array, Array]:
    """Centre of a loop: rows of the same length, 1 or more."""
    q, p = vector(q0, "q0"), vector(p0, "p0")
    if q.size != p.size:
        raise InputError(f"q0 has {q.size} values and p0 has {p.size}; give one of both for each degree of freedom")
    if q.size == 0:
        raise InputError("q0 and p0 are empty; give one value for each degree of freedom")
    return q, p


def radii(radius: Any, dof: int) -> tuple[Array, Array]:
    """Radii in q and in p of every degree of freedom."""
    of_q, of_p = radius if isinstance(radius, tuple) and len(radius) == 2 else (radius, radius)
    found = vector(of_q, "radius", dof), vector(of_p, "radius", dof)
    for row in found:
        if not (row > 0.0).all() or not (row < float("inf")).all():
            raise InputError(f"radius is {radius!r}; give a positive finite number, one for each degree of freedom, "
                             'a pair of these for q and p, or "auto"')
    return found


def phases_and_seed(phases: Any, seed: Any) -> tuple[str, int]:
    """Phases of a circle by name, and the seed of random ones."""
    if not isinstance(phases, str):
        raise InputError(f'phases is {phases!r}; give "staggered", "equal" or "random"')
    return phases, whole(seed, "seed", 0)


class Loop:
    """A closed curve in phase space that can be sampled at any s.

    Calling it with values of the loop parameter s gives the positions and momenta there.
    """

    def __init__(self, native: _native.Loop) -> None:
        self._native = native

    @property
    def dof(self) -> int:
        """Degrees of freedom."""
        return self._native.dof

    def sample(self, samples: int = 256) -> tuple[Array, Array]:
        """Sample the loop at s = k/samples.

        Parameters
        ----------
        samples : int
            Number of samples, at least 3.

        Returns
        -------
        q : ndarray of shape (samples, dof)
            The positions.
        p : ndarray of shape (samples, dof)
            The momenta.
        """
        return self._native.sample(whole(samples, "samples", 3))

    def __call__(self, s: npt.ArrayLike) -> tuple[Array, Array]:
        return self._native.at(vector(s, "s"))


class Circle(Loop):
    """The loop q = q0 + r sin 2π(s + φ), p = p0 + r cos 2π(s + φ), in every degree of freedom.

    Parameters
    ----------
    q0, p0 : array_like
        Its centre, one number for each degree of freedom.
    radius : float, array_like, or a pair of them
        Radius r: one number, one for each degree of freedom, or a tuple of the radius in q and the radius in p.
    dofs : sequence of int, optional
        Degrees of freedom that the loop moves; the others stay at their centres.
    phases : {"staggered", "equal", "random"}
        The phase φ of each degree of freedom: multiples of the golden ratio, 0 (the loop of the paper, which moves all degrees of
        freedom in phase), or random.
    seed : int
        Seed of random phases.

    Examples
    --------
    >>> import symplint
    >>> loop = symplint.Circle([1.0, 0.0], [0.5, 0.0], radius=(0.1, [0.2, 0.3]))
    >>> q, p = loop.sample(64)
    >>> q.shape
    (64, 2)
    """

    def __init__(
        self,
        q0: npt.ArrayLike,
        p0: npt.ArrayLike,
        radius: Any = 1.0,
        *,
        dofs: list[int] | None = None,
        phases: str = "staggered",
        seed: int = 1,
    ) -> None:
        q, p = centre(q0, p0)
        moved = None if dofs is None else [whole(dof, "dofs", 0) for dof in dofs]
        start = phases_and_seed(phases, seed)
        super().__init__(_native.Loop.circle(q, p, *radii(radius, q.size), moved, start))


class FourierLoop(Loop):
    """A random loop of three Fourier modes in every degree of freedom.

    Parameters
    ----------
    q0, p0 : array_like
        Its centre.
    radius : float, array_like, or a pair of them
        How far it reaches, as for `Circle`.
    seed : int
        Seed of the modes. The same seed gives the same loop.
    """

    def __init__(self, q0: npt.ArrayLike, p0: npt.ArrayLike, radius: Any = 1.0, *, seed: int = 1) -> None:
        q, p = centre(q0, p0)
        super().__init__(_native.Loop.fourier(q, p, *radii(radius, q.size), whole(seed, "seed", 0)))


class SampledLoop(Loop):
    """The trigonometric interpolant of samples.

    Parameters
    ----------
    q, p : array_like of shape (samples, dof)
        Row k is the state at s = k/samples.
    period, momentum_period : float or array_like, optional
        Periods of the positions and of the momenta, 0 for coordinates that are not periodic.
    """

    def __init__(
        self,
        q: npt.ArrayLike,
        p: npt.ArrayLike,
        *,
        period: npt.ArrayLike | None = None,
        momentum_period: npt.ArrayLike | None = None,
    ) -> None:
        rows_q, rows_p = samples(q, "q"), samples(p, "p")
        stated = coordinates(rows_q.shape[1], period, momentum_period, None)
        super().__init__(_native.Loop.sampled(rows_q, rows_p, stated))


def circle(
    q0: npt.ArrayLike,
    p0: npt.ArrayLike,
    radius: Any = 1.0,
    samples: int = 256,
    *,
    phases: str = "staggered",
    seed: int = 1,
) -> tuple[Array, Array]:
    """Sample a circle whose states another code advances: see `measure`.

    Parameters
    ----------
    q0, p0 : array_like
        The centre, one number for each degree of freedom.
    radius : float, array_like, or a pair of them
        As in `Circle`.
    samples : int
        Number of samples.
    phases : {"staggered", "equal", "random"}
        As in `Circle`.
    seed : int
        Seed of random phases.

    Returns
    -------
    q : ndarray of shape (samples, dof)
        The positions.
    p : ndarray of shape (samples, dof)
        The momenta.

    Examples
    --------
    >>> import symplint
    >>> q, p = symplint.circle(0.0, 0.0, radius=2.0, samples=64)
    >>> round(symplint.loop_integral(q, p).value, 12)  # its area
    12.566370614359
    """
    return Circle(q0, p0, radius, phases=phases, seed=seed).sample(samples)
