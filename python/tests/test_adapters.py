"""Adapters of other packages: verdicts on methods whose truth is known.

A method is symplectic if it composes flows of Hamiltonians (Verlet, Wisdom–Holman, symplectic Euler), is a symplectic Runge–Kutta method,
or is exact. If the reason is another one, a comment states it. Besides the system, a user writes only the line with `adapters`.
"""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import symplint
from symplint import adapters

BUDGET = {"budget": 4000, "loops": 3}


def agrees(step, symplectic, **arguments):
    """The report on a step, whose verdict has to be this one."""
    report = symplint.check(step, **BUDGET | arguments)
    assert report.is_symplectic is symplectic, report
    return report


@pytest.fixture
def double_precision():
    """JAX in double precision."""
    jax = pytest.importorskip("jax")
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield jax
    jax.config.update("jax_enable_x64", before)


# REBOUND ------------------------------------------------------------------------------------------------------------------------------


def planets(integrator, **options):
    """Two planets between one and three critical radii of MERCURIUS apart."""
    rebound = pytest.importorskip("rebound", minversion="5")
    simulation = rebound.Simulation()
    simulation.add(m=1.0)
    simulation.add(m=1e-3, a=1.0, e=0.05)
    simulation.add(m=1e-3, a=1.3, e=0.05, f=0.1)
    simulation.integrator, simulation.dt = integrator, 0.05
    for name, value in options.items():
        setattr(simulation.integrator, name, value)
    return simulation


@pytest.mark.parametrize(
    ("integrator", "options", "symplectic"),
    [
        ("whfast", {}, True),
        ("whfast", {"coordinates": "DEMOCRATICHELIOCENTRIC", "safe_mode": 0}, True),
        ("leapfrog", {}, True),
        # As the critical radii are computed once.
        ("mercurius", {}, True),
        # The flow, to rounding.
        ("ias15", {}, True),
        # Extrapolation with a loose tolerance.
        ("bs", {"eps_rel": 1e-3, "eps_abs": 1e-3}, False),
        # Reversible: chooses one of two methods by the state.
        ("trace", {}, False),
    ],
)
def test_rebound(integrator, options, symplectic):
    agrees(adapters.rebound(planets(integrator, **options)), symplectic)


def test_critical_radii_of_each_state_are_not_symplectic():
    simulation = planets("mercurius")
    adapted = adapters.rebound(simulation)

    def anew(q, v, h):
        of_state = simulation.copy()
        of_state.dt = h
        of_state.set_serialized_particle_data(xyz=q.copy(), vxvyvz=v.copy())
        return adapters.rebound(of_state)(q, v, h)

    agrees(anew, False, q0=adapted.q0, p0=adapted.p0, weight=adapted.weight, radius=adapted.radius, typical_step=0.05, per_sample=True)


def test_functions_of_a_simulation_are_kept():
    def friction(simulation):
        def force(pointer):
            for body in simulation.particles:
                body.ax -= 0.1 * body.vx

        simulation.additional_forces = force
        simulation.force_is_velocity_dependent = 1

    simulation = planets("leapfrog")
    agrees(adapters.rebound(simulation), True)
    agrees(adapters.rebound(simulation, prepare=friction), False)


def test_simulations_that_have_no_momenta_are_refused():
    simulation = planets("leapfrog")
    simulation.add(a=2.0)
    with pytest.raises(symplint.InputError, match="particle 3 has the mass 0"):
        adapters.rebound(simulation)
    with pytest.raises(symplint.InputError, match="REBOUND 5"):
        adapters.rebound("simulation")


# ASE ----------------------------------------------------------------------------------------------------------------------------------


def copper():
    ase, emt = pytest.importorskip("ase"), pytest.importorskip("ase.calculators.emt")
    momenta = [[1.0, 0.3, -0.2], [-0.5, 0.2, 0.4]]
    return ase.Atoms("Cu2", [[0.0, 0.0, 0.0], [2.2, 0.3, 0.4]], momenta=momenta, calculator=emt.EMT())


