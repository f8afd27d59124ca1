"""Documentation: doctests, and docstrings of all that is public."""

import inspect

import symplint


def test_doctests_pass(doctested):
    assert doctested.failed == 0


def test_there_are_doctests():
    for function in (symplint.check, symplint.assert_symplectic, symplint.measure, symplint.loop_integral, symplint.circle, symplint.check_force, symplint.check_field):
        assert ">>>" in function.__doc__


def test_everything_public_has_a_docstring():
    for module in (symplint, symplint.systems, symplint.integrators, symplint.adapters):
        for name in module.__all__:
            found = getattr(module, name)
            if name.startswith("__") or inspect.ismodule(found):
                continue
            assert inspect.getdoc(found), name
            if inspect.isclass(found):
                for member, value in vars(found).items():
                    if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                        assert inspect.getdoc(value), f"{name}.{member}"


def test_arguments_of_check_are_documented():
    text = symplint.check.__doc__
    for name in inspect.signature(symplint.check).parameters:
        assert any(f"{before}{name}" in text for before in ("\n    ", ", ", "\n    **")), name
