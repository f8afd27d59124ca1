"""Steps of other packages, as `symplint.check` takes them.

Each function takes an object of its package and returns an `AdaptedStep`, which has the centre of the loops, masses and
step sizes: ``symplint.check(symplint.adapters.rebound(simulation))``. Its documentation states what is set up once and what for each
state. This matters: a method that computes a parameter from the first state, such as the critical radius of MERCURIUS, is symplectic if
this parameter is kept, and is not if each state has its own.
"""

from ._ase import ase
from ._blackjax import blackjax
from ._diffrax import diffrax
from ._impactx import impactx
from ._mici import mici
from ._mujoco import mujoco
from ._openmm import openmm
from ._pyat import pyat
from ._rebound import rebound
from ._step import AdaptedStep
from ._xtrack import xtrack

__all__ = ["AdaptedStep", "ase", "blackjax", "diffrax", "impactx", "mici", "mujoco", "openmm", "pyat", "rebound", "xtrack"]

AdaptedStep.__module__ = __name__
