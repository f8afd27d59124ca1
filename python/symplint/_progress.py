"""Progress on standard error."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator
from typing import Any

from ._errors import InputError

Watch = Callable[[int, int, "float | None"], object]

WIDTH = 40


@contextlib.contextmanager
def bar(progress: Any) -> Iterator[Watch | None]:
    """A function that receives the progress, if there is one."""
    if callable(progress):
        yield progress
    elif progress in (None, False, True):
        if not progress or not _is_terminal():
            yield None
            return
        try:
            yield _draw
        finally:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()
    else:
        raise InputError(f"progress is {progress!r}; give True, or a function of (measured, planned, h)")


def _is_terminal() -> bool:
    """Whether standard error is one; programs without a console have none, and others close theirs."""
    return sys.stderr is not None and not sys.stderr.closed and sys.stderr.isatty()


def _draw(measured: int, planned: int, h: float | None) -> None:
    filled = WIDTH * measured // max(planned, 1)
    text = "" if h is None else f"  h = {h:g}"
    sys.stderr.write(f"\r\x1b[K{'█' * filled}{'░' * (WIDTH - filled)} {measured}/{planned} points{text}")
    sys.stderr.flush()
