"""A fixture that tests of simulation codes use: ``symplectic``.

.. code-block:: python

    def test_my_step(symplectic):
        symplectic(step, q0, p0, digits=10)

The options ``--symplectic-budget`` and ``--symplectic-digits`` set how many evaluations each check may take and how many
digits it asks for. ``symplectic_budget`` and ``symplectic_digits`` in the configuration of pytest do so for all runs, and the marker
``@pytest.mark.symplectic(budget=…, digits=…)`` for one test. Arguments of the call come first, then the marker, the options and the
configuration.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

#: Arguments that options and markers set.
SETTINGS: dict[str, type] = {"budget": int, "digits": float}


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options for budget and digits, of the command line and of the configuration."""
    group = parser.getgroup("symplint")
    texts = {"budget": "evaluations of a map in each check, at most", "digits": "digits that each check asks for, at least"}
    for name, text in texts.items():
        group.addoption(f"--symplectic-{name}", type=SETTINGS[name], default=None, help=text)
        parser.addini(f"symplectic_{name}", text, default=None)


def pytest_configure(config: pytest.Config) -> None:
    """The marker."""
    config.addinivalue_line(
        "markers", "symplectic(budget=None, digits=None): evaluations and digits of the checks of this test"
    )


@pytest.fixture
def symplectic(request: pytest.FixtureRequest) -> Callable[..., Any]:
    """`symplint.assert_symplectic`, with budget and digits of options and markers."""
    import symplint

    settings: dict[str, Any] = {}
    for name in SETTINGS:
        value = request.config.getoption(f"symplectic_{name}")
        if value is None and (text := request.config.getini(f"symplectic_{name}")):
            try:
                value = SETTINGS[name](text)
            except ValueError:
                raise pytest.UsageError(f"symplectic_{name} is {text!r} in the configuration; give a number") from None
        if value is not None:
            settings[name] = value
    for marker in reversed(list(request.node.iter_markers("symplectic"))):
        unknown = set(marker.kwargs) - set(SETTINGS)
        if unknown or marker.args:
            raise pytest.UsageError(f"the marker symplectic takes {' and '.join(SETTINGS)} by name, and nothing else")
        settings |= marker.kwargs

    def check(*arguments: Any, **keywords: Any) -> Any:
        # The traceback ends where the test calls it.
        __tracebackhide__ = True
        return symplint.assert_symplectic(*arguments, **(settings | keywords))

    return check
