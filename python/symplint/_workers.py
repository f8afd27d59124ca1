"""Steps that the workers of an executor take: threads, processes, or other machines.

States are cut into arcs that depend on their number alone, and put together in their order: what comes of them is the same to
the last bit for any number of workers. Several arcs make one task where they take little time.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import socket
import threading
import time
import traceback
import uuid
import warnings
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Future, ProcessPoolExecutor
from typing import Any

import numpy as np

from . import _native
from ._arrays import Array
from ._comparison import Comparison, States
from ._errors import InputError, SymplintError
from ._pools import OTHER_ORDER, OfMap, OfPool, has_callbacks

#: Arcs of one set of states, at most.
MOST_ARCS = 64
#: Seconds that a task should take: to send it takes about a millisecond, and eight where Dask does.
TASK_SECONDS = 0.2
#: Tasks for each worker, at least, so that all have about the same to do.
TASKS_OF_WORKER = 3
#: Seconds that a task should take where it is not known how many workers there are.
SHORT_TASK_SECONDS = 0.005
#: Seconds after which it is looked whether there are any workers left.
SECONDS_OF_A_LOOK = 1.0
#: States that every worker advances first, so that all can be compared.
COMPARED = 8
#: Checks at once that a worker tells from each other.
MOST_CHECKS = 16


class Workers:
    """The workers of an executor, which take the steps of a check."""

    def __init__(self, executor: Any, step: Callable[..., Any], *, per_sample: bool, make: bool, single: bool, reset: Any):
        # That of Dask has an interface of its own, beside the one of the standard library.
        executor = executor.get_executor() if hasattr(executor, "get_executor") else executor
        if not callable(getattr(executor, "submit", None)):
            if not callable(getattr(executor, "map", None)):
                message = "give one with a method submit or map, as those of concurrent.futures have"
                raise InputError(f"executor is an object of type {type(executor).__name__}; {message}")
            executor = OfPool(executor) if has_callbacks(executor) else OfMap(executor)
        self._executor: Any = executor
        self._scheduler = _scheduler(executor)
        self._renewed = False
        self._step = _Step(step, per_sample, make, single, reset, uuid.uuid4().hex)
        if isinstance(executor, ProcessPoolExecutor):
            _check_can_be_sent(self._step)
        #: What notes the states that are advanced, if anything does.
        self.journal: Any = None
        self._begun: dict[bytes, deque[_Arc]] = {}
        self._sent = 0
        #: Held while what follows changes: threads of executors change it, too.
        self._lock = threading.Lock()
        #: Tasks that are under way.
        self._tasks: set[_Task] = set()
        #: Tasks that were lost with a worker, until their arcs are sent again.
        self._broken: list[_Task] = []
        self.comparison = Comparison()
        #: Seconds that an arc takes, once that is known.
        self._seconds: float | None = None

    def begin(self, h: float, q: Array, p: Array) -> None:
        """Lets workers begin to advance states that will be asked for."""
        arcs = [_Arc(h, *states) for states in self._cut(q, p)]
        for arc in arcs:
            self._begun.setdefault(arc.key, deque()).append(arc)
        self._submit(arcs)

    def advance(self, h: float, q: Array, p: Array) -> tuple[States | None, tuple[int, BaseException] | None]:
        """What comes of states, or the sample at which that failed first and why."""
        arcs, new = [], []
        for states in self._cut(q, p):
            arc = _Arc(h, *states)
            if begun := self._begun.get(arc.key):
                arc = begun.popleft()
                if not begun:
                    del self._begun[arc.key]
            else:
                new.append(arc)
            arcs.append(arc)
        self._submit(new)
        first = 0
        for arc in arcs:
            self._wait(arc)
            if arc.reason is not None:
                return None, (first, RuntimeError(_died(first, len(arc.q), arc.reason)))
            if arc.failure is not None:
                sample, error = arc.failure
                return None, (first + sample, error)
            first += len(arc.q)
        done = [arc.after for arc in arcs if arc.after is not None]
        return (np.concatenate([q for q, _ in done]), np.concatenate([p for _, p in done])), None

    def found(self) -> tuple[int, tuple[str, int, float] | None, int]:
        """How many processes took steps, the largest difference between their results for the same states, and how many
        states were taken from the journal to be compared with alone."""
        found = self.comparison
        if found.unlike is not None:
            raise found.unlike
        return len(found.processes), found.difference, found.recalled

    def close(self) -> None:
        """Gives up what was not asked for; where a journal is kept, but for what is under way."""
        under_way = [task for task in self._under_way() if task.future is not None and not task.future.cancel()]
        try:
            if self.journal is not None:
                for task in under_way:
                    self._wait_for(task)
        except SymplintError:
            # What is under way is lost with the connection.
            pass
        finally:
            with self._lock:
                # Another check may want it.
                self.journal = None
                self.comparison.end()
        if self._renewed:
            self._executor.shutdown(wait=False, cancel_futures=True)
        if self.comparison.difference is not None:
            name, dof, size = self.comparison.difference
            message = f"of the same states workers make {name} that differ by up to {size:.2g} in degree of freedom {dof}"
            warnings.warn(f"{message}: that is taken for noise", stacklevel=4)

    def _cut(self, q: Array, p: Array) -> Iterator[States]:
        """The arcs of states."""
        width = 1 if self._step.per_sample else max(1, -(-len(q) // MOST_ARCS))
        for first in range(0, len(q), width):
            yield q[first : first + width], p[first : first + width]

    def _submit(self, arcs: list[_Arc]) -> None:
        """Sends arcs to workers, but those that the journal has."""
        is_first = self.comparison.states is None and bool(arcs)
        if is_first:
            # The first ones of all, so that those who go on with a run are compared with those who began it.
            self.comparison.begin(self.journal, arcs[0].h, *_first(arcs, COMPARED))
        wanted = []
        for arc in arcs:
            if self.journal is not None:
                arc.call, found = self.journal.find(arc.h, arc.q, arc.p)
                if found is not None:
                    arc.finish(found)
                    continue
            wanted.append(arc)
        if wanted and is_first:
            # Those that have nothing else to do yet are compared meanwhile.
            for _ in range(_count(self._executor) - len(wanted)):
                self._send(_Task([]))
        together = self._together(len(wanted))
        for first in range(0, len(wanted), together):
            self._send(_Task(wanted[first : first + together]))

    def _together(self, arcs: int) -> int:
        """How many of so many arcs make a task."""
        # Of what is noted no more than the call under way is lost with a worker.
        if self._seconds is None or self.journal is not None:
            return 1
        workers = _count(self._executor)
        of_task = TASK_SECONDS if workers else SHORT_TASK_SECONDS
        together = int(of_task / max(self._seconds, 1e-9))
        if workers:
            together = min(together, arcs // (TASKS_OF_WORKER * workers))
        return max(1, together)

    def _send(self, task: _Task) -> None:
        self._sent += 1
        task.executor, task.number = self._executor, self._sent
        arguments = (self._step, self.comparison.states, [(arc.h, arc.q, arc.p) for arc in task.arcs], self._sent)
        with self._lock:
            self._tasks.add(task)
        for arc in task.arcs:
            arc.task = task
        try:
            task.future = self._executor.submit(_advance, *arguments)
        except BrokenExecutor as error:
            self._lose(task, error)
            return
        except RuntimeError as error:
            raise InputError(f"the executor takes no more work: {error}; shut it down after the check") from error
        task.future.add_done_callback(lambda future: self._take(task, future))

    def _take(self, task: _Task, future: Future[_Result]) -> None:
        """Takes what a task made of its arcs, and notes it at once. Executors call this on threads of their own."""
        try:
            try:
                result = future.result()
            except BaseException as error:
                # Dask makes tasks again where workers die, some times.
                if isinstance(error, BrokenExecutor | CancelledError) or type(error).__name__ == "KilledWorker":
                    self._lose(task, error)
                else:
                    task.error = error
                return
            if not isinstance(result, _Result) or result.number != task.number:
                raise InputError(OTHER_ORDER)
            with self._lock:
                self.comparison.take(result.process, result.compared)
                if result.states:
                    self._seconds = result.seconds / len(result.states)
            journal = self.journal
            for arc, after in zip(task.arcs, result.states, strict=False):
                if isinstance(after, _Failure):
                    arc.fail(after.sample, after.error)
                    continue
                if journal is not None:
                    journal.note(arc.call, *after)
                arc.finish(after)
        except BaseException as error:
            task.error = error
        finally:
            with self._lock:
                self._tasks.discard(task)
            task.done.set()

    def _lose(self, task: _Task, error: BaseException) -> None:
        """A task whose worker is lost, which may be told twice."""
        with self._lock:
            if task in self._tasks:
                task.broken = error
                self._tasks.remove(task)
                self._broken.append(task)
        task.done.set()

    def _under_way(self) -> list[_Task]:
        with self._lock:
            return list(self._tasks)

    def _wait(self, arc: _Arc) -> None:
        """Waits until an arc is advanced. Where a worker died, it is sent to another one."""
        while not arc.is_done:
            task = arc.task
            assert task is not None
            if isinstance(self._executor, OfMap):
                self._executor.make()
            self._wait_for(task)
            if (error := task.error or self.comparison.unlike) is not None:
                raise error
            if not arc.is_done and task.broken is not None:
                self._send_again(task)

    def _wait_for(self, task: _Task) -> None:
        while not task.done.wait(SECONDS_OF_A_LOOK):
            self._check_connection()

    def _check_connection(self) -> None:
        """Whether tasks may still end: to those who wait Dask says nothing of a scheduler that is gone, or was started again,
        and pools nothing of a process that died."""
        if isinstance(self._executor, OfPool):
            self._executor.check()
        client = getattr(self._executor, "_client", None)
        if getattr(client, "status", None) in ("closing", "closed"):
            remedy = "run the check again when there are workers; with out= no step is taken again"
            raise SymplintError(f"the connection to the scheduler of the executor is lost; {remedy}")
        scheduler = _scheduler(self._executor)
        if scheduler not in (None, self._scheduler):
            self._scheduler = scheduler
            for task in self._under_way():
                self._lose(task, CancelledError("the scheduler was started again"))

    def _send_again(self, broken: _Task) -> None:
        """Sends all arcs that were lost with workers to other ones."""
        if broken.executor is self._executor:
            self._renew(broken)
        if broken.executor is not self._executor:
            # With a pool all is lost that it had, and told one after the other.
            for task in self._under_way():
                if task.executor is broken.executor:
                    self._wait_for(task)
        with self._lock:
            lost, self._broken = self._broken, []
        lost.sort(key=lambda task: task.number)
        arcs = [arc for task in lost for arc in task.arcs if not arc.is_done and arc.task is task]
        for arc in arcs:
            arc.deaths += 1
        suspects = [arc for arc in arcs if arc.deaths > 1]
        self._send_together([arc for arc in arcs if arc.deaths == 1])
        # Those that were sent first began first: one of these it was, most likely.
        while suspects:
            if self._is_deadly(suspects.pop(0)):
                for arc in suspects:
                    arc.deaths = 1
                self._send_together(suspects)
                break

    def _send_together(self, arcs: list[_Arc]) -> None:
        for arc in arcs:
            self._send(_Task([arc]))

    def _is_deadly(self, arc: _Arc) -> bool:
        """Whether an arc ends its worker. Alone it is told from others that are under way."""
        self._settle()
        alone = _Task([arc])
        self._send(alone)
        self._wait_for(alone)
        if alone.broken is None or arc.is_done:
            return False
        arc.reason = f"{type(alone.broken).__name__}: {alone.broken}"
        self._renew(alone)
        return True

    def _settle(self) -> None:
        """Waits until no task is under way."""
        for task in self._under_way():
            self._wait_for(task)
        if isinstance(self._executor, ProcessPoolExecutor) and getattr(self._executor, "_broken", False):
            self._renew(None)

    def _renew(self, broken: _Task | None) -> None:
        """A pool of processes takes no more work after one of them died: another one like it does."""
        if broken is not None and broken.executor is not self._executor:
            return
        if isinstance(self._executor, ProcessPoolExecutor):
            old: Any = self._executor
            self._executor = ProcessPoolExecutor(
                max_workers=old._max_workers,
                mp_context=old._mp_context,
                initializer=old._initializer,
                initargs=old._initargs,
                max_tasks_per_child=old._max_tasks_per_child,
            )
            if self._renewed:
                old.shutdown(wait=False, cancel_futures=True)
            self._renewed = True

def _died(first: int, count: int, reason: str) -> str:
    if count == 1:
        return f"every worker that was to advance this state died ({reason})"
    return f"every worker that was to advance samples {first} to {first + count - 1} died, at one of them ({reason})"


class _Arc:
    """States that are advanced together."""

    def __init__(self, h: float, q: Array, p: Array) -> None:
        self.h, self.q, self.p = h, np.ascontiguousarray(q), np.ascontiguousarray(p)
        digest = hashlib.blake2b(np.float64(h).tobytes(), digest_size=16)
        digest.update(self.q.tobytes())
        digest.update(self.p.tobytes())
        self.key = digest.digest()
        #: What the journal knows it by.
        self.call: Any = None
        self.task: _Task | None = None
        self.after: States | None = None
        self.failure: tuple[int, BaseException] | None = None
        #: Workers that died with it.
        self.deaths = 0
        #: How they died, where all do.
        self.reason: str | None = None

    @property
    def is_done(self) -> bool:
        return self.after is not None or self.failure is not None or self.reason is not None

    def finish(self, after: States) -> None:
        self.after = after

    def fail(self, sample: int, error: BaseException) -> None:
        self.failure = (sample, error)


class _Task:
    """Arcs that a worker advances."""

    def __init__(self, arcs: list[_Arc]) -> None:
        self.arcs = arcs
        self.executor: Any = None
        #: The how manyth that was sent.
        self.number = 0
        self.future: Future[_Result] | None = None
        self.done = threading.Event()
        #: Why its worker is lost.
        self.broken: BaseException | None = None
        #: What stops the check.
        self.error: BaseException | None = None


class _Step:
    """The step, as workers get it."""

    def __init__(self, function: Any, per_sample: bool, make: bool, single: bool, reset: Any, of_check: str) -> None:
        self.function, self.per_sample, self.make = function, per_sample, make
        self.single, self.reset, self.of_check = single, reset, of_check
        #: The process of the check.
        self.home = _process()


class _Failure:
    """An exception of the step, and the sample of the arc."""

    def __init__(self, sample: int, error: BaseException) -> None:
        self.sample, self.error = sample, error


class _Result:
    """What a worker made of a task."""

    def __init__(self, number: int) -> None:
        #: The number of the task.
        self.number = number
        self.process = _process()
        self.states: list[States | _Failure] = []
        self.seconds = 0.0
        #: The states that all workers advance, with the first task of each.
        self.compared: States | None = None


def _process() -> str:
    """This process on this machine."""
    return f"{socket.gethostname()}:{os.getpid()}"


#: Checks, one after the other or at once, for which this process has advanced the states that all workers advance, and the
#: steps made for them.
_known: dict[str, dict[float, Any]] = {}
_known_lock = threading.Lock()


def _advance(
    step: _Step, compared: tuple[float, Array, Array] | None, arcs: list[tuple[float, Array, Array]], number: int
) -> _Result:
    """Advances arcs, in the process of a worker."""
    with _known_lock:
        is_first = step.of_check not in _known
        if is_first:
            _known[step.of_check] = {}
            while len(_known) > MOST_CHECKS:
                del _known[next(iter(_known))]
    result = _Result(number)
    # The process of the check knows of no other one.
    if is_first and compared is not None and step.home != result.process:
        after = _call(step, *compared)
        result.compared = None if isinstance(after, _Failure) else after
    start = time.perf_counter()
    for arc in arcs:
        after = _call(step, *arc)
        result.states.append(after)
    result.seconds = time.perf_counter() - start
    return result


def _call(step: _Step, h: float, q: Array, p: Array) -> States | _Failure:
    function = step.function
    if step.make:
        made = _known.get(step.of_check, {})
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
    """The exception for the process of the check, with its traceback as a note, or one with its text where it cannot be sent."""
    if step.home == _process():
        return error
    text = "".join(traceback.format_exception(error))
    sent = error
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        sent = RuntimeError(f"{type(error).__name__}: {error}")
    sent.add_note("in a worker:\n" + text)
    return sent


def _count(executor: Any) -> int:
    """Workers of an executor, as far as it says so."""
    # Of the standard library, which has no public name for it, and of mpi4py.
    found = getattr(executor, "_max_workers", None) or getattr(executor, "num_workers", None)
    if (client := getattr(executor, "_client", None)) is not None and hasattr(client, "nthreads"):
        found = sum(client.nthreads().values())
    return found if isinstance(found, int) else 0


def _scheduler(executor: Any) -> Any:
    """What tells the scheduler of Dask that an executor is connected with from one that was started again."""
    client = getattr(executor, "_client", None)
    return (getattr(client, "_scheduler_identity", None) or {}).get("id")


def _first(arcs: list[_Arc], count: int) -> States:
    """The first states of arcs."""
    q = np.concatenate([arc.q for arc in arcs[:count]])[:count]
    p = np.concatenate([arc.p for arc in arcs[:count]])[:count]
    return q, p


def _check_can_be_sent(step: _Step) -> None:
    try:
        pickle.dumps(step)
    except Exception as error:
        remedy = "define it at the top level of a module, or give an executor of threads or of Dask"
        raise InputError(f"step cannot be sent to other processes: {error}; {remedy}") from error
