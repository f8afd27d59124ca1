"""Progress on standard error."""

from __future__ import annotations

import contextlib
import sys
import threading
from collections.abc import Callable, Iterator
from typing import Any

from ._errors import InputError

Watch = Callable[[int, int, "float | None"], object]

INTERVAL = 0.25
"""Seconds between two drawings."""


@contextlib.contextmanager
def bar(progress: Any) -> Iterator[Watch | None]:
    """A function that receives the progress, if there is one."""
    if callable(progress):
        yield progress
    elif progress in (None, False, True):
        if not progress or not _is_terminal():
            yield None
            return
        drawn = _Bar()
        try:
            yield drawn
        finally:
            drawn.end()
    else:
        raise InputError(f"progress is {progress!r}; give True, or a function of (measured, planned, h)")


def _is_terminal() -> bool:
    """Whether standard error is one; programs without a console have none, and others close theirs."""
    return sys.stderr is not None and not sys.stderr.closed and sys.stderr.isatty()


class _Bar:
    """A line that a thread draws, so that the time also runs during long steps."""

    def __init__(self) -> None:
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None

    def __call__(self, measured: int, planned: int, h: float | None) -> None:
        """Nothing: the line shows evaluations, not points."""

    def started(self, line: Any) -> None:
        """Begins to draw."""
        self._thread = threading.Thread(target=self._draw, args=(line,), daemon=True)
        self._thread.start()

    def _draw(self, line: Any) -> None:
        while not self._ended.wait(INTERVAL):
            sys.stderr.write(f"\r\x1b[K{line.text()}")
            sys.stderr.flush()

    def end(self) -> None:
        """Removes the line."""
        self._ended.set()
        if self._thread is not None:
            self._thread.join()
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()
