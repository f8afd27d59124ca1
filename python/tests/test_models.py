"""Systems and integrators of the library."""

import inspect
import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import symplint

PROGRAM = os.environ.get("SYMPLINT") or shutil.which("symplint")

needs_program = pytest.mark.skipif(PROGRAM is None, reason="needs the program: set SYMPLINT to its path")

SIZES = {"step_sizes": [0.5, 0.25, 0.125]}


def test_commands_are_for_the_program():
    assert not hasattr(symplint.systems, "command")
    with pytest.raises(symplint.InputError, match="pass a function that calls the program"):
        symplint._native.System("command", {"command": ["true", "{before}", "{after}"], "q0": [1.0], "p0": [1.0]})


def test_every_name_of_the_program_is_there():
    catalogue = symplint._native.catalogue()
    for kind, module in (("systems", symplint.systems), ("integrators", symplint.integrators)):
        for name, *_ in catalogue[kind]:
            assert callable(getattr(module, name.replace("-", "_"))), name
            assert name.replace("-", "_") in module.__all__
    assert len(catalogue["systems"]) >= 15 and len(catalogue["integrators"]) >= 15
    assert "omega" in symplint.systems.harmonic_oscillator.__doc__
    assert "position-first" in symplint.integrators.strang.__doc__
    assert symplint.integrators.velocity_verlet(symplint.systems.pendulum()).name.startswith("strang")


def choices(argument):
    """The texts that a signature allows."""
    return re.findall(r'"([^"]+)"', argument.annotation)


def test_dir_shows_systems_and_integrators_only():
    catalogue = symplint._native.catalogue()
    assert set(dir(symplint.systems)) == {name.replace("-", "_") for name, *_ in catalogue["systems"]}
    names = {name.replace("-", "_") for kind in ("integrators", "aliases") for name, *_ in catalogue[kind]}
    assert set(dir(symplint.integrators)) == names


@pytest.mark.parametrize("name", dir(symplint.systems))
def test_the_library_takes_what_the_signature_of_a_system_states(name):
    make = getattr(symplint.systems, name)
    of_defaults = make()
    arguments = inspect.signature(make).parameters
    for argument in arguments.values():
        if argument.default is not None:
            stated = make(**{argument.name: argument.default})
            assert np.array_equal(stated.q0, of_defaults.q0) and np.array_equal(stated.p0, of_defaults.p0), argument
        for choice in choices(argument):
            make(**{argument.name: choice})
        if choices(argument):
            with pytest.raises(symplint.InputError):
                make(**{argument.name: "no-such-choice"})
    assert any(choices(argument) for argument in arguments.values()) == ("Literal" in str(inspect.signature(make)))


@pytest.mark.parametrize("name", dir(symplint.integrators))
def test_the_library_takes_what_the_signature_of_an_integrator_states(name):
    make = getattr(symplint.integrators, name)
    of = {"boris": "charged_particle"} | dict.fromkeys(("boris_pic", "crank_nicolson", "ecsim"), "pic_1d2v")
    system = getattr(symplint.systems, of.get(name, "pendulum"))()
    numbers = {"tolerance": 1e-9, "max_iterations": 100, "iterations": 3, "damping": 0.01}
    arguments = dict(inspect.signature(make).parameters)
    assert arguments.pop("system").default is inspect.Parameter.empty
    for argument in arguments.values():
        for value in choices(argument) or [numbers[argument.name]]:
            if value == "newton" and name in ("crank_nicolson", "discrete_gradient", "ecsim"):
                with pytest.raises(symplint.InputError, match="fixed-point iteration alone"):
                    make(system, solver=value)
                continue
            made = make(system, **{argument.name: value})
            if argument.name == "variant" and value == argument.default:
                assert made.name.startswith(make(system).name)
    if "tolerance" not in arguments:
        with pytest.raises(symplint.InputError, match="tolerance"):
            make(system, tolerance=1e-9)


