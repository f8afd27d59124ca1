"""Verdicts on released packages: `python register.py ENTRY` prints the version and the verdict of one entry.

Without an entry, it lists all of them. `--row` prints a row of the table. `pip install PACKAGE` installs the package that an entry needs.
docs/register.md has the results.
"""

import importlib
import importlib.metadata
import re
import sys

import numpy as np
import register_physics
import register_solvers
import symplint

KEPLER = [1.0, 0.0], [0.0, 1.1]


def _kepler_force(q):
    return -q / np.linalg.norm(q, axis=-1, keepdims=True) ** 3


def rebound(integrator):
    import rebound

    masses = np.repeat([1.0, 9.5e-4, 2.9e-4], 2)

    def step(q, v, h):
        simulation = rebound.Simulation()
        simulation.integrator = integrator
        simulation.dt = h
        for k in (0, 2, 4):
            simulation.add(m=masses[k], x=q[k], y=q[k + 1], vx=v[k], vy=v[k + 1])
        if integrator in ("ias15", "bs"):
            simulation.integrate(h)
        else:
            simulation.steps(1)
            simulation.synchronize()
        bodies = simulation.particles
        return [c for body in bodies for c in (body.x, body.y)], [c for body in bodies for c in (body.vx, body.vy)]

    radius = np.repeat([1e-3, 0.1, 0.1], 2)
    q0, v0 = [-4e-3, 1e-3, 5.2, 0.0, 0.0, 9.6], [-8e-5, -4e-4, 0.0, 0.439, -0.323, 0.0]
    return symplint.check(
        step, q0, v0, weight=masses, radius=(radius, 0.05 * radius), step_sizes=[4.0, 2.0, 1.0],
        per_sample=True, budget=4000, loops=3,
    )  # fmt: skip


def scipy(method):
    import scipy.integrate

    solver = getattr(scipy.integrate, method)

    def field(t, y):
        q, p = y
        return [p, -np.sin(q)]

    return symplint.check(
        symplint.from_ode(field, solver), 1.0, 0.5, per_sample=True, step_sizes=[0.5, 0.25, 0.125], budget=3000
    )


def ase(dynamics):
    import ase.md.verlet
    from ase import Atoms
    from ase.calculators.emt import EMT

    def step(q, p, h):
        atoms = Atoms("Cu3", positions=q.reshape(3, 3), momenta=p.reshape(3, 3), calculator=EMT())
        getattr(ase.md.verlet, dynamics)(atoms, timestep=h).run(1)
        return atoms.get_positions().ravel(), atoms.get_momenta().ravel()

    q0 = np.array([[0.0, 0.0, 0.0], [2.4, 0.0, 0.0], [1.2, 2.1, 0.0]]).ravel()
    return symplint.check(
        step, q0, np.zeros(9), per_sample=True, radius=(0.05, 1.0), step_sizes=[0.5, 0.25, 0.125], budget=4000, loops=3
    )


def openmm(integrator):
    import openmm

    system = openmm.System()
    system.addParticle(12.0)
    system.addParticle(1.0)
    bond = openmm.HarmonicBondForce()
    bond.addBond(0, 1, 0.11, 2e5)
    system.addForce(bond)
    platform = openmm.Platform.getPlatformByName("Reference")

    def step(q, v, h):
        arguments = {"VerletIntegrator": (h,), "VariableVerletIntegrator": (1e-4,)}[integrator]
        context = openmm.Context(system, getattr(openmm, integrator)(*arguments), platform)
        context.setPositions(q.reshape(2, 3))
        context.setVelocities(v.reshape(2, 3))
        context.getIntegrator().step(1)
        state = context.getState(positions=True, velocities=True)
        return state.getPositions(asNumpy=True)._value.ravel(), state.getVelocities(asNumpy=True)._value.ravel()

    masses = np.repeat([12.0, 1.0], 3)
    return symplint.check(
        step, [0, 0, 0, 0.11, 0, 0], np.zeros(6), weight=masses, per_sample=True, radius=(0.005, 0.5),
        step_sizes=[1e-3, 5e-4, 2.5e-4], budget=4000, loops=3,
    )  # fmt: skip


def gala(integrator):
    import gala.integrate

    def field(t, w):
        q, p = w[:2], w[2:]
        return np.concatenate([p, _kepler_force(q.T).T])

    def make(h):
        def advance(q, p):
            orbit = getattr(gala.integrate, integrator)(field)
            w = orbit(np.concatenate([q, p]), dt=h, n_steps=1).w()[:, -1]
            return w[:2], w[2:]

        return advance

    return symplint.check(
        make, *KEPLER, make=True, per_sample=True, radius=0.1, step_sizes=[0.2, 0.1, 0.05], budget=3000
    )


