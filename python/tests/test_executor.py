"""Steps that workers take: the same bits, whoever takes them, and whatever happens to workers."""

import contextlib
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
import types
import warnings
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing.pool import ThreadPool
from pathlib import Path

import numpy as np
import pytest
import symplint
from symplint import _workers
from symplint._workers import Workers, _advance, _Step

SETTINGS = {"step_sizes": [0.5, 0.25, 0.125], "budget": 2000, "loops": 3}


def verlet(q, p, h):
    p = p - 0.5 * h * np.sin(q)
    q = q + h * p
    return q, p - 0.5 * h * np.sin(q)


def make(h):
    return lambda q, p: verlet(q, p, h)


def in_place(q, p, h):
    q[:], p[:] = verlet(q, p, h)


class OwnError(Exception):
    """One that cannot be sent to another process."""

    def __init__(self, text, more):
        super().__init__(text)
        self.more = more


def failing(q, p, h):
    if h == 0.25 and (q > 1.2).any():
        raise OwnError("too far", 1)
    return verlet(q, p, h)


def check(step, executor, **arguments):
    return symplint.check(step, [1.0, 0.2], [0.5, 0.1], executor=executor, **{**SETTINGS, **arguments})


def bits(report):
    found = json.loads(report.to_json())
    found.pop("provenance")
    found["config"] = {}
    return found


@pytest.mark.parametrize("per_sample", [False, True])
def test_the_same_bits_by_any_workers(per_sample):
    with ThreadPoolExecutor(1) as alone:
        expected = bits(check(verlet, alone, per_sample=per_sample))
    assert expected["verdict"]["kind"] == "symplectic"
    for count in (1, 2, 4):
        with ProcessPoolExecutor(count) as executor:
            report = check(verlet, executor, per_sample=per_sample)
        assert bits(report) == expected
        assert 1 <= report.to_dict()["provenance"]["workers"] <= count
    for step, arguments in ((make, {"make": True}), (in_place, {})):
        with ProcessPoolExecutor(2) as executor:
            assert bits(check(step, executor, per_sample=per_sample, **arguments)) == expected
    # It has apply_async in place of submit.
    with multiprocessing.Pool(2) as pool:
        assert bits(check(verlet, pool, per_sample=per_sample)) == expected


def test_dask():
    distributed = pytest.importorskip("distributed")
    with ThreadPoolExecutor(1) as alone:
        expected = bits(check(verlet, alone))

    def step(q, p, h):
        p = p - 0.5 * h * np.sin(q)
        q = q + h * p
        return q, p - 0.5 * h * np.sin(q)

    with distributed.Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
        assert bits(check(step, client)) == expected
        assert bits(check(step, client.get_executor())) == expected