def test_a_step_is_that_of_the_formula():
    pendulum = symplint.systems.pendulum(potential="cos")
    strang = symplint.integrators.strang(pendulum)
    q, p = np.array([[3.0], [0.2]]), np.array([[0.1], [-0.4]])
    copies = q.copy(), p.copy()
    new_q, new_p = strang(q, p, 0.1)
    half = q + 0.05 * p
    # V = cos q: the force is sin q.
    kicked = p + 0.1 * np.sin(half)
    assert np.allclose(new_p, kicked, atol=1e-15) and np.allclose(new_q, half + 0.05 * kicked, atol=1e-15)
    assert np.array_equal(q, copies[0]) and np.array_equal(p, copies[1])
    one_q, one_p = strang(q[1], p[1], 0.1)
    assert one_q.shape == (1,) and one_q[0] == new_q[1, 0] and one_p[0] == new_p[1, 0]


def test_keys_and_errors_are_those_of_configurations():
    toda = symplint.systems.toda(particles=3) if "particles" in symplint.systems.toda.__doc__ else None
    assert toda is None or toda.dof == 3
    oscillator = symplint.systems.harmonic_oscillator(dof=3, omega=[1.0, 2.0, 3.0], q0=np.array([0.1, 0.2, 0.3]))
    assert oscillator.dof == 3 and oscillator.q0.tolist() == [0.1, 0.2, 0.3]
    assert symplint.systems.harmonic_oscillator(dof=np.int64(2)).dof == 2
    for make, words in [
        (lambda: symplint.systems.pendulum(omega=1.0), "omega"),
        (lambda: symplint.systems.pendulum(potential="tan"), "potential"),
        (lambda: symplint.systems.pendulum(q0="x"), "q0"),
        (lambda: symplint.systems.pendulum(q0=object()), "q0 is an object of type object"),
        (lambda: symplint.systems.harmonic_oscillator(dof=2, omega=[1.0]), "omega"),
        (lambda: symplint.integrators.strang(symplint.systems.pendulum(), variant="sideways"), "sideways"),
        (lambda: symplint.integrators.boris(symplint.systems.pendulum()), "boris"),
        (lambda: symplint.integrators.strang(symplint.systems.henon_map()), "integrator"),
        (lambda: symplint.integrators.strang(3), "symplint.systems"),
        (lambda: symplint.integrators.strang(symplint.systems.pendulum())([1.0], [1.0, 2.0], 0.1), "shape"),
        (lambda: symplint.check(symplint.integrators.strang(symplint.systems.pendulum()), weight=2.0), "weight"),
        (lambda: symplint.check(symplint.integrators.strang(symplint.systems.pendulum()), [1.0, 2.0], [0, 0]), "agree"),
    ]:
        with pytest.raises(symplint.InputError, match=words):
            make()


def test_compiled_and_called_through_python_agree():
    strang = symplint.integrators.strang(symplint.systems.henon_heiles())
    compiled = symplint.check(strang, **SIZES, budget=20_000, jacobian=False)

    def step(q, p, h):
        return strang(q, p, h)

    called = symplint.check(step, strang.system.q0, strang.system.p0, **SIZES, jacobian=False)
    assert compiled.kind == called.kind == "symplectic"
    given = compiled.points["loop"] == 0
    assert np.array_equal(compiled.points["final"][given], called.points["final"][called.points["loop"] == 0])


def test_no_python_runs_in_a_step_of_the_library():
    import sys

    seen = []
    integrator = symplint.integrators.rk4(symplint.systems.pendulum())
    sys.setprofile(lambda frame, event, _: seen.append(frame.f_code.co_name))
    try:
        report = symplint.check(integrator, **SIZES)
    finally:
        sys.setprofile(None)
    assert report.evaluations > 5000
    assert len(seen) < 1000