@pytest.mark.parametrize(
    ("module", "name", "options", "symplectic"),
    [
        ("verlet", "VelocityVerlet", {}, True),
        ("langevin", "Langevin", {"temperature_K": 300, "friction": 0.05, "rng": np.random.RandomState(1), "fixcm": False}, False),
        # Scales the momenta.
        ("nvtberendsen", "NVTBerendsen", {"temperature_K": 300, "taut": 5.0, "fixcm": False}, False),
    ],
)
def test_ase(module, name, options, symplectic):
    atoms = copper()
    dynamics = getattr(pytest.importorskip(f"ase.md.{module}"), name)
    before = atoms.get_positions()
    agrees(adapters.ase(atoms, dynamics, **options), symplectic, budget=1500)
    assert np.array_equal(atoms.get_positions(), before)


def test_fixed_atoms_are_left_out():
    atoms = copper()
    constraints, verlet = pytest.importorskip("ase.constraints"), pytest.importorskip("ase.md.verlet")
    atoms.set_constraint(constraints.FixAtoms([0]))
    step = adapters.ase(atoms, verlet.VelocityVerlet)
    assert step.q0.tolist() == [2.2, 0.3, 0.4]
    agrees(step, True, radius=(0.05, 1.0))
    atoms.set_constraint(constraints.FixBondLength(0, 1))
    with pytest.raises(symplint.InputError, match="FixBondLength"):
        adapters.ase(atoms, verlet.VelocityVerlet)
    with pytest.raises(symplint.InputError, match="VelocityVerlet"):
        adapters.ase(atoms, "verlet")
    atoms.calc = None
    with pytest.raises(symplint.InputError, match="calculator"):
        adapters.ase(atoms, verlet.VelocityVerlet)


# OpenMM -------------------------------------------------------------------------------------------------------------------------------

LENGTH, ANGLE = 0.09572, 1.82421813


def water(make, platform="Reference", constraint=False):
    """A flexible molecule of water."""
    openmm = pytest.importorskip("openmm")
    system, bonds, angles = openmm.System(), openmm.HarmonicBondForce(), openmm.HarmonicAngleForce()
    for mass in (15.999, 1.008, 1.008):
        system.addParticle(mass)
    for hydrogen in (1, 2):
        bonds.addBond(0, hydrogen, LENGTH, 462750.4)
    angles.addAngle(1, 0, 2, ANGLE, 836.8)
    system.addForce(bonds)
    system.addForce(angles)
    if constraint:
        system.addConstraint(0, 1, LENGTH)
    context = openmm.Context(system, make(openmm), openmm.Platform.getPlatformByName(platform))
    context.setPositions(LENGTH * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [np.cos(ANGLE), np.sin(ANGLE), 0.0]]))
    context.setVelocities(np.linspace(-1.0, 1.0, 9).reshape(3, 3))
    return context


def expressions(*steps):
    def make(openmm):
        integrator = openmm.CustomIntegrator(0.001)
        integrator.addPerDofVariable("a", 0.0)
        for variable, expression in steps:
            integrator.addComputePerDof(variable, expression)
        return integrator

    return make


@pytest.mark.parametrize(
    ("make", "symplectic"),
    [
        (lambda openmm: openmm.VerletIntegrator(0.001), True),
        (expressions(("x", "x+dt*v"), ("v", "v+dt*f/m")), True),
        # Explicit Euler.
        (expressions(("a", "f/m"), ("x", "x+dt*v"), ("v", "v+dt*a")), False),
        (lambda openmm: openmm.LangevinMiddleIntegrator(300.0, 1.0, 0.001), False),
        # Noise that scales with the velocity: friction.
        (expressions(("x", "x+dt*v"), ("v", "v*(1-0.01*gaussian^2)+dt*f/m")), False),
        # The velocities are scaled.
        (lambda openmm: openmm.NoseHooverIntegrator(300.0, 1.0, 0.001), False),
    ],
)
def test_openmm(make, symplectic):
    agrees(adapters.openmm(water(make)), symplectic)


def test_openmm_in_single_precision():
    report = agrees(adapters.openmm(water(lambda openmm: openmm.VerletIntegrator(0.001), "CPU")), True, budget=8000)
    assert report.digits < 8


def test_systems_without_canonical_momenta_are_refused():
    with pytest.raises(symplint.InputError, match="1 constraints"):
        adapters.openmm(water(lambda openmm: openmm.VerletIntegrator(0.001), constraint=True))
    with pytest.raises(symplint.InputError, match="chooses its step sizes"):
        adapters.openmm(water(lambda openmm: openmm.VariableVerletIntegrator(1e-3)))


