"""Lattices of ImpactX."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .._arrays import Array
from .._errors import InputError
from ._step import AdaptedStep

__all__ = ["impactx"]

#: The coordinates of particles, as ImpactX names them: the positions, then the momenta.
COORDINATES = ("position_x", "position_y", "position_t", "momentum_x", "momentum_y", "momentum_t")
#: The attributes of a reference particle without s: elements use the distance from their entrance, and s is 0 there.
REFERENCE = ("x", "y", "z", "t", "px", "py", "pz", "pt", "mass", "charge", "gyromagnetic_anomaly")
#: Settings with which the new state of a particle depends on the other particles, or on random numbers.
COLLECTIVE = ("space_charge", "csr", "isr")


def impactx(simulation: Any) -> AdaptedStep:
    """One passage through the lattice of a simulation of ImpactX.

    Parameters
    ----------
    simulation : impactx.ImpactX
        The lattice, and the reference particle, which is the centre of the loops. Call its ``init_grids`` first. Its particles are removed.

    Returns
    -------
    AdaptedStep
        A map without a step size; radii are 1e-3. Its positions are (x, y, t) and its momenta (px, py, pt), all with the signs of ImpactX.
        The momenta are multiplied by the reference momentum at the end over that at the beginning. Its parts are the elements.

    Raises
    ------
    InputError
        If there are no elements, the reference particle has no energy, or the simulation computes space charge or radiation.

    Notes
    -----
    Set up once: copies of the elements, and the reference particle at the entrance of each element. For each call: new particles, all
    states at once, and this reference particle. Each element advances them slice by slice; monitors are left out. Programmable elements
    with a memory depend on earlier calls. ImpactX is installed from conda-forge or from source. ``examples/python/impactx_cfbend.py``
    tests a lattice.
    """
    if not hasattr(simulation, "lattice") or not hasattr(simulation, "init_grids"):
        raise InputError(f"simulation is an object of type {type(simulation).__name__}; give an impactx.ImpactX")
    if enabled := [name for name in COLLECTIVE if setting(simulation, name) not in (False, "false", "off")]:
        raise InputError(f"the step would leave out {' and '.join(enabled)} of the simulation; set simulation.{enabled[0]} = False")
    # Copies, as the elements of a simulation end with its lattice.
    lattice = type(simulation.lattice)([element for element in simulation.lattice if type(element).__name__ != "BeamMonitor"])
    elements = list(lattice)
    if not elements:
        raise InputError("the lattice of the simulation has no elements")
    beam = Beam(simulation)
    reference, s = beam.reference(), beam.live().s
    if not reference["pt"] < -1.0:
        raise InputError("the reference particle has no energy; set its charge, mass and kinetic energy")
    entrances = [reference]
    beam.fill(np.zeros((6, 1)))
    for element in elements:
        beam.push(element, entrances[-1])
        entrances.append(beam.reference())
    beam.set_reference(reference, s)
    # Reference momenta, divided by the first.
    scales = [math.sqrt((entrance["pt"] ** 2 - 1.0) / (reference["pt"] ** 2 - 1.0)) for entrance in entrances]

    def tracked(numbers: Sequence[int]) -> Callable[..., Any]:
        def step(q: Any, p: Any, _: Any = None) -> tuple[Any, Any]:
            beam.fill(np.concatenate([q.T, p.T / scales[numbers[0]]]))
            for number in numbers:
                beam.push(elements[number], entrances[number])
            beam.set_reference(reference, s)
            after = beam.coordinates()
            return after[:3].T, after[3:].T * scales[numbers[-1] + 1]

        return step

    parts = [(name_of(element), tracked([number])) for number, element in enumerate(elements)]
    centre = np.zeros(3)
    return AdaptedStep(
        tracked(range(len(elements))), "ImpactX lattice", centre, centre, radius=1e-3, per_sample=False, step_sizes="none", parts=parts
    )


class Beam:
    """The particles of a simulation with their reference particle.

    Parameters
    ----------
    simulation : impactx.ImpactX
        It has grids.
    """

    def __init__(self, simulation: Any) -> None:
        self.package, self.vectors = importlib.import_module("impactx"), importlib.import_module("amrex.space3d")
        # A property since ImpactX 26.04; `ref` also is one.
        self.container = simulation.beam if hasattr(simulation, "beam") else simulation.particle_container()

    def live(self) -> Any:
        """The reference particle, which elements change."""
        return self.container.ref if hasattr(self.container, "ref") else self.container.ref_particle()

    def reference(self) -> dict[str, float]:
        """The attributes of the reference particle now."""
        live = self.live()
        return {name: getattr(live, name) for name in REFERENCE if hasattr(live, name)}

    def set_reference(self, attributes: dict[str, float], s: float = 0.0) -> None:
        """Give the reference particle these attributes; the entrance of its element is at s = 0."""
        made = self.package.RefPart()
        made.s = s
        for name, value in attributes.items():
            setattr(made, name, value)
        self.container.set_ref_particle(made)

    def fill(self, coordinates: Array) -> None:
        """Replace all particles."""
        vectors = [self.vectors.PODVector_real_std(coordinates.shape[1]) for _ in coordinates]
        for vector, values in zip(vectors, coordinates, strict=True):
            vector.to_numpy()[:] = values
        self.container.clear_particles()
        # The charges have no effect without collective effects.
        self.container.add_n_particles(*vectors, 1.0, 0.0)

    def push(self, element: Any, entrance: dict[str, float]) -> None:
        """Advance all particles through an element."""
        self.set_reference(entrance)
        for _ in range(element.nslice):
            self.package.push(self.container, element)

    def coordinates(self) -> Array:
        """The coordinates of all particles, in the order in which they were added; they are removed."""
        tiles = [tile.soa().to_numpy(copy=True) for tile in self.package.ImpactXParIter(self.container, level=0) if tile.size]
        self.container.clear_particles()
        identity = np.concatenate([tile.idcpu for tile in tiles])
        # The highest bit is 0 if a particle is lost.
        if lost := int((identity < 1 << 63).sum()):
            raise RuntimeError(f"{lost} of {len(identity)} particles are lost; make the radius smaller, or take apertures out")
        order = np.argsort(identity)
        return np.stack([np.concatenate([tile.real[name] for tile in tiles])[order] for name in COORDINATES])


def setting(simulation: Any, name: str) -> Any:
    """A setting of a simulation, or False if it is not set."""
    try:
        return getattr(simulation, name)
    except (AttributeError, RuntimeError):
        return False


def name_of(element: Any) -> str:
    """The name and the type of an element."""
    kind = type(element).__name__
    return f"{element.name} ({kind})" if getattr(element, "has_name", False) else kind
