"""Entries of register.py for solvers of ordinary differential equations, on a pendulum with H = p²/2 − cos q unless stated."""

import numpy as np
import symplint

SIZES = {"step_sizes": [0.5, 0.25, 0.125], "budget": 3000}


def _field(t, y):
    return np.array([y[1], -np.sin(y[0])])


def _pendulum(step, **settings):
    return symplint.check(step, 1.0, 0.5, per_sample=True, **(SIZES | settings))


def desolver(method):
    import desolver as package

    def step(q, p, h):
        def field(t, y):
            return np.stack([y[1], -np.sin(y[0])])

        system = package.OdeSystem(field, np.array([q[0], p[0]]), t=(0.0, h), dt=h)
        system.set_kick_vars(np.array([False, True]))
        system.method = getattr(package.integrators, method)
        system.integrate()
        return system.y[-1, :1], system.y[-1, 1:]

    return _pendulum(step)


def pathsim(method):
    import pathsim as package
    from pathsim.blocks import ODE

    solver = getattr(package.solvers, method)

    def step(q, p, h):
        block = ODE(lambda x, u, t: _field(t, x), np.array([q[0], p[0]]))
        simulation = package.Simulation([block], dt=h, Solver=solver, log=False, tolerance_fpi=1e-14)
        simulation.timestep(h)
        state = block.engine.state
        return state[:1], state[1:]

    return _pendulum(step)


def numbalsoda(method):
    import numba
    import numbalsoda as package

    @numba.cfunc(package.lsoda_sig)
    def field(t, y, dy, data):
        dy[0], dy[1] = y[1], -np.sin(y[0])

    def step(q, p, h):
        found, success = getattr(package, method)(
            field.address, np.array([q[0], p[0]]), np.array([0.0, h]), rtol=1e-6, atol=1e-9
        )
        assert success
        return found[-1, :1], found[-1, 1:]

    return _pendulum(step)


def casadi(method):
    import casadi as package

    x = package.SX.sym("x", 2)
    problem = {"x": x, "ode": package.vertcat(x[1], -package.sin(x[0]))}
    settings = {"rk": {}, "collocation": {"collocation_scheme": "legendre", "interpolation_order": 2}}[method]
    if method == "collocation":
        settings["rootfinder_options"] = {"abstol": 1e-14}

    def make(h):
        solver = package.integrator("step", method, problem, 0.0, h, settings | {"number_of_finite_elements": 1})

        def advance(q, p):
            found = np.array(solver(x0=[q[0], p[0]])["xf"]).ravel()
            return found[:1], found[1:]

        return advance

    return _pendulum(make, make=True)


def pyhamsys(method):
    import pyhamsys as package

    def kick(h, t, y):
        q, p = y[0] + h * y[1], y[1]
        return np.array([q, p - h * np.sin(q)])

    def drift(h, t, y):
        p = y[1] - h * np.sin(y[0])
        return np.array([y[0] + h * p, p])

    def step(q, p, h):
        settings = package.Parameters(step=h, solver=method)
        found = package.solve_ivp_symp(kick, drift, (0.0, h), np.array([q[0], p[0]]), params=settings)
        return found.y[:1, -1], found.y[1:, -1]

    return _pendulum(step)


def pynamicalsys(method):
    from pynamicalsys import HamiltonianSystem

    system = HamiltonianSystem("henon heiles")

    def step(q, p, h):
        system.integrator(method, time_step=h)
        return system.step(q, p)

    return symplint.check(step, [0.1, 0.2], [0.3, -0.1], per_sample=True, radius=0.1, **SIZES)


def nodepy(method):
    from nodepy import ivp, runge_kutta_method

    pair = runge_kutta_method.loadRKM(method)

    def step(q, p, h):
        problem = ivp.IVP(f=_field, u0=np.array([q[0], p[0]]), T=h)
        _, states = pair(problem, dt=h)
        return states[-1][:1], states[-1][1:]

    return _pendulum(step)


def extensisq(method):
    import extensisq as package

    return _pendulum(symplint.from_ode(_field, getattr(package, method)))


def cyrk(method):
    from CyRK import pysolve_ivp

    def field(dy, t, y):
        dy[0], dy[1] = y[1], -np.sin(y[0])

    def step(q, p, h):
        found = pysolve_ivp(
            field, (0.0, h), np.array([q[0], p[0]]), method=method, rtol=1e-3, atol=1e-6, pass_dy_as_arg=True
        )
        return found.y[:1, -1], found.y[1:, -1]

    return _pendulum(step)


def sundae(method):
    from sksundae.cvode import CVODE

    def field(t, y, dy):
        dy[:] = _field(t, y)

    def step(q, p, h):
        found = CVODE(field, method=method).solve([0.0, h], np.array([q[0], p[0]]))
        return found.y[-1, :1], found.y[-1, 1:]

    return _pendulum(step)


def heyoka(method):
    import heyoka as package

    q, p = package.make_vars("q", "p")
    solver = package.taylor_adaptive([(q, p), (p, -package.sin(q))], [0.0, 0.0])

    def step(q, p, h):
        solver.time, solver.state[:] = 0.0, [q[0], p[0]]
        solver.propagate_until(h)
        return solver.state[:1].copy(), solver.state[1:].copy()

    return _pendulum(step)


def mpmath(method):
    import mpmath as package

    def step(q, p, h):
        with package.workdps(15):
            found = package.odefun(lambda t, y: [y[1], -package.sin(y[0])], 0, [q[0], p[0]])(h)
        return [float(found[0])], [float(found[1])]

    return _pendulum(step, step_sizes=[0.5, 0.25], budget=1000)