# Mici ---------------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "options", "symplectic"),
    [
        ("LeapfrogIntegrator", {}, True),
        ("BCSSTwoStageIntegrator", {}, True),
        # The midpoint rule, whose equations are solved to a tolerance of 1e-3.
        ("ImplicitMidpointIntegrator", {"reverse_check_tol": 1.0, "fixed_point_solver_kwargs": {"convergence_tol": 1e-3}}, False),
    ],
)
def test_mici(name, options, symplectic):
    mici = pytest.importorskip("mici")

    def gradient(q):
        return 4.0 * q**3 + np.array([q[1] ** 2, 2.0 * q[0] * q[1]])

    system = mici.systems.EuclideanMetricSystem(lambda q: (q**4).sum() + q[0] * q[1] ** 2, grad_neg_log_dens=gradient)
    integrator = getattr(mici.integrators, name)(system, step_size=0.1, **options)
    state = mici.states.ChainState(pos=np.array([0.5, 0.3]), mom=np.array([0.2, -0.4]), dir=1)
    agrees(adapters.mici(integrator, state), symplectic)
    with pytest.raises(symplint.InputError, match="ChainState"):
        adapters.mici(integrator, None)


# MuJoCo -------------------------------------------------------------------------------------------------------------------------------

LINK = '<geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.05"/>'


def pendulum(integrator, links, joint='type="hinge" axis="0 1 0"'):
    mujoco = pytest.importorskip("mujoco")
    inner = f'<body pos="0 0 -0.5"><joint type="hinge" axis="0 1 0"/>{LINK}</body>' if links == 2 else ""
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="0.01" integrator="{integrator}"><flag contact="disable"/></option>'
        f"<worldbody><body><joint {joint}/>{LINK}{inner}</body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    if model.nq == links:
        data.qpos[:], data.qvel[:] = [0.5, 0.3][:links], [0.4, -0.7][:links]
    return model, data


@pytest.mark.parametrize(
    ("integrator", "links", "symplectic"),
    [
        # Symplectic Euler, as the mass matrix is constant.
        ("Euler", 1, True),
        # The mass matrix depends on the position, and forces on the velocity.
        ("Euler", 2, False),
        ("RK4", 1, False),
    ],
)
def test_mujoco(integrator, links, symplectic):
    agrees(adapters.mujoco(*pendulum(integrator, links)), symplectic)


def test_the_momenta_of_mujoco_are_canonical():
    # Steps of RK4 this small are the flow to rounding, which is symplectic in (q, M(q) v) and in no other momenta.
    step = adapters.mujoco(*pendulum("RK4", 2))

    def flow(q, p, h):
        for _ in range(50):
            q, p = step(q, p, h / 50)
        return q, p

    agrees(flow, True, q0=step.q0, p0=step.p0, step_sizes=[0.01], radius="auto", per_sample=True)


def test_threads_take_turns():
    step = adapters.mujoco(*pendulum("RK4", 2))
    serial = agrees(step, False)
    with ThreadPoolExecutor(4) as threads:
        assert np.array_equal(agrees(step, False, workers=threads).points["final"], serial.points["final"])


def test_steps_may_be_pickled():
    step = adapters.AdaptedStep(np.add, "sum", [0.0], [1.0])
    again = pickle.loads(pickle.dumps(step))
    assert repr(again) == repr(step) and again(1.0, 2.0, None) == 3.0


def test_quaternions_are_refused():
    with pytest.raises(symplint.InputError, match="hinges and slides"):
        adapters.mujoco(*pendulum("Euler", 1, joint='type="ball"'))


# Accelerators -------------------------------------------------------------------------------------------------------------------------


def test_pyat():
    at = pytest.importorskip("at")
    magnets = [at.Quadrupole("QF", 0.5, 1.2), at.Drift("D", 2.0), at.Sextupole("S", 0.1, 5.0), at.Quadrupole("QD", 0.5, -1.2)]
    agrees(adapters.pyat(at.Lattice([*magnets, at.Dipole("B", 1.0, 0.1)], energy=3e9)), True)
    cavity = at.RFCavity("C", 0.0, 1e6, 5e8, 100, 3e9, PassMethod="RFCavityPass")
    agrees(adapters.pyat(at.Lattice([*magnets, cavity], energy=3e9)), True)
    # Particles lose energy.
    radiating = at.Dipole("B", 1.0, 0.1, PassMethod="BndMPoleSymplectic4RadPass")
    report = agrees(adapters.pyat(at.Lattice([*magnets, radiating], energy=3e9)), False)
    assert any("substep 5 (B (BndMPoleSymplectic4RadPass))" in sentence for sentence in report.sentences)
    with pytest.raises(symplint.InputError, match="six numbers"):
        adapters.pyat(at.Lattice(magnets, energy=3e9), orbit=[0.0])


