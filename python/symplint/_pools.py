"""Executors of what has no method `submit`."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from ._errors import SymplintError


class OfPool:
    """An executor of what has a method apply_async that calls back, as pools of `multiprocessing` have."""

    def __init__(self, pool: Any) -> None:
        self._pool = pool
        self._max_workers = getattr(pool, "_processes", None)
        #: Those that it had since: a dead one is replaced, and what it had to do is lost.
        self._processes = {process for process in _processes(pool) if process.exitcode is None}
        self._ends_processes = getattr(pool, "_maxtasksperchild", None) is not None

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        future: Future[Any] = Future()

        def take(result: Any) -> None:
            if future.set_running_or_notify_cancel():
                future.set_result(result)

        def fail(error: BaseException) -> None:
            if future.set_running_or_notify_cancel():
                future.set_exception(error)

        try:
            self._pool.apply_async(function, arguments, callback=take, error_callback=fail)
        except ValueError as error:
            raise RuntimeError(str(error)) from error
        return future

    def check(self) -> None:
        """Raises where a process died: a pool says nothing of it, and waits for its result for ever."""
        self._processes |= _processes(self._pool)
        for process in self._processes:
            code = process.exitcode
            if code is not None and not (self._ends_processes and code == 0):
                remedy = "give a concurrent.futures.ProcessPoolExecutor, which replaces it; with out= no step is taken again"
                raise SymplintError(f"a process of the pool ended with exit code {code}, and its task is lost; {remedy}")


class OfMap:
    """An executor of what has a method map alone."""

    def __init__(self, pool: Any) -> None:
        # Results are noted one by one where they come so.
        self._map = getattr(pool, "imap", pool.map)
        self._waiting: list[tuple[Future[Any], Any]] = []

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        future: Future[Any] = Future()
        self._waiting.append((future, (function, arguments)))
        return future

    def make(self) -> None:
        """Makes all tasks that wait."""
        waiting, self._waiting = self._waiting, []
        if waiting:
            results = self._map(_apply, [work for _, work in waiting])
            for (future, _), result in zip(waiting, results, strict=True):
                future.set_result(result)


def _processes(pool: Any) -> set[Any]:
    """Processes of a pool, which has no public name for them."""
    return {process for process in getattr(pool, "_pool", None) or () if hasattr(process, "exitcode")}


def has_callbacks(pool: Any) -> bool:
    try:
        parameters = inspect.signature(pool.apply_async).parameters
    except (AttributeError, TypeError, ValueError):
        return False
    return {"callback", "error_callback"} <= parameters.keys()


def _apply(work: tuple[Callable[..., Any], tuple[Any, ...]]) -> Any:
    function, arguments = work
    return function(*arguments)
