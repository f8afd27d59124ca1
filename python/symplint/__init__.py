"""Tells whether a numerical time-advance map is symplectic.

Closed loops of initial states are sent through one step of a map, and the Poincaré loop integrals ∮ p·dq before and
after are compared: W. Barham and J. W. Burby, "Diagnosing symplecticity in simulations of high-dimensional Hamiltonian
systems" (2025), arXiv:2512.13951.
"""

from . import adapters, integrators, systems
from ._check import assert_structure, assert_symplectic, check
from ._compose import Composition, compose
from ._errors import InputError, NotSymplecticError, StepError, StructureError, SymplintError, UndecidedError
from ._field import FieldReport, check_field, check_force
from ._loops import Circle, FourierLoop, Loop, SampledLoop, circle
from ._measure import LoopIntegral, loop_integral, measure
from ._names import Coordinates
from ._ode import from_ode
from ._native import __version__
from ._report import Cause, Property, Report

__all__ = [
    "Cause",
    "Circle",
    "Composition",
    "Coordinates",
    "FieldReport",
    "FourierLoop",
    "InputError",
    "Loop",
    "LoopIntegral",
    "NotSymplecticError",
    "Property",
    "Report",
    "SampledLoop",
    "StepError",
    "StructureError",
    "SymplintError",
    "UndecidedError",
    "__version__",
    "adapters",
    "assert_structure",
    "assert_symplectic",
    "check",
    "check_field",
    "check_force",
    "circle",
    "compose",
    "from_ode",
    "integrators",
    "loop_integral",
    "measure",
    "systems",
]

for _exception in (InputError, NotSymplecticError, StepError, StructureError, SymplintError, UndecidedError):
    # Tracebacks name them as users import them.
    _exception.__module__ = __name__