def test_xtrack():
    xt = pytest.importorskip("xtrack")

    def line(*more):
        elements = [xt.Quadrupole(length=0.5, k1=0.6), xt.Drift(length=2.0), xt.Sextupole(length=0.1, k2=2.0), *more]
        made = xt.Line(elements)
        made.particle_ref = xt.Particles(mass0=xt.PROTON_MASS_EV, p0c=2e9)
        return made

    agrees(adapters.xtrack(line(xt.Bend(length=1.0, angle=0.1, k0=0.1))), True)
    agrees(adapters.xtrack(line(xt.Cavity(voltage=1e6, frequency=4e8, phase=0.3))), True)
    # In momenta that are not divided by a reference that changes.
    agrees(adapters.xtrack(line(xt.ReferenceEnergyIncrease(Delta_p0c=1e8))), True)
    damping = np.diag([1.0, 0.999, 1.0, 1.0, 1.0, 1.0])
    report = agrees(adapters.xtrack(line(xt.FirstOrderTaylorMap(m1=damping, length=0.0, m0=np.zeros(6)))), False)
    assert any("substep 4 (e3)" in sentence for sentence in report.sentences)
    with pytest.raises(symplint.StepError, match="particles are lost"):
        symplint.check(adapters.xtrack(line(xt.LimitEllipse(a=1e-4, b=1e-4))), **BUDGET)
    with pytest.raises(symplint.InputError, match="particle_ref"):
        adapters.xtrack(xt.Line([xt.Drift(length=1.0)]))


@pytest.fixture
def simulation(tmp_path, monkeypatch):
    """A simulation of ImpactX with a reference particle, and no elements."""
    impactx = pytest.importorskip("impactx")
    # ImpactX writes to the folder.
    monkeypatch.chdir(tmp_path)
    made = impactx.ImpactX()
    made.particle_shape, made.diagnostics, made.verbose = 2, False, 0
    made.init_grids()
    impactx_beam(made)[1].set_charge_qe(1.0).set_mass_MeV(938.272).set_kin_energy_MeV(2e3)
    yield made
    made.finalize()


def impactx_beam(simulation):
    """The particles of a simulation and its reference particle."""
    if hasattr(simulation, "beam"):
        return simulation.beam, simulation.beam.ref
    return simulation.particle_container(), simulation.particle_container().ref_particle()


def impactx_lattice(simulation, *elements):
    simulation.lattice.clear()
    simulation.lattice.extend(list(elements))
    return adapters.impactx(simulation)


def impactx_cavity():
    """Fields that depend on the distance from the entrance and on the time of the reference particle."""
    from impactx import elements

    coefficients = {"cos_coefficients": [0.5, 0.2], "sin_coefficients": [0.0, 0.0]}
    return elements.RFCavity(ds=1.0, escale=1.0, freq=4e8, phase=40.0, mapsteps=20, nslice=3, **coefficients)


def test_impactx(simulation):
    from impactx import __version__, elements

    magnets = [elements.ChrQuad(ds=0.5, k=0.6), elements.Multipole(multipole=3, K_normal=20.0, K_skew=0.0), elements.ExactDrift(ds=2.0)]
    linear = [elements.Quad(ds=0.5, k=0.6, nslice=4), elements.Drift(ds=2.0), elements.Sbend(ds=1.0, rc=5.0)]
    # Exact maps of Hamiltonians.
    agrees(impactx_lattice(simulation, *linear), True)
    step = impactx_lattice(simulation, *magnets, elements.ExactSbend(ds=1.0, phi=10.0))
    agrees(step, True)
    # (t, -pt) is not a canonical pair.
    agrees(step, False, weight=[1.0, 1.0, -1.0])
    # In momenta that are not divided by a reference that changes.
    for cavity in (elements.ShortRF(V=0.5, freq=4e8, phase=-30.0), elements.ChrAcc(ds=1.0, ez=0.5, bz=0.3), impactx_cavity()):
        agrees(impactx_lattice(simulation, *magnets, cavity), True)
    # Before 25.03, a bend of this kind did not advance t: https://github.com/BLAST-ImpactX/impactx/pull/854
    corrected = tuple(int(number) for number in __version__.split(".")[:2]) >= (25, 3)
    report = agrees(impactx_lattice(simulation, *magnets, elements.CFbend(ds=1.0, rc=5.0, k=0.3, name="bend")), corrected)
    assert corrected or any("substep 4 (bend (CFbend))" in sentence for sentence in report.sentences)


