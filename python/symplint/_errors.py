"""Exceptions of symplint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._report import Report

__all__ = ["InputError", "NotSymplecticError", "StepError", "StructureError", "SymplintError", "UndecidedError"]


class SymplintError(Exception):
    """Base class of all exceptions of symplint."""


class InputError(SymplintError, ValueError):
    """An argument is not valid. The text names it and a valid value."""


class StepError(SymplintError, RuntimeError):
    """The map failed, or returned a state that is not finite.

    The exception that the map raised, if it did, is the ``__cause__``.

    Attributes
    ----------
    h : float or None
        The step size.
    s : float or None
        The loop parameter of the state that could not be advanced, from 0 to 1.
    sample : int or None
        Number of the sample, counted from 0; None if the state lies between samples.
    report : Report or None
        The report on the other step sizes, if the map could take them.
    """

    h: float | None
    s: float | None
    sample: int | None
    report: Report | None

    def __init__(
        self, message: str, h: float | None = None, s: float | None = None, sample: int | None = None
    ) -> None:
        super().__init__(message)
        self.h = h
        self.s = s
        self.sample = sample
        self.report = None


class _ReportError(SymplintError, AssertionError):
    """A map that does not have the structure that it should have."""

    report: Report

    def __init__(self, message: str, report: Report) -> None:
        super().__init__(message)
        self.report = report

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.report)


class NotSymplecticError(_ReportError):
    """A map that should be symplectic is not, or conserves fewer digits than asked for.

    Attributes
    ----------
    report : Report
        The report of the check.
    """


class UndecidedError(_ReportError):
    """The evidence is not enough to show that a map is symplectic, or that it is not.

    Attributes
    ----------
    report : Report
        The report of the check. Its `advice` says what to change.
    """


class StructureError(_ReportError):
    """A map does not have a property that it should have, or the property could not be tested.

    Attributes
    ----------
    report : Report
        The report of the check.
    """