def of_program(tmp_path, text, *settings):
    """The report of the program on a configuration."""
    config = tmp_path / "c.toml"
    config.write_text(text)
    done = subprocess.run(
        [PROGRAM, "check", str(config), "--json", *(f"--set={setting}" for setting in settings)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode in (0, 1, 3), done.stderr
    return json.loads(done.stdout)


def results(report):
    return {key: value for key, value in report.items() if key not in ("config", "provenance")}


CASES = [
    ("pendulum", "strang", {}, {}, {}),
    ("pendulum", "rk2", {"variant": "heun"}, {}, {}),
    ("henon-heiles", "yoshida4", {}, {"radius": 0.1}, {"radius": "0.1"}),
    ("absolute-value", "lie-trotter", {}, {"step_sizes": [0.5, 0.25]}, {}),
    ("double-pendulum", "implicit-midpoint", {"solver": "newton"}, {"radius": 0.2}, {"radius": "0.2"}),
    ("pendulum-rattle", None, {}, {"radius": 0.3}, {"radius": "0.3"}),
    ("kepler", "strang", {}, {"radius": "auto"}, {"radius": '"auto"'}),
]


@needs_program
@pytest.mark.parametrize(("system", "integrator", "keys", "arguments", "loop"), CASES)
def test_the_report_is_that_of_the_program_to_the_last_bit(system, integrator, keys, arguments, loop, tmp_path):
    made = getattr(symplint.systems, system.replace("-", "_"))()
    if integrator is None:
        step = symplint.integrators.of_system(made)
    else:
        step = getattr(symplint.integrators, integrator.replace("-", "_"))(made, **keys)
    report = symplint.check(step, budget="auto", **arguments)
    lines = [f'[system]\nname = "{system}"']
    if integrator is not None:
        lines += [f'[integrator]\nname = "{integrator}"', *(f'{key} = "{value}"' for key, value in keys.items())]
    lines += ["[loop]", *(f"{key} = {value}" for key, value in loop.items())]
    if "step_sizes" in arguments:
        lines += [f"[diagnostic]\nstep_sizes = {arguments['step_sizes']}"]
    assert results(report.to_dict()) == results(of_program(tmp_path, "\n".join(lines)))
    assert report.to_dict()["config"]["system"]["name"] == system


@needs_program
def test_measure_of_loops_written_and_advanced_elsewhere(tmp_path):
    system = symplint.systems.henon_heiles()
    strang = symplint.integrators.strang(system)
    config = tmp_path / "c.toml"
    config.write_text('[system]\nname = "henon-heiles"\n[loop]\nradius = 0.1\n')
    subprocess.run([PROGRAM, "loop", str(config), "--out", str(tmp_path)], check=True, capture_output=True)
    files = list(Path(tmp_path).glob("*.npz"))
    assert len(files) == 1
    loop = np.load(files[0])
    q, p = loop["q"], loop["p"]
    report = symplint.measure((q, p), strang(q, p, 0.25), strang(q, p, 0.125), h=[0.25, 0.125])
    assert report.kind == "symplectic"
    checked = symplint.check(strang, radius=0.1, step_sizes=[0.25, 0.125], samples=len(q), loops=1)
    assert np.array_equal(report.points["final"], checked.points["final"])
    assert np.array_equal(report.points["initial"], checked.points["initial"])
    # And the program says the same of the same loops.
    for h in (0.25, 0.125):
        new_q, new_p = strang(q, p, h)
        np.savez(tmp_path / f"after-{h}.npz", q=new_q, p=new_p, h=h)
    done = subprocess.run(
        [PROGRAM, "measure", str(files[0]), *(str(tmp_path / f"after-{h}.npz") for h in (0.25, 0.125)), "--json"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert results(json.loads(done.stdout)) == results(report.to_dict())


def test_a_system_runs_with_its_default_integrator():
    report = symplint.check(symplint.systems.pendulum())
    assert report.kind == "symplectic"
    assert str(report) == str(symplint.check(symplint.integrators.of_system(symplint.systems.pendulum())))
    assert symplint.check(symplint.systems.standard_map()).kind == "symplectic"
    assert symplint.assert_symplectic(symplint.systems.henon_map()).is_symplectic
