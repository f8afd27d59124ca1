"""Steps that workers take: the same bits, whoever takes them, and whatever happens to workers."""

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
