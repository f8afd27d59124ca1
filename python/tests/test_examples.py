"""The examples, with their verdicts. Their other packages besides NumPy may be missing."""

import importlib.util
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples" / "python"


def example(name):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_langevin():
    module = example("langevin")
    assert module.report(module.verlet).kind == "symplectic"
    report = module.report(module.langevin)
    assert report.kind == "not-symplectic" and report.order == 1


def test_scipy():
    pytest.importorskip("scipy")
    assert example("scipy_solve_ivp").report().kind in ("not-symplectic", "broken-loops")


@pytest.mark.parametrize(
    ("needed", "name", "symplectic", "other"),
    [
        ("ase", "ase_copper", "verlet", "langevin"),
        ("openmm", "openmm_water", "verlet", "langevin"),
        ("torch", "torch_networks", "sympnet", "residual_network"),
        ("xsuite", "xtrack_fodo", "make", "with_delta"),
    ],
)
def test_a_map_that_is_and_one_that_is_not(needed, name, symplectic, other):
    pytest.importorskip(needed)
    module = example(name)
    report = module.report(getattr(module, symplectic))
    assert report.kind == "symplectic" and report.digits > 12, str(report)
    assert module.report(getattr(module, other)).kind == "not-symplectic"


def test_rebound():
    pytest.importorskip("rebound")
    module = example("rebound_planets")
    for name in ("whfast", "leapfrog"):
        report = module.report(name)
        assert report.kind == "symplectic", str(report)
        assert report.digits > 9
    # It is as exact as double precision: its defect is too small for a verdict of another kind.
    assert module.report("ias15").kind in ("symplectic", "undecided")
