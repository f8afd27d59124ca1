"""The loop integral of arrays in Fortran and in C order, compared with numpy's real transforms of the same arrays.

Run it with ``python python/benches/loop_integral.py [DOF SAMPLES]``; set RAYON_NUM_THREADS=1 to compare single threads. Times are
the shortest of several, in microseconds for each degree of freedom.
"""

import sys
import time

import numpy as np
import symplint

REPETITIONS = 7


def shortest(work):
    seconds = []
    for _ in range(REPETITIONS):
        start = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def of_transforms(q, p):
    """The pseudospectral integral of rows, one for each degree of freedom, without an error estimate."""
    samples = q.shape[1]
    k = np.arange(samples // 2 + 1)
    k[-1] *= samples % 2
    q_modes, p_modes = np.fft.rfft(q, axis=1), np.fft.rfft(p, axis=1)
    terms = k * (p_modes.imag * q_modes.real - p_modes.real * q_modes.imag)
    return 4 * np.pi / samples**2 * terms.sum()


def main():
    dof, samples = map(int, sys.argv[1:3]) if len(sys.argv) > 2 else (1024, 4096)
    angle = 2 * np.pi * ((np.arange(samples) + 37 * np.arange(dof)[:, None]) % samples) / samples
    # One row for each degree of freedom: the transposed arrays are in Fortran order.
    q, p = np.sin(angle), np.cos(angle)
    found = symplint.loop_integral(q.T, p.T).value
    assert abs(found / of_transforms(q, p) - 1.0) < 1e-13, found
    in_c_order = np.ascontiguousarray(q.T), np.ascontiguousarray(p.T)
    print(f"{dof} x {samples}, microseconds for each degree of freedom")
    works = {
        "symplint, Fortran order": lambda: symplint.loop_integral(q.T, p.T),
        "symplint, C order": lambda: symplint.loop_integral(*in_c_order),
        "the same, pseudospectral": lambda: symplint.loop_integral(q.T, p.T, rule="pseudospectral"),
        "two numpy.fft.rfft": lambda: of_transforms(q, p),
        "reading: q.sum() + p.sum()": lambda: q.sum() + p.sum(),
    }
    for name, work in works.items():
        print(f"{name:28}{1e6 * shortest(work) / dof:8.2f}")


if __name__ == "__main__":
    main()
