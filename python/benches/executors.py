"""How much faster several workers take the steps of a check than one, side by side in one run.

Run it with ``python python/benches/executors.py``, where Dask, mpi4py and mpirun are used if they are there. A step of one state takes
20 ms: of a processor, or asleep as a step that waits for another machine. All reports have to be the same to the last bit.
"""

import functools
import importlib.util
import os
import shutil
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import symplint

SECONDS = 0.02


def verlet(q, p, h):
    p = p - 0.5 * h * np.sin(q)
    q = q + h * p
    return q, p - 0.5 * h * np.sin(q)


def busy(q, p, h):
    # Processor time: a step that waits for its turn gets no further.
    end = time.thread_time() + SECONDS
    while time.thread_time() < end:
        pass
    return verlet(q, p, h)


def asleep(q, p, h):
    time.sleep(SECONDS)
    return verlet(q, p, h)


def ready(_):
    """Lets a worker start, and import what it needs."""
    time.sleep(0.1)


def seconds(step, executor, budget, workers=0):
    """Seconds of a check. Steps that take no processor are more: 8 on each worker, to compare workers, would weigh."""
    samples = 512 if step is asleep else "auto"
    if workers:
        list(executor.map(ready, range(workers)))
    start = time.perf_counter()
    report = symplint.check(step, 1.0, 0.5, samples=samples, executor=executor, per_sample=True, budget=budget)
    return time.perf_counter() - start, report.evaluations, report.points.tobytes()


def of_pool(pool, step, workers, budget):
    with pool(workers) as executor:
        return seconds(step, executor, budget, workers)


def of_dask(step, workers, budget):
    from distributed import Client

    with Client(n_workers=workers, threads_per_worker=1, dashboard_address=None) as client:
        client.run(ready, None)
        return seconds(step, client, budget)


def of_mpi(step, workers, budget):
    command = ["mpirun", "--oversubscribe", "-n", str(workers + 1), sys.executable, "-m", "mpi4py.futures", __file__]
    environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    arguments = [step.__name__, str(workers), str(budget)]
    found = subprocess.run([*command, *arguments], env=environment, capture_output=True, text=True, check=True)
    took, evaluations, bits = found.stdout.split()
    return float(took), int(evaluations), bytes.fromhex(bits)


def one_of_mpi(step, workers, budget):
    from mpi4py.futures import MPIPoolExecutor

    with MPIPoolExecutor() as executor:
        took, evaluations, bits = seconds(globals()[step], executor, int(budget), int(workers))
    print(took, evaluations, bits.hex())


def compare(name, run, step, counts, budget):
    alone, bits = None, None
    for workers in counts:
        took, evaluations, found = run(step, workers, budget)
        if alone is None:
            # One worker, or what all evaluations would take it.
            alone, bits = took if workers == 1 else evaluations * SECONDS, found
        assert found == bits, "other bits"
        times = alone / took
        row = f"{name:22}{step.__name__:8}{workers:8}{evaluations:13}{took:10.2f}{times:9.2f}{times / workers:11.2f}"
        print(row, flush=True)


def main():
    print(f"{'executor':22}{'step':8}{'workers':>8}{'evaluations':>13}{'seconds':>10}{'times':>9}{'a worker':>11}")
    processes = functools.partial(of_pool, ProcessPoolExecutor)
    threads = functools.partial(of_pool, ThreadPoolExecutor)
    compare("processes", processes, busy, (1, 2, 4), 1000)
    if importlib.util.find_spec("distributed"):
        compare("Dask", of_dask, busy, (1, 2, 4), 1000)
    if importlib.util.find_spec("mpi4py") and shutil.which("mpirun"):
        compare("MPI", of_mpi, busy, (1, 2), 1000)
    compare("threads", threads, asleep, (8, 32), 20_000)
    compare("processes", processes, asleep, (8, 32), 20_000)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        one_of_mpi(*sys.argv[1:])
    else:
        main()