def test_programmable_elements_of_impactx(simulation):
    from impactx import elements

    def damp(particles, reference):
        particles.soa().to_numpy().real["momentum_x"][:] *= 0.999

    damper = elements.Programmable(name="damper")
    damper.beam_particles, damper.ref_particle = damp, lambda reference: None
    report = agrees(impactx_lattice(simulation, elements.Drift(ds=0.5), damper, elements.ChrQuad(ds=0.5, k=0.6)), False)
    assert any("substep 2 (damper (Programmable))" in sentence for sentence in report.sentences)


def test_states_are_those_of_impactx(simulation):
    from amrex.space3d import PODVector_real_std
    from impactx import ImpactXParIter, elements

    beam, reference = impactx_beam(simulation)
    bend, cavity = elements.ExactSbend(ds=1.0, phi=10.0), elements.ShortRF(V=0.1, freq=4e8, phase=-30.0)
    step = impactx_lattice(simulation, elements.Drift(ds=0.3), impactx_cavity(), bend, cavity, impactx_cavity())
    q, p = 1e-3 * np.random.default_rng(1).normal(size=(2, 16, 3))
    expected = step(q, p)
    before = reference.pt
    # The tracking loop of ImpactX.
    vectors = [PODVector_real_std(16) for _ in range(6)]
    for vector, values in zip(vectors, [*q.T, *p.T], strict=True):
        vector.to_numpy()[:] = values
    beam.add_n_particles(*vectors, 1.0, 0.0)
    simulation.track_particles()
    scale = np.sqrt((reference.pt**2 - 1.0) / (before**2 - 1.0))
    assert scale > 1.01
    tiles = [list(tile.soa().to_numpy(copy=True).real.values())[:6] for tile in ImpactXParIter(beam, level=0) if tile.size]
    rows = np.concatenate(tiles, axis=1)
    assert np.allclose(rows[:3].T, expected[0], rtol=1e-12, atol=1e-16)
    assert np.allclose(rows[3:].T * scale, expected[1], rtol=1e-12, atol=1e-16)
    state = q, p
    for _, part in step.parts:
        state = part(*state)
    assert np.allclose(state[0], expected[0], rtol=1e-12, atol=1e-16) and np.allclose(state[1], expected[1], rtol=1e-12, atol=1e-16)
    # The step does not depend on later changes of the simulation.
    simulation.lattice.clear()
    alone = [step(q[row : row + 1], p[row : row + 1]) for row in range(16)]
    for whole, rows in zip(expected, zip(*alone, strict=True), strict=True):
        assert np.array_equal(whole, np.concatenate(rows))
    assert reference.pt == before and reference.s == 0.0


def test_simulations_of_impactx_that_are_refused(simulation):
    from impactx import RefPart, elements

    with pytest.raises(symplint.StepError, match="particles are lost"):
        symplint.check(impactx_lattice(simulation, elements.Aperture(5e-4, 5e-4)), **BUDGET)
    with pytest.raises(symplint.InputError, match="no elements"):
        impactx_lattice(simulation, elements.BeamMonitor("monitor"))
    with pytest.raises(symplint.InputError, match="ImpactX"):
        adapters.impactx("simulation")
    simulation.csr = True
    with pytest.raises(symplint.InputError, match="csr = False"):
        impactx_lattice(simulation, elements.Drift(ds=1.0))
    simulation.csr = False
    impactx_beam(simulation)[0].set_ref_particle(RefPart())
    with pytest.raises(symplint.InputError, match="no energy"):
        impactx_lattice(simulation, elements.Drift(ds=1.0))


# JAX ----------------------------------------------------------------------------------------------------------------------------------


def has_exact_jacobian(report):
    return any("Jacobian" in sentence and "(exact derivatives)" in sentence for sentence in report.sentences)


