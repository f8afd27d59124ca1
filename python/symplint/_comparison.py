"""Whether workers make the same of the same states, and by how much they differ."""

from __future__ import annotations

from typing import Any

import numpy as np

from ._arrays import Array
from ._errors import SymplintError

States = tuple[Array, Array]


class Comparison:
    """What the processes of a check make of the same states."""

    def __init__(self) -> None:
        #: The step size and the states, once they are known.
        self.states: tuple[float, Array, Array] | None = None
        #: Processes that took steps.
        self.processes: set[str] = set()
        #: The largest difference: of q or p, the degree of freedom, the size.
        self.difference: tuple[str, int, float] | None = None
        #: What stops the check where a worker makes no numbers of states of which others make some.
        self.unlike: SymplintError | None = None
        #: States that were taken from the journal.
        self.recalled = 0
        self._reference: States | None = None
        self._journal: Any = None
        #: What the journal knows the reference and the next difference by.
        self._calls: list[Any] = []

    def end(self) -> None:
        """Lets go of the journal."""
        self._journal = None

    def begin(self, journal: Any, h: float, q: Array, p: Array) -> None:
        """Compares these states. A journal has what workers of a run that was stopped made of them."""
        self.states = h, q, p
        self._journal = journal
        if journal is None:
            return
        # No step has such a size.
        of_reference, self._reference = journal.find(np.inf, q, p)
        self.recalled += 0 if self._reference is None else len(q)
        of_difference, found = journal.find(np.nan, q[:1], p[:1])
        while found is not None:
            self.recalled += 1
            self.difference = _largest(*found)
            of_difference, found = journal.find(np.nan, q[:1], p[:1])
        self._calls = [of_reference, of_difference]

    def take(self, process: str, compared: States | None) -> None:
        """Compares what a worker makes of the same states with what the first one did."""
        self.processes.add(process)
        if compared is None:
            return
        if self._reference is None:
            self._reference = compared
            self._note(0, compared)
        q, p = (_apart(of_first, found) for of_first, found in zip(self._reference, compared, strict=True))
        if not (np.isfinite(q).all() and np.isfinite(p).all()):
            remedy = "see that all have the same processor and libraries"
            message = f"worker {process} makes numbers that are not finite of states of which others make finite ones"
            self.unlike = SymplintError(f"{message}, or the other way round; {remedy}")
            return
        name, dof, size = _largest(q, p)
        if size > (0.0 if self.difference is None else self.difference[2]):
            self.difference = (name, dof, size)
            self._note(1, (q, p))

    def _note(self, which: int, rows: States) -> None:
        """Notes the reference, 0, or a difference, 1."""
        if self._journal is None or self.states is None:
            return
        self._journal.note(self._calls[which], *rows)
        if which == 1:
            # A larger one is another record.
            _, q, p = self.states
            self._calls[1], _ = self._journal.find(np.nan, q[:1], p[:1])


def _apart(first: Array, found: Array) -> Array:
    """The largest distance between two results in each degree of freedom, as one row: infinite where only one is finite."""
    with np.errstate(invalid="ignore"):
        apart = np.abs(found - first)
    # What neither worker makes a number of is the same.
    same = (first == found) | (np.isnan(first) & np.isnan(found))
    apart[same] = 0.0
    apart[~np.isfinite(apart)] = np.inf
    largest: Array = apart.max(axis=0, keepdims=True)
    return largest


def _largest(q: Array, p: Array) -> tuple[str, int, float]:
    """The largest number of two rows, and where it is."""
    name, row = max((("q", q), ("p", p)), key=lambda of: float(of[1].max()))
    return name, int(row.argmax()), float(row.max())
