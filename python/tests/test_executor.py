"""Steps that workers take: the same bits, whichever worker takes them, and whatever happens to workers."""

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
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import symplint

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
    # It has apply_async instead of submit.
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


def test_a_worker_that_dies_ends_the_check_which_resumes(tmp_path, monkeypatch):
    monkeypatch.setenv("SYMPLINT_MARK", str(tmp_path / "mark"))
    with ThreadPoolExecutor(1) as alone:
        expected = bits(check(verlet, alone))
    with ProcessPoolExecutor(2) as executor, pytest.raises(symplint.SymplintError, match="a worker died .* with the same run_dir= resumes"):
        check(dying_once, executor, out=tmp_path / "run")
    with ProcessPoolExecutor(2) as executor:
        report = check(dying_once, executor, out=tmp_path / "run")
    assert bits(report) == expected
    assert report.to_dict()["provenance"]["replayed"] > 0
    # A pool of `multiprocessing` does not report it.
    (tmp_path / "mark").unlink()
    with multiprocessing.Pool(2) as pool:
        error = in_time(lambda: check(dying_once, pool, out=tmp_path / "pool"))
        assert isinstance(error, symplint.SymplintError) and "exit code -9" in str(error)
    # Processes that end as they should are not dead.
    with multiprocessing.Pool(2, maxtasksperchild=5) as pool:
        assert bits(check(dying_once, pool, out=tmp_path / "pool")) == expected


class _OfDask:
    """An executor whose scheduler ends."""

    def __init__(self):
        self._client = types.SimpleNamespace(status="closed")

    def submit(self, function, *arguments):
        return Future()


def test_a_scheduler_that_ends_ends_the_check():
    error = in_time(lambda: check(verlet, _OfDask()))
    assert isinstance(error, symplint.SymplintError) and "scheduler of the executor ended" in str(error)


class _Cancels:
    """An executor that cancels all tasks."""

    def submit(self, function, *arguments):
        future = Future()
        future.cancel()
        return future


def test_an_exception_without_text_is_its_type():
    with pytest.raises(symplint.SymplintError, match=r"a worker died \(CancelledError\);"):
        check(verlet, _Cancels())


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
    with multiprocessing.Pool(1) as pool:
        pass
    for closed in (executor, pool):
        with pytest.raises(symplint.InputError, match="takes no more work"):
            check(verlet, closed)
    with pytest.raises(symplint.InputError, match="submit or map"):
        check(verlet, object())


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
        with pytest.warns(UserWarning, match=r"workers return q that differ by up to [24]\.[24]e-16 in degree of freedom 0"):
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
def test_workers_that_resume_are_compared_with_those_before(tmp_path):
    def stop(measured, planned, h):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        with_workers(compared_apart, [0], out=tmp_path, progress=stop)
    assert scatter(with_workers(compared_apart, [1], out=tmp_path))["size"] == pytest.approx(1e-6, rel=1e-3)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_the_larger_of_chance_and_the_difference_of_workers_counts():
    assert scatter(with_workers(by_chance, [0]))["size"] < 1e-11
    assert scatter(with_workers(by_chance, [0, 1]))["size"] == pytest.approx(1e-6, rel=1e-3)


def of_other_library(q, p, h):
    q, p = verlet(q, p, h)
    return np.where(APART % 2 * FIRST.pop() if FIRST else False, np.nan, q), p


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_workers_that_return_no_numbers_end_the_check():
    with pytest.raises(symplint.SymplintError, match="not finite"):
        with_workers(of_other_library, [1])


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


class Counting:
    """A pool that counts the tasks of each call."""

    def __init__(self):
        self.tasks = []

    def map(self, function, work):
        work = list(work)
        self.tasks.append(len(work))
        return [function(item) for item in work]


def test_a_pool_is_called_only_if_there_are_tasks():
    pool = Counting()
    report = check(verlet, pool)
    assert sum(pool.tasks) > 0 and 0 not in pool.tasks
    assert bits(report) == bits(check(verlet, None))
