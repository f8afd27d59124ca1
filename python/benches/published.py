"""A check of a plasma, compared with the code that was published with the paper, on one thread.

Run it with ``NUMBA_NUM_THREADS=1 python python/benches/published.py FOLDER``, where FOLDER is a clone of
https://github.com/wbarham/symplectic_diagnostic. It needs scipy, matplotlib, numba and pyfftw. Both codes send the same loop through
Strang steps and Heun steps and compute the loop integrals. The published code makes one run for each step size, which all take the
same time: one of them is timed. Times are the shortest of several, in microseconds for each sample and step size.
"""

import sys
import time
from pathlib import Path

import symplint
from symplint import integrators, systems

SAMPLES = 4096
STEP_SIZES = [2.0**-m for m in range(1, 11)]
REPETITIONS = 5
# Seconds after which threads that one code leaves waiting for work no longer disturb the other.
REST = 0.05
PLASMA = {"Nx": 128, "boxsize": 50.0, "n0": 1.0, "vb": 3.0, "vth": 1.0, "A": 0.5, "k": 1, "IC": "two_stream", "seed": 42}
METHOD = {"rad": 1.0, "Ntheta": SAMPLES, "dt": STEP_SIZES[0], "order_time": 2, "order_space": 3, "filter": 0, "verbose": False}


def alternate(works):
    """The shortest time of each work, in turn, and its last result."""
    seconds, results = [float("inf")] * len(works), [work() for work in works]
    for _ in range(REPETITIONS):
        for k, work in enumerate(works):
            time.sleep(REST)
            start = time.perf_counter()
            results[k] = work()
            seconds[k] = min(seconds[k], time.perf_counter() - start)
    return seconds, results


def check(steps, x, v):
    settings = {"radius": 1.0, "phases": "equal", "samples": SAMPLES, "rule": "pseudospectral", "step_sizes": STEP_SIZES, "budget": 100_000}
    nothing_else = {"loops": 1, "jacobian": False, "properties": False, "localise": False}
    return [symplint.check(step, x, v, threads=1, **settings, **nothing_else) for step in steps]


def defects(reports):
    points = [report.points for report in reports]
    assert all(len(of_step) == len(STEP_SIZES) for of_step in points)
    return [abs(of_step["signed_defect"][0]) for of_step in points]


def main():
    folder = Path(sys.argv[1])
    sys.path[:0] = [str(folder / "pic_1d"), str(folder)]
    import simulate

    print(f"{SAMPLES} samples, a Strang and a Heun step, degree 3; microseconds for each sample and step size")
    print(f"{'particles':>9} {'published':>10} {'symplint':>9} {'ratio':>6}")
    for particles in (2, 128):
        settings = PLASMA | METHOD | {"Np": particles}
        x, v = simulate.two_stream_IC(particles, *(PLASMA[key] for key in ("boxsize", "vb", "vth", "A")), seed=PLASMA["seed"])
        plasma = systems.pic_1d(degree=3, particles=particles)
        steps = [integrators.strang(plasma, variant="momentum-first"), integrators.rk2(plasma, variant="heun")]
        works = [lambda: simulate.run_simulation(settings), lambda: check(steps, x, v)]
        (theirs, ours), (expected, reports) = alternate(works)
        for defect, key in zip(defects(reports), ("rel_err_symp", "rel_err_non"), strict=True):
            assert abs(defect - expected[key]) < 1e-9, (defect, expected[key])
        theirs, ours = 1e6 * theirs / SAMPLES, 1e6 * ours / SAMPLES / len(STEP_SIZES)
        print(f"{particles:9} {theirs:10.1f} {ours:9.2f} {theirs / ours:6.0f}")


if __name__ == "__main__":
    main()