def galpy(method):
    from galpy.orbit import Orbit
    from galpy.potential import IsochronePotential

    potential = IsochronePotential(normalize=1.0, b=0.5)

    def step(q, p, h):
        # (R, vR) and (phi, R vT) are canonical pairs.
        (r, phi), (vr, lz) = q, p
        orbit = Orbit([r, vr, lz / r, phi])
        orbit.integrate(np.array([0.0, h]), potential, method=method)
        r1 = orbit.R(h)
        return [r1, orbit.phi(h)], [orbit.vR(h), r1 * orbit.vT(h)]

    return symplint.check(
        step, [1.0, 0.0], [0.1, 0.9], per_sample=True, radius=0.05, period=[0, 2 * np.pi], step_sizes=[0.4, 0.2, 0.1],
        budget=2000, loops=3,
    )  # fmt: skip


def at(method):
    import at as pyat

    element = {
        "drift": lambda h: pyat.Drift("D", h),
        "quadrupole": lambda h: pyat.Quadrupole("Q", h, 1.2, NumIntSteps=4),
        "sextupole": lambda h: pyat.Sextupole("S", h, 40.0, NumIntSteps=4),
        "dipole": lambda h: pyat.Dipole("B", h, 0.2 * h, NumIntSteps=4),
        "dipole-radiation": lambda h: pyat.Dipole(
            "B", h, 0.2 * h, NumIntSteps=4, PassMethod="BndMPoleSymplectic4RadPass"
        ),
    }[method]

    def make(h):
        lattice = pyat.Lattice([element(h)], energy=3e9)

        def advance(q, p):
            # Columns x, px, y, py, delta, ct: delta is the position of the third pair.
            (x, y, delta), (px, py, ct) = q.T, p.T
            beam = np.asfortranarray(np.stack([x, px, y, py, delta, ct]))
            pyat.lattice_track(lattice, beam, in_place=True)
            return beam[[0, 2, 4]].T, beam[[1, 3, 5]].T

        return advance

    return symplint.check(
        make, [1e-3, 1e-3, 1e-3], [2e-4, -1e-4, 0.0], make=True, radius=([3e-3, 3e-3, 3e-3], [1e-3, 1e-3, 1e-3]),
        step_sizes=[1.0, 0.5, 0.25],
    )  # fmt: skip


def mujoco(integrator):
    import mujoco

    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option integrator="{integrator}" gravity="0 0 -1"/><worldbody><body>
        <joint type="hinge" axis="0 1 0" damping="0"/><geom type="sphere" size="0.1" pos="0 0 -1" mass="1"/>
        </body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    inertia = model.body_inertia[1][1] + model.body_mass[1]

    def step(q, v, h):
        mujoco.mj_resetData(model, data)
        model.opt.timestep = h
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_step(model, data)
        return data.qpos.copy(), data.qvel.copy()

    return symplint.check(step, 1.0, 0.5, weight=inertia, per_sample=True, step_sizes=[0.4, 0.2, 0.1], budget=3000)


def diffrax(solver):
    import diffrax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    if solver == "SemiImplicitEuler":
        terms = (diffrax.ODETerm(lambda t, p, _: p), diffrax.ODETerm(lambda t, q, _: -jnp.sin(q)))
    else:
        terms = diffrax.ODETerm(lambda t, y, _: (y[1], -jnp.sin(y[0])))
    method = getattr(diffrax, solver)()

    @jax.jit
    def step(q, p, h):
        state = method.init(terms, 0.0, h, (q, p), None)
        (q, p), *_ = method.step(terms, 0.0, h, (q, p), None, state, made_jump=False)
        return q, p

    return symplint.check(step, 1.0, 0.5, step_sizes=[0.5, 0.25, 0.125])


def blackjax(integrator):
    import jax
    import jax.numpy as jnp
    from blackjax.mcmc import integrators

    jax.config.update("jax_enable_x64", True)

    def log_density(q):
        return jnp.sum(jnp.cos(q)) - 0.1 * q[0] ** 2 * q[1] ** 2

    def kinetic(p, position=None):
        return 0.5 * jnp.sum(p**2)

    one = getattr(integrators, integrator)(log_density, kinetic)

    @jax.jit
    def step(q, p, h):
        def of_state(q, p):
            state = integrators.IntegratorState(q, p, log_density(q), jax.grad(log_density)(q))
            state = one(state, h)
            return state.position, state.momentum

        return jax.vmap(of_state)(q, p)

    return symplint.check(step, [1.0, 0.5], [0.5, 0.2], step_sizes=[0.5, 0.25, 0.125])


def mici(integrator):
    import mici as package

    system = package.systems.EuclideanMetricSystem(
        neg_log_dens=lambda q: float(np.sum(1 - np.cos(q)) + 0.1 * q[0] ** 2 * q[1] ** 2),
        grad_neg_log_dens=lambda q: np.sin(q) + 0.2 * q[0] * q[1] * q[::-1],
    )

    def make(h):
        method = getattr(package.integrators, integrator)(system, step_size=h)

        def advance(q, p):
            state = method.step(package.states.ChainState(pos=q.copy(), mom=p.copy(), dir=1))
            return state.pos, state.mom

        return advance

    return symplint.check(
        make, [1.0, 0.5], [0.5, 0.2], make=True, per_sample=True, step_sizes=[0.5, 0.25, 0.125], budget=3000
    )


