"""Tests a lattice of ImpactX: the combined-function bend of release 24.10 does not advance t, and release 25.03 corrects it.

    python examples/python/impactx_cfbend.py

ImpactX is installed from conda-forge or from source; pip does not install it.
"""

import symplint
from impactx import ImpactX, elements

simulation = ImpactX()
simulation.particle_shape, simulation.diagnostics, simulation.verbose = 2, False, 0
simulation.init_grids()
# Before ImpactX 26.04, the beam is a method.
beam = getattr(simulation, "beam", None)
reference = beam.ref if beam is not None else simulation.particle_container().ref_particle()
reference.set_charge_qe(1.0).set_mass_MeV(938.272).set_kin_energy_MeV(2e3)
bend = elements.CFbend(ds=1.0, rc=5.0, k=0.3, name="B")
simulation.lattice.extend([elements.ChrQuad(ds=0.5, k=0.6), elements.ExactDrift(ds=2.0), bend])
report = symplint.check(symplint.adapters.impactx(simulation))
print(report.headline)
print(*[text for text in report.sentences if "substep" in text], sep="\n")
simulation.finalize()
