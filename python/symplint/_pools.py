"""Executors of what has no method `submit`."""

from __future__ import annotations

import inspect
import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import Any

from ._errors import InputError, SymplintError

#: Tasks that a pool may have at once where it is not known how many processes it has.
AT_ONCE = 64
#: What is wrong with a method `map` that loses or reorders results.
OTHER_ORDER = (
    "the executor does not return one result for each task in the order of the tasks; give one whose map does, as those of "
    "concurrent.futures"
)
#: A future, the function, and its arguments.
Task = tuple[Future[Any], Callable[..., Any], tuple[Any, ...]]


class OfPool:
    """An executor of what has a method apply_async that calls back, as pools of `multiprocessing` have."""

    def __init__(self, pool: Any) -> None:
        self._pool = pool
        workers = getattr(pool, "_processes", None)
        self._max_workers = workers if isinstance(workers, int) else None
        #: Those that it had since: a dead one is replaced, and what it had to do is lost.
        self._processes = {process for process in _processes(pool) if process.exitcode is None}
        self._ends_processes = getattr(pool, "_maxtasksperchild", None) is not None
        #: Tasks that the pool may have at once: one for each process. It gives none back.
        self._most = self._max_workers or AT_ONCE
        #: Held while what follows changes: the pool calls back on a thread of its own.
        self._lock = threading.Lock()
        #: Tasks that the pool does not have yet.
        self._waiting: deque[Task] = deque()
        self._under_way = 0

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        future: Future[Any] = Future()
        with self._lock:
            self._waiting.append((future, function, arguments))
        self._fill()
        return future

    def _fill(self) -> None:
        """Gives the pool as many tasks as it may have."""
        while (task := self._next()) is not None:
            future, function, arguments = task
            take, fail = partial(self._end, future.set_result), partial(self._end, future.set_exception)
            try:
                self._pool.apply_async(function, arguments, callback=take, error_callback=fail)
            except Exception as error:
                # Not raised here: that would end the thread of the pool where it calls back.
                with self._lock:
                    self._under_way -= 1
                closed = InputError(f"the pool takes no more work: {error}; close it after the check")
                future.set_exception(closed if isinstance(error, ValueError) else error)

    def _next(self) -> Task | None:
        """The next task for the pool, but for those that were cancelled."""
        with self._lock:
            while self._waiting and self._under_way < self._most:
                task = self._waiting.popleft()
                if task[0].set_running_or_notify_cancel():
                    self._under_way += 1
                    return task
        return None

    def _end(self, settle: Callable[[Any], None], value: Any) -> None:
        """The end of a task. The pool gets the next one before this one is noted."""
        with self._lock:
            self._under_way -= 1
        self._fill()
        settle(value)

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
            results = iter(self._map(_apply, [work for _, work in waiting]))
            for future, _ in waiting:
                try:
                    result = next(results)
                except StopIteration:
                    raise InputError(OTHER_ORDER) from None
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