def numpyro(integrator):
    import jax
    import jax.numpy as jnp
    from numpyro.infer.hmc_util import velocity_verlet

    jax.config.update("jax_enable_x64", True)

    def potential(q):
        return jnp.sum(1 - jnp.cos(q)) + 0.1 * q[0] ** 2 * q[1] ** 2

    start, update = velocity_verlet(potential, lambda inverse_mass, p: 0.5 * jnp.dot(p, inverse_mass * p))

    @jax.jit
    def step(q, p, h):
        def of_state(q, p):
            state = update(h, jnp.ones(2), start(q, p))
            return state.z, state.r

        return jax.vmap(of_state)(q, p)

    return symplint.check(step, [1.0, 0.5], [0.5, 0.2], step_sizes=[0.5, 0.25, 0.125])


def xtrack(momentum):
    import xtrack_fodo

    return xtrack_fodo.report(xtrack_fodo.make if momentum == "pzeta" else xtrack_fodo.with_delta)


SPLITTING = "symplectic: splitting method"
ADAPTIVE = "not symplectic: chooses its steps"
CONVERGED = "symplectic to many digits: chooses its steps, with a small tolerance"
RUNGE_KUTTA = "not symplectic: explicit Runge–Kutta"

# The package that `pip` installs: the functions, and for each method what theory says.
PACKAGES = {
    "rebound": [
        (rebound, dict.fromkeys(("whfast", "leapfrog", "saba"), SPLITTING) | dict.fromkeys(("ias15", "bs"), CONVERGED))
    ],
    "scipy": [(scipy, dict.fromkeys(("RK45", "DOP853", "Radau", "LSODA"), ADAPTIVE))],
    "ase": [(ase, {"VelocityVerlet": SPLITTING})],
    "openmm": [(openmm, {"VerletIntegrator": SPLITTING, "VariableVerletIntegrator": ADAPTIVE})],
    "gala": [
        (gala, {
            "LeapfrogIntegrator": SPLITTING,
            "Ruth4Integrator": SPLITTING,
            "RK5Integrator": RUNGE_KUTTA,
            "DOPRI853Integrator": CONVERGED,
        })
    ],
    "galpy": [
        (galpy, dict.fromkeys(("leapfrog", "symplec4_c", "symplec6_c"), SPLITTING) | dict.fromkeys(("dop853_c", "odeint"), ADAPTIVE))
    ],
    "accelerator-toolbox": [
        (at, dict.fromkeys(("drift", "quadrupole", "sextupole", "dipole"), SPLITTING) | {"dipole-radiation": "not symplectic: loses energy"})
    ],
    "mujoco": [(mujoco, dict.fromkeys(("Euler", "implicitfast"), "symplectic: a kick, then a drift") | {"RK4": RUNGE_KUTTA})],
    "diffrax": [(diffrax, {"SemiImplicitEuler": SPLITTING, "Midpoint": RUNGE_KUTTA, "Tsit5": RUNGE_KUTTA})],
    "blackjax": [(blackjax, dict.fromkeys(("velocity_verlet", "mclachlan", "yoshida"), SPLITTING))],
    "mici": [(mici, dict.fromkeys(("LeapfrogIntegrator", "BCSSThreeStageIntegrator"), SPLITTING))],
    "numpyro": [(numpyro, {"velocity_verlet": SPLITTING})],
    "xtrack": [
        (xtrack, {"pzeta": "symplectic: exact maps of linear elements", "delta": "not symplectic: δ is not the momentum of ζ"})
    ],
}  # fmt: skip
PACKAGES |= register_solvers.ENTRIES | register_physics.ENTRIES

# The entry: the function, its argument, the package, and what theory says.
ENTRIES = {
    f"{function.__name__}-{argument}": (function, argument, package, theory)
    for package, functions in PACKAGES.items()
    for function, arguments in functions
    for argument, theory in arguments.items()
}


def verdict(report):
    """The verdict as a table shows it."""
    if report.kind == "symplectic":
        return f"symplectic to {report.digits:g} digits"
    change = re.fullmatch(
        r"The map changes loop integrals by up to (.*? (?:at h = [\de-]+(?:\.\d+)?|in one application))(, in proportion to h[⁰¹²³⁴-⁹]*)?.*",
        report.summary,
    )
    if report.kind == "not-symplectic" and change:
        return f"not symplectic; a loop integral changes by {change[1]}{change[2] or ''}"
    return report.headline


def version_of(package):
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        # Installed without pip.
        return importlib.import_module(package).__version__


def main(name, is_row):
    function, argument, package, theory = ENTRIES[name]
    report = function(argument)
    version = version_of(package)
    if is_row:
        print(f"| {package} | {version} | `{argument}` | {theory} | {verdict(report)} |")
        return
    print(f"{package} {version}, {argument}: {report.headline}\n  {report.summary}\n  Theory: {theory}")
    if report.cause:
        print(f"  {report.cause.text}")


if __name__ == "__main__":
    names = [argument for argument in sys.argv[1:] if argument != "--row"]
    for name in names:
        main(name, "--row" in sys.argv)
    if not names:
        print("\n".join(ENTRIES))
