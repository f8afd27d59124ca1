"""Doctests of the package are collected here, from wherever it is installed."""

import doctest
import importlib
import pkgutil

import pytest
import symplint


def modules():
    """Every module of the package with its name."""
    for info in pkgutil.iter_modules(symplint.__path__, "symplint."):
        if not info.name.endswith("._native"):
            yield info.name


@pytest.fixture(params=list(modules()))
def doctested(request):
    """What the doctests of a module gave."""
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    return doctest.testmod(importlib.import_module(request.param), optionflags=flags)
