"""A cell of an accelerator in Xtrack: two quadrupoles and two drifts (pip install xsuite).

Canonical pairs are (x, px), (y, py) and (zeta, pzeta), with pzeta = ptau / beta0. The relative momentum deviation delta is not
canonical to zeta: a loop integral of delta instead of pzeta changes. A step of size h is a cell of h times the length.
xsuite contains the compiled C code of Xtrack; `pip install xtrack` alone needs gcc, and XSUITE_ALLOW_KERNEL_COMPILATION=1.
"""

import numpy as np
import symplint
import xtrack as xt

PROTON = {"mass0": xt.PROTON_MASS_EV, "p0c": 2e9}


def make(h, momentum="pzeta"):
    """One passage of the cell, with `momentum` as the momentum of zeta."""
    focusing, defocusing = (xt.Quadrupole(length=0.5 * h, k1=k1) for k1 in (0.6, -0.6))
    line = xt.Line(elements=[focusing, xt.Drift(length=2.0 * h), defocusing, xt.Drift(length=2.0 * h)])
    line.particle_ref = xt.Particles(**PROTON)

    def advance(q, p):
        (x, y, zeta), (px, py, third) = q.T, p.T
        if momentum == "pzeta":
            third = {"ptau": third * line.particle_ref.beta0[0]}
        else:
            third = {"delta": third}
        beam = xt.Particles(**PROTON, x=x, y=y, zeta=zeta, px=px, py=py, **third)
        line.track(beam)
        # Tracking may change the order of particles.
        order = np.argsort(beam.particle_id)
        third = beam.ptau / beam.beta0 if momentum == "pzeta" else beam.delta
        return np.stack([beam.x, beam.y, beam.zeta])[:, order].T, np.stack([beam.px, beam.py, third])[:, order].T

    return advance


def with_delta(h):
    return make(h, momentum="delta")


def report(make):
    centre = np.array([1e-3, 2e-3, 0.0]), np.array([1e-3, -5e-4, 1e-3])
    return symplint.check(make, *centre, step_sizes=[1.0, 0.5, 0.25], radius=([5e-3, 5e-3, 5e-2], 2e-3), make=True)


if __name__ == "__main__":
    for name, cell in (("pzeta", make), ("delta", with_delta)):
        found = report(cell)
        print(f"{name}: {found.headline}\n  {found.summary}")
