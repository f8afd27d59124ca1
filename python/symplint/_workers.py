"""Steps that the workers of an executor take: threads, processes, or other machines.

States are cut into arcs that depend on their number alone, and joined in their order: results are the same to the last bit for any
number of workers.
"""

from __future__ import annotations

import hashlib
import multiprocessing
import os
import pickle
import socket
import threading
import traceback
import uuid
import warnings
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Future, ProcessPoolExecutor
from functools import partial
from typing import Any

import numpy as np

from . import _native
from ._arrays import Array
from ._errors import InputError, SymplintError

#: Arcs of one set of states, at most.
MAX_ARCS = 64
#: Seconds between two tests whether an executor still has workers.
POLL_SECONDS = 1.0
#: Checks whose made steps a worker keeps, at most.
MAX_CHECKS = 16
#: The error of a method `map` that loses or reorders results.
OTHER_ORDER = (
    "the executor does not return one result for each task in the order of the tasks; give one whose map does, such "
    "as the executors of concurrent.futures"
)

States = tuple[Array, Array]


class Workers:
    """The workers of an executor, which take the steps of a check."""

    def __init__(self, executor: Any, step: Callable[..., Any], *, per_sample: bool, make: bool, single: bool, reset: Any):
        # A client of Dask has its own interface besides the one of the standard library.
        executor = executor.get_executor() if hasattr(executor, "get_executor") else executor
        if not callable(getattr(executor, "submit", None)):
            if not callable(getattr(executor, "map", None)):
                message = "give one with a method submit or map, such as the executors of concurrent.futures"
                raise InputError(f"executor is an object of type {type(executor).__name__}; {message}")
            executor = MapExecutor(executor)
        self._executor: Any = executor
        self._step = _Step(step, per_sample, make, single, reset)
        if isinstance(executor, ProcessPoolExecutor):
            _check_can_be_sent(self._step)
        #: The journal of the check, if there is one.
        self.journal: Any = None
        #: Arcs that were announced and are not asked for yet.
        self._begun: dict[bytes, deque[_Arc]] = {}
        #: Arcs whose results are not there yet. Executors call back on their own threads.
        self._under_way: set[_Arc] = set()
        self._lock = threading.Lock()
        self._sent = 0
        self._first: _Arc | None = None
        #: Results of each process for the states of the first arc, or nothing for the process of the check.
        self._processes: dict[str, States | _Failure | None] = {}

    def begin(self, h: float, q: Array, p: Array) -> None:
        """Lets workers begin to advance states that will be asked for."""
        for states in self._cut(q, p):
            arc = _Arc(h, *states)
            self._begun.setdefault(arc.key, deque()).append(arc)
            self._submit(arc)

    def advance(self, h: float, q: Array, p: Array) -> tuple[States | None, tuple[int, BaseException] | None]:
        """The states after a step, or the first sample whose step failed and its exception."""
        arcs = []
        for states in self._cut(q, p):
            arc = _Arc(h, *states)
            if begun := self._begun.get(arc.key):
                arc = begun.popleft()
                if not begun:
                    del self._begun[arc.key]
            else:
                self._submit(arc)
            arcs.append(arc)
        first, done = 0, []
        for arc in arcs:
            self._wait(arc)
            if arc.error is not None:
                raise arc.error
            if isinstance(arc.result, _Failure):
                return None, (first + arc.result.sample, arc.result.error)
            assert arc.result is not None
            done.append(arc.result)
            first += len(arc.q)
        return (np.concatenate([q for q, _ in done]), np.concatenate([p for _, p in done])), None

    def found(self) -> tuple[int, tuple[str, int, float] | None]:
        """The number of processes, and the largest difference between their results for the first arc: of q or p, the degree of
        freedom, the size."""
        largest = None
        reference = self._first.result if self._first is not None else None
        for process, result in self._processes.items():
            if isinstance(reference, tuple) and isinstance(result, tuple):
                difference = max(_differences(reference, result), key=lambda found: found[2])
                if not np.isfinite(difference[2]):
                    message = f"for the same states, worker {process} and another one return numbers of which some are not finite"
                    raise SymplintError(f"{message}; give workers with the same processor and libraries")
                if difference[2] > (0.0 if largest is None else largest[2]):
                    largest = difference
        return len(self._processes), largest

    def close(self) -> None:
        """Cancels the arcs that workers have not begun. With a journal, waits for the others."""
        with self._lock:
            under_way = list(self._under_way)
        begun = [arc for arc in under_way if arc.future is not None and not arc.future.cancel()]
        try:
            if self.journal is not None:
                for arc in begun:
                    self._wait(arc)
        except SymplintError:
            # They are lost with the executor.
            pass
        finally:
            # Another check may open it.
            self.journal = None

    def warn(self) -> None:
        """Warns if workers return other numbers for the same states."""
        if (difference := self.found()[1]) is not None:
            name, dof, size = difference
            message = f"for the same states workers return {name} that differ by up to {size:.2g} in degree of freedom {dof}"
            warnings.warn(f"{message}: symplint takes the difference for noise", stacklevel=3)

    def _cut(self, q: Array, p: Array) -> Iterator[States]:
        """The arcs of states."""
        width = 1 if self._step.per_sample else max(1, -(-len(q) // MAX_ARCS))
        for first in range(0, len(q), width):
            yield q[first : first + width], p[first : first + width]

    def _submit(self, arc: _Arc) -> None:
        """Sends an arc to a worker, unless the journal has its result."""
        if self._first is None:
            self._first = arc
            self._step.compared = (arc.h, arc.q, arc.p)
        if self.journal is not None:
            arc.call, arc.result = self.journal.find(arc.h, arc.q, arc.p)
            if arc.result is not None:
                arc.done.set()
                return
        self._sent += 1
        arc.number = self._sent
        with self._lock:
            self._under_way.add(arc)
        try:
            future = arc.future = self._executor.submit(_advance, self._step, (arc.h, arc.q, arc.p), arc.number)
        except BrokenExecutor as error:
            raise self._lost(error) from error
        except RuntimeError as error:
            raise InputError(f"the executor takes no more work: {error}; shut it down after the check") from error
        future.add_done_callback(partial(self._take, arc))

    def _take(self, arc: _Arc, future: Future[_Result]) -> None:
        """Stores the result of an arc in the journal at once."""
        try:
            result = future.result()
            if not isinstance(result, _Result) or result.number != arc.number:
                raise InputError(OTHER_ORDER)
            with self._lock:
                self._processes[result.process] = result.compared or self._processes.get(result.process)
            if self.journal is not None and not isinstance(result.after, _Failure):
                self.journal.note(arc.call, *result.after)
            arc.result = result.after
        except BaseException as error:
            # Dask sends a task to other workers a few times, and then raises KilledWorker.
            is_death = isinstance(error, BrokenExecutor | CancelledError) or type(error).__name__ == "KilledWorker"
            arc.error = self._lost(error) if is_death else error
        finally:
            with self._lock:
                self._under_way.discard(arc)
            arc.done.set()

    def _lost(self, error: BaseException) -> SymplintError:
        """The error of a check whose worker died."""
        kept = "with run_dir= no finished step would be lost"
        if self.journal is not None:
            kept = "the same check with the same run_dir= resumes, and takes no finished step again"
        return SymplintError(f"a worker died ({_with_text(error)}); remove the cause, such as too little memory; {kept}")

    def _wait(self, arc: _Arc) -> None:
        if isinstance(self._executor, MapExecutor):
            self._executor.run()
        while not arc.done.wait(POLL_SECONDS):
            # Futures of Dask wait for ever if their scheduler ends.
            client = getattr(self._executor, "_client", None)
            if getattr(client, "status", None) in ("closing", "closed"):
                raise self._lost(ConnectionError("the scheduler of the executor ended"))


class MapExecutor:
    """An executor made of a pool that has a method map alone."""

    def __init__(self, pool: Any) -> None:
        self._pool = pool
        self._map = getattr(pool, "imap", pool.map)
        self._waiting: list[tuple[Future[Any], Any]] = []
        #: Processes of `multiprocessing.Pool`, which has no public name for them: it replaces a dead one, and never answers.
        self._processes: set[Any] = set()

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        future: Future[Any] = Future()
        self._waiting.append((future, (function, arguments)))
        return future

    def run(self) -> None:
        """Runs all tasks that wait."""
        waiting = [task for task in self._waiting if task[0].set_running_or_notify_cancel()]
        self._waiting = []
        if not waiting:
            return
        failure: BaseException | None = None
        try:
            results = iter(self._map(_apply, [work for _, work in waiting]))
            for future, _ in waiting:
                future.set_result(self._next(results))
        except StopIteration:
            failure = InputError(OTHER_ORDER)
        except ValueError as error:
            failure = InputError(f"the executor takes no more work: {error}; close it after the check")
        except BaseException as error:
            failure = error
        for future, _ in waiting:
            if not future.done():
                future.set_exception(failure)

    def _next(self, results: Any) -> Any:
        self._processes |= set(getattr(self._pool, "_pool", ()))
        while self._processes:
            try:
                return results.next(timeout=POLL_SECONDS)
            except multiprocessing.TimeoutError:
                for process in self._processes:
                    if process.exitcode:
                        remedy = "with run_dir= the same check resumes; a concurrent.futures.ProcessPoolExecutor reports dead workers"
                        raise SymplintError(f"a worker died (exit code {process.exitcode}); {remedy}") from None
        return next(results)


class _Arc:
    """States that are advanced together."""

    def __init__(self, h: float, q: Array, p: Array) -> None:
        self.h, self.q, self.p = h, np.ascontiguousarray(q), np.ascontiguousarray(p)
        digest = hashlib.blake2b(np.float64(h).tobytes(), digest_size=16)
        digest.update(self.q.tobytes())
        digest.update(self.p.tobytes())
        self.key = digest.digest()
        #: Identifies it in the journal.
        self.call: Any = None
        self.number = 0
        self.future: Future[_Result] | None = None
        self.done = threading.Event()
        self.result: States | _Failure | None = None
        #: The exception that ends the check.
        self.error: BaseException | None = None


class _Step:
    """The step, as workers get it."""

    def __init__(self, function: Any, per_sample: bool, make: bool, single: bool, reset: Any) -> None:
        self.function, self.per_sample, self.make = function, per_sample, make
        self.single, self.reset = single, reset
        self.of_check = uuid.uuid4().hex
        #: The process of the check.
        self.home = _process()
        #: The step size and states that every process advances, so that symplint can compare them.
        self.compared: tuple[float, Array, Array] | None = None


class _Failure:
    """An exception of the step, and the sample of the arc."""

    def __init__(self, sample: int, error: BaseException) -> None:
        self.sample, self.error = sample, error


class _Result:
    """The result of an arc."""

    def __init__(self, number: int, after: States | _Failure, compared: States | _Failure | None) -> None:
        self.number, self.after, self.compared = number, after, compared
        self.process = _process()


def _process() -> str:
    """This process on this machine."""
    return f"{socket.gethostname()}:{os.getpid()}"


#: The steps that this process made, by check and step size.
_made: dict[str, dict[float, Any]] = {}


def _advance(step: _Step, arc: tuple[float, Array, Array], number: int) -> _Result:
    """Advances an arc, in the process of a worker."""
    compared = None
    if step.of_check not in _made:
        _made[step.of_check] = {}
        while len(_made) > MAX_CHECKS:
            del _made[next(iter(_made))]
        if step.compared is not None and step.home != _process():
            compared = _call(step, *step.compared)
    return _Result(number, _call(step, *arc), compared)


def _call(step: _Step, h: float, q: Array, p: Array) -> States | _Failure:
    function = step.function
    if step.make:
        made = _made.get(step.of_check, {})
        if h not in made:
            try:
                made[h] = step.function(h)
            except Exception as error:
                return _Failure(0, _sendable(step, error))
        function = made[h]
    states, failed = _native.advance(
        function, None if step.make else h, step.reset, step.per_sample, step.single, q, p
    )  # fmt: skip
    if failed is not None:
        sample, raised = failed
        return _Failure(sample, _sendable(step, raised))
    assert states is not None
    return states


def _sendable(step: _Step, error: BaseException) -> BaseException:
    """The exception with its traceback as a note, or, if it cannot be sent, another one with its text."""
    if step.home == _process():
        return error
    text = "".join(traceback.format_exception(error))
    sent = error
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        sent = RuntimeError(_with_text(error))
    sent.add_note("in a worker:\n" + text)
    return sent


def _with_text(error: BaseException) -> str:
    """The type of an exception, and its text if it has one."""
    return f"{type(error).__name__}: {error}".removesuffix(": ")


def _differences(first: States, other: States) -> Iterator[tuple[str, int, float]]:
    """The largest difference in each degree of freedom: infinite if only one of two numbers is finite."""
    for name, one, two in zip("qp", first, other, strict=True):
        with np.errstate(invalid="ignore"):
            apart = np.abs(two - one)
        apart[(one == two) | (np.isnan(one) & np.isnan(two))] = 0.0
        apart[~np.isfinite(apart)] = np.inf
        for dof, size in enumerate(apart.max(axis=0)):
            yield name, dof, float(size)


def _apply(work: tuple[Callable[..., Any], tuple[Any, ...]]) -> Any:
    function, arguments = work
    return function(*arguments)


def _check_can_be_sent(step: _Step) -> None:
    try:
        pickle.dumps(step)
    except Exception as error:
        remedy = "define it at the top level of a module, or give an executor of threads or of Dask"
        raise InputError(f"step cannot be sent to other processes: {error}; {remedy}") from error