@pytest.mark.parametrize(
    ("name", "symplectic"),
    # An isokinetic step keeps the momentum on a sphere.
    [("velocity_verlet", True), ("mclachlan", True), ("isokinetic_velocity_verlet", False)],
)
def test_blackjax(double_precision, name, symplectic):
    integrators = pytest.importorskip("blackjax.mcmc.integrators")
    step = adapters.blackjax(
        lambda q: -(q**4).sum() - q[0] * q[1] ** 2, [0.5, 0.3], [0.6, -0.8], integrator=getattr(integrators, name),
        inverse_mass_matrix=[1.0, 2.0],
    )  # fmt: skip
    report = agrees(step, symplectic)
    assert step.__name__ == f"BlackJAX {name}"
    assert has_exact_jacobian(report) or not symplectic


def test_diffrax(double_precision):
    diffrax, jax = pytest.importorskip("diffrax"), double_precision
    whole = diffrax.ODETerm(lambda t, y, args: (y[1], -args * jax.numpy.sin(y[0])))
    pair = (diffrax.ODETerm(lambda t, p, args: p), diffrax.ODETerm(lambda t, q, args: -args * jax.numpy.sin(q)))
    state = ([1.0, 0.3], [0.5, -0.2])
    exact = agrees(adapters.diffrax(pair, diffrax.SemiImplicitEuler(), *state, args=1.0), True)
    assert has_exact_jacobian(exact)
    exact = agrees(adapters.diffrax(whole, diffrax.Tsit5(), *state, args=1.0), False)
    assert has_exact_jacobian(exact)
    agrees(adapters.diffrax(whole, diffrax.Midpoint(), *state, args=1.0), False, jacobian=False)
    # The states are those of Diffrax, for methods of all kinds.
    y = tuple(jax.numpy.asarray(row) for row in state)
    chord = diffrax.VeryChord(rtol=1e-8, atol=1e-8, norm=lambda x: abs(jax.flatten_util.ravel_pytree(x)[0]).max())
    control = diffrax.PIDController(rtol=1e-3, atol=1e-5)
    for solver, controller in ((diffrax.Tsit5(), None), (diffrax.Bosh3(), control), (diffrax.Kvaerno3(root_finder=chord), None)):
        step = adapters.diffrax(whole, solver, *state, args=1.0, controller=controller)
        q, p = step(*(np.array([row]) for row in state), 0.05)
        controlled = {} if controller is None else {"stepsize_controller": controller}
        found = diffrax.diffeqsolve(whole, solver, 0.0, 0.05, 0.05 if controller is None else None, y, 1.0, **controlled)
        assert np.allclose(found.ys[0][0], q[0], rtol=1e-15) and np.allclose(found.ys[1][0], p[0], rtol=1e-15)
    with pytest.raises(symplint.InputError, match="solver of Diffrax"):
        adapters.diffrax(whole, "Tsit5", *state)


def test_jax_in_single_precision():
    jax, _ = pytest.importorskip("jax"), pytest.importorskip("blackjax")
    if jax.config.jax_enable_x64:
        pytest.skip("JAX computes in double precision")
    report = agrees(adapters.blackjax(lambda q: -(q**4).sum(), [0.5, 0.3], [0.6, -0.8]), True, budget=20_000)
    assert report.digits < 8


# What check does with the steps -------------------------------------------------------------------------------------------------------


def test_a_step_states_what_check_leaves_open(tmp_path):
    def leapfrog(q, v, h):
        q = q + 0.5 * h * v
        v = v - h * np.array([np.sin(q[0] - q[1]), np.sin(q[1] - q[0]) / 3.0])
        return q + 0.5 * h * v, v

    step = adapters.AdaptedStep(leapfrog, "two bodies", [0.3, 1.0], [0.1, 0.2], weight=[1.0, 3.0], typical_step=0.1)
    report = agrees(step, True)
    assert "two bodies" in str(report)
    agrees(step, False, weight=[1.0, 1.0])
    agrees(step, True, q0=[0.0, 0.5], radius=0.2, step_sizes=[0.2, 0.1])
    with pytest.raises(symplint.InputError, match="key="):
        symplint.check(step, run_dir=tmp_path)
    agrees(step, True, run_dir=tmp_path, key="two bodies, version 1")
    with pytest.raises(symplint.InputError, match="args"):
        symplint.check(step, args=(1.0,))
