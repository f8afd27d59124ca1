"""Doctests of the package are collected here, from wherever it is installed."""

import doctest
import importlib
import pkgutil
import sys

import pytest
import symplint


#: The package that the doctests of a module need.
NEEDED = {
    "symplint._ode": "scipy",
    "symplint.adapters._pyat": "at",
    **{
        f"symplint.adapters._{name}": name
        for name in ("ase", "blackjax", "diffrax", "mici", "mujoco", "openmm", "rebound", "xtrack")
    },
}


def modules():
    """Every module of the package with its name."""
    for info in pkgutil.walk_packages(symplint.__path__, "symplint."):
        if not info.name.endswith("._native"):
            yield info.name


@pytest.fixture(params=list(modules()))
def doctested(request):
    """What the doctests of a module gave."""
    if request.param in NEEDED:
        pytest.importorskip(NEEDED[request.param])
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    precision = in_double_precision()
    found = doctest.testmod(importlib.import_module(request.param), optionflags=flags)
    if in_double_precision() != precision:
        sys.modules["jax"].config.update("jax_enable_x64", precision)
    return found


def in_double_precision():
    """Whether JAX computes in double precision; it is False if it is not imported."""
    return "jax" in sys.modules and sys.modules["jax"].config.jax_enable_x64
