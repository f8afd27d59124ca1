"""Lines of Xtrack."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

import numpy as np

from .._errors import InputError
from ._step import AdaptedStep

__all__ = ["xtrack"]


def xtrack(line: Any) -> AdaptedStep:
    """One passage through a line of Xtrack.

    Parameters
    ----------
    line : xtrack.Line
        The elements, with a reference particle: loops are laid around it. A line without a tracker gets one.

    Returns
    -------
    AdaptedStep
        A map without a step size; radii are 1e-3. Its positions are (x, y, zeta) and its momenta (px, py, pzeta), with pzeta = ptau /
        beta0. (delta is not canonical to zeta.) The momenta are multiplied by the reference momentum at the end over that at the
        beginning. Its parts are the elements.

    Raises
    ------
    InputError
        If the line has no reference particle.

    Notes
    -----
    Set up once: the tracker of the line. For each call: new particles, all states at once. Radiation with random numbers, and elements
    with a memory, depend on earlier calls.

    Examples
    --------
    >>> import symplint
    >>> import xtrack as xt
    >>> line = xt.Line([xt.Quadrupole(length=0.5, k1=0.6), xt.Drift(length=2.0), xt.Quadrupole(length=0.5, k1=-0.6)])
    >>> line.particle_ref = xt.Particles(mass0=xt.PROTON_MASS_EV, p0c=2e9)
    >>> symplint.check(symplint.adapters.xtrack(line), loops=2).kind
    'symplectic'
    """
    if not hasattr(line, "element_names") or not hasattr(line, "particle_ref"):
        raise InputError(f"line is an object of type {type(line).__name__}; give an xtrack.Line")
    reference = line.particle_ref
    if reference is None:
        raise InputError("the line has no reference particle; set line.particle_ref")
    if line.tracker is None:
        line.build_tracker()
    p0c, beta0 = float(reference.p0c[0]), float(reference.beta0[0])
    particles = importlib.import_module("xtrack").Particles
    kind = {"mass0": reference.mass0, "q0": reference.q0, "p0c": p0c}

    def tracked(**which: Any) -> Callable[..., Any]:
        def step(q: Any, p: Any, _: Any = None) -> tuple[Any, Any]:
            (x, y, zeta), (px, py, pzeta) = q.T, p.T
            beam = particles(**kind, x=x, y=y, zeta=zeta, px=px, py=py, ptau=pzeta * beta0)
            line.track(beam, **which)
            if lost := int((beam.state <= 0).sum()):
                raise RuntimeError(f"{lost} of {len(q)} particles are lost; make the radius smaller, or take apertures out")
            # Tracking may change the order of particles.
            order = np.argsort(beam.particle_id)
            scale = beam.p0c / p0c
            positions = [beam.x, beam.y, beam.zeta]
            momenta = [beam.px * scale, beam.py * scale, beam.ptau / beam.beta0 * scale]
            return np.stack(positions)[:, order].T, np.stack(momenta)[:, order].T

        return step

    names = list(line.element_names)
    parts = [(name, tracked(ele_start=number, num_elements=1)) for number, name in enumerate(names)]
    particle = [[float(getattr(reference, name)[0]) for name in row] for row in (("x", "y", "zeta"), ("px", "py", "ptau"))]
    particle[1][2] /= beta0
    return AdaptedStep(tracked(), "Xtrack line", *particle, radius=1e-3, per_sample=False, step_sizes="none", parts=parts)