def control(method):
    import control as package

    oscillator = package.ss([[0.0, 1.0], [-1.0, 0.0]], np.zeros((2, 1)), np.eye(2), np.zeros((2, 1)))

    def step(q, p, h):
        found = package.initial_response(oscillator, [0.0, h], [q[0], p[0]]).states
        return found[:1, -1], found[1:, -1]

    return _pendulum(step)


def brainpy(method):
    import brainpy as package
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    solver = package.odeint(lambda q, p, t: (p, -jnp.sin(q)), method=method)

    @jax.jit
    def step(q, p, h):
        return solver(q, p, 0.0, dt=h)

    return symplint.check(step, 1.0, 0.5, step_sizes=SIZES["step_sizes"])


def sdeint(method):
    import sdeint as package

    def step(q, p, h):
        solver, start = getattr(package, method), np.array([q[0], p[0]])
        found = solver(lambda y, t: _field(t, y), lambda y, t: np.zeros((2, 1)), start, [0.0, h])
        return found[-1, :1], found[-1, 1:]

    return _pendulum(step)


def openseespy(method):
    import openseespy.opensees as package

    arguments = {"Newmark": (0.5, 0.25), "HHT": (0.7,)}[method]

    def step(q, p, h):
        # A unit mass on a unit spring.
        package.wipe()
        package.model("basic", "-ndm", 1, "-ndf", 1)
        package.node(1, 0.0)
        package.node(2, 0.0)
        package.fix(1, 1)
        package.mass(2, 1.0)
        package.uniaxialMaterial("Elastic", 1, 1.0)
        package.element("zeroLength", 1, 1, 2, "-mat", 1, "-dir", 1)
        package.setNodeDisp(2, 1, q[0], "-commit")
        package.setNodeVel(2, 1, p[0], "-commit")
        package.setNodeAccel(2, 1, -q[0], "-commit")
        package.constraints("Plain")
        package.numberer("Plain")
        package.system("BandGeneral")
        package.test("NormDispIncr", 1e-14, 10)
        package.algorithm("Linear")
        package.integrator(method, *arguments)
        package.analysis("Transient")
        package.analyze(1, h)
        return [package.nodeDisp(2, 1)], [package.nodeVel(2, 1)]

    return _pendulum(step)


def pde(method):
    import pde as package

    # A wave on a ring: the momentum of each cell is its velocity, times one width for all.
    grid = package.CartesianGrid([[0, 8]], 8, periodic=True)
    wave = package.WavePDE()

    def make(h):
        solver = {
            "euler": lambda: package.EulerSolver(wave, backend="numpy"),
            "runge-kutta": lambda: package.RungeKuttaSolver(wave, backend="numpy"),
            "crank-nicolson": lambda: package.CrankNicolsonSolver(wave, maxerror=1e-15, maxiter=1000, backend="numpy"),
        }[method]()
        state = package.FieldCollection([package.ScalarField(grid), package.ScalarField(grid)])
        stepper = solver.make_stepper(state, dt=h)

        def advance(q, p):
            state = package.FieldCollection([package.ScalarField(grid, q), package.ScalarField(grid, p)])
            found = stepper(state, 0.0, h)
            found = state if not hasattr(found, "data") else found
            return found.data[0], found.data[1]

        return advance

    q0 = np.sin(2 * np.pi * np.arange(8) / 8)
    return symplint.check(make, q0, np.zeros(8), make=True, per_sample=True, **SIZES)


SPLITTING = "symplectic: splitting method"
RUNGE_KUTTA = "not symplectic: explicit Runge–Kutta"
ADAPTIVE = "not symplectic: chooses its steps"
CONVERGED = "symplectic to rounding: a Taylor series to full precision"

# The package that `pip` installs: the function, and for each method what theory says.
ENTRIES = {
    "desolver": [(desolver, {"ABAs5o6HSolver": SPLITTING, "RK4Solver": RUNGE_KUTTA})],
    "pathsim": [(pathsim, {"DIRK2": "symplectic: two implicit midpoint steps", "RK4": RUNGE_KUTTA})],
    "numbalsoda": [(numbalsoda, {"dop853": ADAPTIVE})],
    "casadi": [(casadi, {"collocation": "symplectic: Gauss–Legendre collocation", "rk": RUNGE_KUTTA})],
    "pyhamsys": [(pyhamsys, {"Verlet": SPLITTING, "BM4": SPLITTING})],
    "pynamicalsys": [(pynamicalsys, {"svy4": SPLITTING, "vv2": SPLITTING})],
    "nodepy": [(nodepy, {"RK44": RUNGE_KUTTA})],
    "extensisq": [(extensisq, {"Ts5": ADAPTIVE})],
    "CyRK": [(cyrk, {"RK45": ADAPTIVE})],
    "scikit-sundae": [(sundae, {"BDF": ADAPTIVE, "Adams": ADAPTIVE})],
    "heyoka": [(heyoka, {"taylor_adaptive": CONVERGED})],
    "mpmath": [(mpmath, {"odefun": CONVERGED})],
    "control": [(control, {"initial_response": "symplectic: the exponential of a linear Hamiltonian field"})],
    "brainpy": [(brainpy, {"rk4": RUNGE_KUTTA, "euler": RUNGE_KUTTA})],
    "sdeint": [(sdeint, {"itoEuler": RUNGE_KUTTA})],
    "openseespy": [
        (openseespy, {
            "Newmark": "symplectic for linear forces: β = 1/4, γ = 1/2",
            "HHT": "not symplectic: numerical damping with α = 0.7",
        })
    ],
    "py-pde": [
        (pde, {
            "euler": RUNGE_KUTTA,
            "runge-kutta": RUNGE_KUTTA,
            "crank-nicolson": "symplectic for linear forces: the implicit midpoint rule",
        })
    ],
}  # fmt: skip
