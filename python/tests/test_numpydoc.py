"""Docstrings, by the validator of numpydoc."""

import inspect

import pytest
import symplint

validate = pytest.importorskip("numpydoc.validate").validate

MODULES = (symplint, symplint.adapters, symplint.integrators, symplint.systems)
#: Extended summaries, examples and further reading are for what needs them.
NOT_REQUIRED = {"ES01", "EX01", "SA01"}
#: Classes that a user does not construct: their docstrings describe the attributes.
RESULTS = (
    symplint.Cause, symplint.Composition, symplint.FieldReport, symplint.LoopIntegral, symplint.Loop, symplint.Property, symplint.Report,
    symplint.integrators.Integrator, symplint.systems.System,
)  # fmt: skip


def public_names():
    """Every public name with its value: functions, classes and their methods."""
    for module in MODULES:
        for name in module.__all__:
            value = getattr(module, name)
            if name.startswith("__") or inspect.ismodule(value):
                continue
            yield f"{module.__name__}.{name}", value
            if inspect.isclass(value):
                for member, of_class in vars(value).items():
                    if not member.startswith("_") and (inspect.isfunction(of_class) or isinstance(of_class, property)):
                        yield f"{module.__name__}.{name}.{member}", of_class


@pytest.mark.parametrize(("name", "value"), [pytest.param(*found, id=found[0]) for found in public_names()])
def test_numpydoc_has_no_complaint(name, value):
    is_result = value in RESULTS or (inspect.isclass(value) and issubclass(value, symplint.SymplintError))
    allowed = NOT_REQUIRED | ({"PR01"} if is_result else set())
    errors = [f"{code}: {text}" for code, text in validate(name)["errors"] if code not in allowed]
    assert not errors