def test_mpi(tmp_path):
    pytest.importorskip("mpi4py")
    program = tmp_path / "program.py"
    program.write_text(
        f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from concurrent.futures import ThreadPoolExecutor
from mpi4py.futures import MPIPoolExecutor
from test_executor import bits, check, verlet

if __name__ == "__main__":
    with MPIPoolExecutor() as executor, ThreadPoolExecutor(1) as alone:
        report = check(verlet, executor)
        assert bits(report) == bits(check(verlet, alone))
        print(report.to_dict()["provenance"]["workers"])
"""
    )
    command = ["mpirun", "--oversubscribe", "-n", "3", sys.executable, "-m", "mpi4py.futures", program]
    environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    found = subprocess.run(command, capture_output=True, text=True, timeout=120, env=environment, check=False)
    assert found.returncode == 0, found.stderr
    assert found.stdout.split() == ["2"]


def dying_once(q, p, h):
    mark = Path(os.environ["SYMPLINT_MARK"])
    if h == 0.125 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return verlet(q, p, h)


def dying(q, p, h):
    if h == 0.125 and (q > 1.9).any():
        os.kill(os.getpid(), signal.SIGKILL)
    return verlet(q, p, h)


def test_a_worker_that_dies_is_replaced(tmp_path, monkeypatch):
    monkeypatch.setenv("SYMPLINT_MARK", str(tmp_path / "mark"))
    with ThreadPoolExecutor(1) as alone:
        expected = bits(check(verlet, alone))
    with ProcessPoolExecutor(3) as executor:
        assert bits(check(dying_once, executor)) == expected
    assert (tmp_path / "mark").exists()


def test_a_state_that_ends_all_workers_is_named():
    with ProcessPoolExecutor(3) as executor, pytest.raises(symplint.StepError, match="state died") as raised:
        check(dying, executor)
    assert raised.value.h == 0.125
    # The others are measured.
    assert set(raised.value.report.points["step_size"]) == {0.5, 0.25}


@pytest.mark.parametrize("pool", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_exceptions_of_a_step_come_back(pool):
    with pool(2) as executor, pytest.raises(symplint.StepError, match="too far") as raised:
        check(failing, executor)
    cause = raised.value.__cause__
    assert raised.value.h == 0.25 and raised.value.report is not None
    assert "too far" in str(cause)
    if pool is ThreadPoolExecutor:
        assert isinstance(cause, OwnError)
    else:
        assert "in failing" in cause.__notes__[0]


def test_what_cannot_work_is_refused():
    with ProcessPoolExecutor(1) as executor:
        with pytest.raises(symplint.InputError, match="top level of a module"):
            check(lambda q, p, h: (q, p), executor)
        with pytest.raises(symplint.InputError, match="is for functions"):
            symplint.check(symplint.systems.pendulum(), executor=executor)
    with pytest.raises(symplint.InputError, match="takes no more work"):
        check(verlet, executor)
    with pytest.raises(symplint.InputError, match="submit or map"):
        check(verlet, 4)


def of_process(q, p, h):
    q, p = verlet(q, p, h)
    # One unit in the last place more in every second process.
    return (np.nextafter(q, 9.0) if os.getpid() % 2 else q), p


def test_workers_with_other_bits_are_reported():
    with ProcessPoolExecutor(2) as executor:
        # Processes that are started one after the other have numbers one after the other; the tasks make them wait.
        processes = set(executor.map(slow_process, range(8)))
        if len({process % 2 for process in processes}) < 2:
            pytest.skip("the processes are alike")
        with pytest.warns(UserWarning, match=r"workers make q that differ by up to [24]\.[24]e-16 in degree of freedom 0"):
            report = check(of_process, executor)
    assert report.kind == "symplectic"
    assert report.to_dict()["evidence"]["survey"]["scatter"]["size"] < 5e-16
    with warnings.catch_warnings(), ProcessPoolExecutor(2) as executor:
        warnings.simplefilter("error")
        check(verlet, executor)


def slow_process(_):
    time.sleep(0.02)
    return os.getpid()


def interrupted(q, p, h):
    mark = Path(os.environ["SYMPLINT_MARK"])
    with mark.open("a") as file:
        file.write("x")
    time.sleep(2e-3)
    return verlet(q, p, h)


@pytest.mark.parametrize("per_sample", [False, True])
def test_what_workers_did_is_noted(tmp_path, monkeypatch, per_sample):
    counts = tmp_path / "calls"
    monkeypatch.setenv("SYMPLINT_MARK", str(counts))

    def run(folder, stop=None):
        def progress(measured, planned, h):
            if measured == stop:
                raise KeyboardInterrupt

        counts.write_text("")
        with ThreadPoolExecutor(3) as executor:
            return check(interrupted, executor, per_sample=per_sample, out=folder, progress=progress)

    whole = run(tmp_path / "whole")
    calls = len(counts.read_text())
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path / "run", stop=2)
    before = len(counts.read_text())
    assert 0 < before < calls
    report = run(tmp_path / "run")
    assert before + len(counts.read_text()) == calls
    assert bits(report) == bits(whole)
    assert report.to_dict()["provenance"]["replayed"] > 0
    if not per_sample:
        with pytest.raises(symplint.InputError, match="arcs"):
            symplint.check(interrupted, [1.0, 0.2], [0.5, 0.1], **SETTINGS, out=tmp_path / "run")


class _OfScheduler:
    """An executor as that of Dask: what the scheduler had is lost with it, and nobody is told."""

    def __init__(self, answered):
        self._pool = ThreadPoolExecutor(1)
        self._client = types.SimpleNamespace(status="running", nthreads=lambda: {"worker": 1}, _scheduler_identity={"id": "first"})
        self.answered = answered
        self.lost = 0

    def submit(self, function, *arguments):
        if self.answered > 0 or self._client._scheduler_identity["id"] == "second":
            self.answered -= 1
            return self._pool.submit(function, *arguments)
        self.lost += 1
        return Future()


@pytest.mark.parametrize("out", [False, True])
def test_a_scheduler_that_is_gone_ends_a_check_and_one_that_is_started_again_does_not(tmp_path, out):
    arguments = {**SETTINGS, "per_sample": True} | ({"out": tmp_path} if out else {})
    gone = _OfScheduler(answered=30)
    gone._client.status = "closed"
    with pytest.raises(symplint.SymplintError, match="connection to the scheduler of the executor is lost"):
        symplint.check(verlet, 1.0, 0.5, executor=gone, **arguments)
    again = _OfScheduler(answered=30)
    threading.Timer(1.0, lambda: again._client._scheduler_identity.update(id="second")).start()
    found = symplint.check(verlet, 1.0, 0.5, executor=again, **arguments)
    assert again.lost > 0
    assert bits(found) == bits(symplint.check(verlet, 1.0, 0.5, **SETTINGS, per_sample=True))


def dying_in_a_pool(q, p, h):
    if h == 0.125:
        os.kill(os.getpid(), signal.SIGKILL)
    return verlet(q, p, h)


def in_time(function, seconds=60):
    """What a function raises, which must not wait for ever."""
    raised = []

    def run():
        try:
            function()
        except BaseException as error:
            raised.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(seconds)
    assert not thread.is_alive()
    return raised[0] if raised else None


def test_a_pool_whose_process_died_ends_the_check():
    with multiprocessing.Pool(2) as pool:
        error = in_time(lambda: check(dying_in_a_pool, pool))
    assert isinstance(error, symplint.SymplintError)
    assert "exit code -9" in str(error) and "ProcessPoolExecutor" in str(error)
    with multiprocessing.Pool(2) as pool, pytest.raises(symplint.StepError, match="too far"):
        check(failing, pool)
    with pytest.raises(symplint.InputError, match="takes no more work"):
        check(verlet, pool)
    # Processes that end as they should are not dead.
    with multiprocessing.Pool(2, maxtasksperchild=5) as pool:
        assert check(verlet, pool).kind == "symplectic"


class _Lazy:
    """What has `map` alone, and `imap`, and stops at a call."""

    def __init__(self, last=None):
        self.calls, self.last = 0, last

    def map(self, function, work):
        return list(self.imap(function, work))

    def imap(self, function, work):
        for item in work:
            if self.calls == self.last:
                raise KeyboardInterrupt
            self.calls += 1
            yield function(item)


def test_what_comes_one_by_one_is_noted_one_by_one(tmp_path):
    whole, stopped, again = _Lazy(), _Lazy(last=10), _Lazy()
    expected = bits(check(verlet, whole, out=tmp_path / "whole"))
    with pytest.raises(KeyboardInterrupt):
        check(verlet, stopped, out=tmp_path / "run")
    assert bits(check(verlet, again, out=tmp_path / "run")) == expected
    assert again.calls == whole.calls - 10


KILLED = """
import multiprocessing, os, sys, time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
sys.path.insert(0, {tests!r})
import symplint
from test_executor import SETTINGS, check, verlet

def step(q, p, h):
    with open("calls", "a") as file:
        file.write(f"{{os.getpid()}}\\n")
    if Path("calls").read_text().count("\\n") == 10 and len(sys.argv) > 1:
        os.kill(os.getppid(), 9)
    time.sleep(0.02)
    return verlet(q, p, h)

if __name__ == "__main__":
    multiprocessing.set_start_method("fork")
    with {pool}(1) as executor:
        print(check(step, executor, out="run").to_dict()["provenance"]["replayed"])
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.parametrize("pool", ["ProcessPoolExecutor", "multiprocessing.Pool"])
def test_workers_that_outlive_a_killed_program_do_not_keep_its_journal(tmp_path, pool):
    (tmp_path / "program.py").write_text(KILLED.format(tests=str(Path(__file__).parent), pool=pool))
    command = [sys.executable, "program.py"]
    killed = subprocess.Popen([*command, "kill"], cwd=tmp_path, start_new_session=True, stdout=subprocess.DEVNULL)
    try:
        assert killed.wait(60) == -signal.SIGKILL
        found = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    finally:
        # Those of a pool may have ended.
        with contextlib.suppress(ProcessLookupError):
            os.killpg(killed.pid, signal.SIGKILL)
    assert found.returncode == 0, found.stderr
    # What came back before is noted, but for what was on its way.
    assert int(found.stdout) >= 4


APART = 0
FIRST = [True]


def numbered(counter):
    global APART
    with counter.get_lock():
        APART = counter.value
        counter.value += 1


def compared_apart(q, p, h):
    # Of processes that are alike but for their first call, that of the compared states, the survey finds nothing.
    q, p = verlet(q, p, h)
    size = 1e-6 * (APART % 2) * FIRST[0]
    FIRST[0] = False
    time.sleep(1e-3)
    return q + size, p


def by_chance(q, p, h):
    q, p = compared_apart(q, p, h)
    return q + 1e-13 * np.random.default_rng().normal(size=q.shape), p


def with_workers(step, numbers, **arguments):
    """A check by workers that have these numbers, one after the other."""
    context = multiprocessing.get_context("fork")
    counter = context.Value("i", numbers[0])
    with ProcessPoolExecutor(len(numbers), context, numbered, (counter,)) as executor, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return check(step, executor, **arguments)


def scatter(report):
    return report.to_dict()["evidence"]["survey"]["scatter"]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_the_difference_of_workers_is_noted(tmp_path):
    first = with_workers(compared_apart, [0, 1], out=tmp_path / "run")
    assert scatter(first)["size"] == pytest.approx(1e-6, rel=1e-3)
    again = with_workers(compared_apart, [0], out=tmp_path / "run")
    assert bits(again) == bits(first)
    assert again.to_dict()["provenance"]["replayed"] == again.evaluations

    def stop(measured, planned, h):
        raise KeyboardInterrupt

    # Those who go on are compared with those who began.
    with pytest.raises(KeyboardInterrupt):
        with_workers(compared_apart, [0], out=tmp_path / "other", progress=stop)
    assert scatter(with_workers(compared_apart, [1], out=tmp_path / "other"))["size"] == pytest.approx(1e-6, rel=1e-3)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_the_larger_of_chance_and_the_difference_of_workers_counts():
    assert scatter(with_workers(by_chance, [0]))["size"] < 1e-11
    assert scatter(with_workers(by_chance, [0, 1]))["size"] == pytest.approx(1e-6, rel=1e-3)


class _Losing:
    """An executor whose workers die with some of the first tasks, and which counts those that are under way."""

    def __init__(self, lost):
        self._pool = ThreadPoolExecutor(1)
        self.lost, self.under_way, self.most = lost, 0, 0

    def submit(self, function, *arguments):
        if self.lost > 0:
            self.lost -= 1
            future = Future()
            future.set_exception(BrokenExecutor("lost"))
            return future
        self.under_way += 1
        self.most = max(self.most, self.under_way)
        future = self._pool.submit(function, *arguments)
        future.add_done_callback(self.end)
        return future

    def end(self, future):
        self.under_way -= 1


def slow(q, p, h):
    time.sleep(2e-3)
    return verlet(q, p, h)


def test_arcs_that_were_lost_are_sent_together():
    executor = _Losing(lost=30)
    workers = Workers(executor, slow, per_sample=True, make=False, single=False, reset=None)
    q, p = np.ones((30, 1)), np.ones((30, 1))
    states, failed = workers.advance(0.5, q, p)
    assert failed is None and np.array_equal(states, verlet(q, p, 0.5))
    assert executor.most > 10


def dying_above(q, p, h):
    if (q > 500.0).any():
        os.kill(os.getpid(), signal.SIGKILL)
    return verlet(q, p, h)


def test_samples_with_which_workers_die_are_named():
    q = np.arange(640.0).reshape(-1, 1)
    with ProcessPoolExecutor(2) as executor:
        workers = Workers(executor, dying_above, per_sample=False, make=False, single=False, reset=None)
        # All behind them die, too: it is the first one.
        states, failed = workers.advance(0.5, q, q)
        workers.close()
    assert states is None and failed[0] == 500
    assert "samples 500 to 509 died, at one of them" in str(failed[1])


def test_checks_at_once_are_compared_once():
    steps = [_Step(verlet, False, False, False, None, f"check {k}") for k in range(3)]
    for step in steps:
        step.home = "elsewhere:1"
    states = np.ones((2, 1))
    results = [_advance(step, (0.5, states, states), [], 1) for _ in range(4) for step in steps]
    assert sum(result.compared is not None for result in results) == len(steps)


@pytest.mark.parametrize(("other", "is_unlike"), [(np.nan, True), (np.inf, True), (2.0, False)])
def test_workers_that_make_no_numbers_are_told(other, is_unlike):
    with ThreadPoolExecutor(1) as executor:
        workers = Workers(executor, verlet, per_sample=False, make=False, single=False, reset=None)
    for value in (2.0, other):
        # What nobody makes numbers of is alike.
        compared = (np.array([[1.0], [value], [np.nan]]), np.array([[np.inf], [0.0], [0.0]]))
        workers.comparison.take("process", compared)
    if is_unlike:
        with pytest.raises(symplint.SymplintError, match="not finite of states"):
            workers.found()
    else:
        assert workers.found()[1] is None


class _Killing(_OfScheduler):
    """As Dask: two workers die, and then the scheduler is gone."""

    def __init__(self):
        super().__init__(answered=30)
        self.deaths = 0

    def submit(self, function, *arguments):
        if self.answered > 0:
            return super().submit(function, *arguments)
        future = Future()
        self.deaths += 1
        if self.deaths > 2:
            self._client.status = "closed"
        else:
            future.set_exception(type("KilledWorker", (Exception,), {})("died"))
        return future


def test_a_scheduler_that_is_gone_while_a_state_is_tried_alone_ends_the_check():
    executor = _Killing()
    executor.answered = 0
    workers = Workers(executor, verlet, per_sample=True, make=False, single=False, reset=None)
    error = in_time(lambda: workers.advance(0.5, np.ones((1, 1)), np.ones((1, 1))), seconds=20)
    assert "connection to the scheduler" in str(error)


class _Kept:
    """An executor whose first tasks end when the test says so."""

    def __init__(self, kept):
        self.kept, self.futures, self.submitted = kept, [], 0

    def submit(self, function, *arguments):
        future = Future()
        self.submitted += 1
        if len(self.futures) < self.kept:
            self.futures.append(future)
        else:
            future.set_result(function(*arguments))
        return future


def test_a_task_that_is_lost_while_others_are_sent_again_is_sent_again(monkeypatch):
    executor = _Kept(2)

    class Task(_workers._Task):
        """One whose number is looked at as the second task is lost."""

        def __init__(self, arcs):
            super().__init__(arcs)
            self._number = 0

        @property
        def number(self):
            if not executor.futures[1].done():
                executor.futures[1].set_exception(BrokenExecutor("second"))
            return self._number

        @number.setter
        def number(self, number):
            self._number = number

    monkeypatch.setattr(_workers, "_Task", Task)
    workers = Workers(executor, verlet, per_sample=True, make=False, single=False, reset=None)
    q = np.ones((2, 1))
    workers.begin(0.5, q, q)
    executor.futures[0].set_exception(BrokenExecutor("first"))
    found = []
    assert in_time(lambda: found.append(workers.advance(0.5, q, q)), seconds=10) is None
    (states, failed) = found[0]
    assert failed is None and np.array_equal(states, verlet(q, q, 0.5))


def test_a_task_whose_loss_is_told_twice_is_sent_again_once():
    executor = _Kept(1)
    workers = Workers(executor, verlet, per_sample=True, make=False, single=False, reset=None)
    q = np.ones((1, 1))
    workers.begin(0.5, q, q)
    # By the scheduler that was started again, and by the executor.
    (task,) = workers._tasks
    workers._lose(task, BrokenExecutor("once"))
    executor.futures[0].set_exception(BrokenExecutor("twice"))
    states, failed = workers.advance(0.5, q, q)
    assert failed is None and np.array_equal(states, verlet(q, q, 0.5))
    assert executor.submitted == 2


class _Notes:
    """A journal that counts."""

    def __init__(self):
        self.noted = 0

    def find(self, h, q, p):
        return None, None

    def note(self, call, q, p):
        self.noted += 1


class _Gate:
    """A step that goes on when the test says so."""

    def __init__(self):
        self.opened, self.begun = threading.Event(), threading.Semaphore(0)
        self.calls = 0

    def step(self, q, p, h):
        self.begun.release()
        assert self.opened.wait(60)
        self.calls += 1
        return verlet(q, p, h)

    def begin(self, pool):
        """Workers with 16 tasks, each thread of the pool in the first one."""
        workers = Workers(pool, self.step, per_sample=True, make=False, single=False, reset=None)
        q = np.ones((16, 1))
        workers.begin(0.5, q, q)
        for _ in range(pool._processes):
            assert self.begun.acquire(timeout=60)
        return workers, q


def test_what_a_pool_has_under_way_at_the_end_is_noted_and_the_rest_is_not_made():
    gate = _Gate()
    with ThreadPool(1) as pool:
        workers, _ = gate.begin(pool)
        workers.journal = journal = _Notes()
        futures = [task.future for task in workers._tasks]

        def open_when_stopped():
            # The pool has the call under way alone.
            while sum(future.cancelled() for future in futures) < len(futures) - 1:
                time.sleep(1e-3)
            gate.opened.set()

        opening = threading.Thread(target=open_when_stopped, daemon=True)
        opening.start()
        assert in_time(workers.close, seconds=20) is None
        assert journal.noted == 1
        pool.close()
        pool.join()
    assert gate.calls == 1


def test_a_pool_that_is_closed_during_a_check_ends_it():
    gate = _Gate()
    with ThreadPool(1) as pool:
        workers, q = gate.begin(pool)
        pool.close()
        gate.opened.set()
        error = in_time(lambda: workers.advance(0.5, q, q), seconds=20)
    assert isinstance(error, symplint.InputError) and "close it after the check" in str(error)


class Backwards:
    """A pool that returns results in another order."""

    def map(self, function, work):
        return [function(item) for item in work][::-1]


class Lossy:
    """A pool that loses a result."""

    def map(self, function, work):
        return [function(item) for item in work][1:]


class Unordered:
    """A pool whose results come as they are ready."""

    def map(self, function, work):
        with ThreadPoolExecutor(4) as executor:
            futures = [executor.submit(function, item) for item in work]
            return [future.result() for future in reversed(futures)]


@pytest.mark.parametrize("pool", [Backwards, Lossy, Unordered])
@pytest.mark.parametrize("per_sample", [False, True])
def test_results_in_another_order_are_an_error(pool, per_sample):
    with pytest.raises(symplint.InputError, match="in the order of the tasks"):
        check(verlet, pool(), per_sample=per_sample)
