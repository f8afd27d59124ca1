"""Doctests of the package are collected here, from wherever it is installed."""

import doctest
import importlib
import pkgutil

import pytest
import symplint


#: The package that the doctests of a module need.
NEEDED = {"symplint._ode": "scipy"}


def modules():
    """Every module of the package with its name."""
    for info in pkgutil.iter_modules(symplint.__path__, "symplint."):
        if not info.name.endswith("._native"):
            yield info.name


@pytest.fixture(params=list(modules()))
def doctested(request):
    """What the doctests of a module gave."""
    if request.param in NEEDED:
        pytest.importorskip(NEEDED[request.param])
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    return doctest.testmod(importlib.import_module(request.param), optionflags=flags)
