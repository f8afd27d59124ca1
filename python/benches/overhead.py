"""What a step in Python takes beside the step alone, in the same run.

Run it with ``python python/benches/overhead.py``. For a vectorised step, the time of the whole way from the diagnostic to the
step and back is compared with the time of the step alone on its own arrays in C order, and in the same way for a step of one
state. Times are the shortest of many, because other programs make them longer.
"""

import time

import numpy as np
from symplint import _native
from symplint._check import _subject

REPETITIONS = 41


def verlet(q, p, h):
    p = p - 0.5 * h * np.sin(q)
    q = q + h * p
    return q, p - 0.5 * h * np.sin(q)


def verlet_in_place(q, p, h):
    p -= 0.5 * h * np.sin(q)
    q += h * p
    p -= 0.5 * h * np.sin(q)


def chain(q, p, h):
    p = p + h * (np.roll(q, 1, axis=1) + np.roll(q, -1, axis=1) - 2.0 * q - np.sin(q))
    return q + h * p, p


def drift(q, p, h):
    return q + h * p, p


def of_state(q, p, h):
    return q, p


def subject(step, dof, **arguments):
    settings = {
        "radius": 1.0, "phases": "staggered", "seed": 1, "loop": None, "project": None, "period": None, "momentum_period": None,
        "weight": None, "per_sample": False, "make": False, "reset": None, "dtype": None, "threads": None,
    }  # fmt: skip
    return _subject(step, np.ones(dof), np.ones(dof), **(settings | arguments))


def alone(step, samples, dof, single=False):
    kind = np.float32 if single else np.float64
    q, p = np.ones((samples, dof), kind), np.ones((samples, dof), kind)
    seconds = []
    for _ in range(REPETITIONS):
        a, b = q.copy(), p.copy()
        start = time.perf_counter()
        step(a, b, 0.1)
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def through(step, samples, dof, **arguments):
    return min(_native.advance_seconds(subject(step, dof, **arguments), 0.1, samples, REPETITIONS))


def main():
    print("vectorised: milliseconds of a step of 100,000 samples x degrees of freedom")
    print(f"{'step':18}{'dof':>6}{'samples':>9}{'alone':>9}{'through':>9}{'ratio':>8}")
    for step in (verlet, verlet_in_place, chain, drift):
        for dof in (1, 10, 100):
            samples = 100_000 // dof
            # In turns, so that both see the same state of the machine.
            pairs = [(alone(step, samples, dof), through(step, samples, dof)) for _ in range(5)]
            of_step, in_all = (min(column) for column in zip(*pairs, strict=True))
            print(f"{step.__name__:18}{dof:6}{samples:9}{1e3 * of_step:9.3f}{1e3 * in_all:9.3f}{in_all / of_step:8.2f}")
    print("\none state at a time: microseconds of a call")
    print(f"{'dof':>24}{'samples':>9}{'alone':>9}{'through':>9}")
    for dof in (1, 10, 100):
        samples = 1000
        q, p = np.ones(dof), np.ones(dof)
        start = time.perf_counter()
        for _ in range(100_000):
            of_state(q, p, 0.1)
        of_step = (time.perf_counter() - start) / 100_000
        in_all = through(of_state, samples, dof, per_sample=True) / samples
        print(f"{dof:24}{samples:9}{1e6 * of_step:9.2f}{1e6 * in_all:9.2f}")


if __name__ == "__main__":
    main()
