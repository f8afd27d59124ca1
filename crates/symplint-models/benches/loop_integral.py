"""Times the pseudospectral loop integral with numpy's real transforms: DOF SAMPLES; prints ns a sum."""

import sys
import time

import numpy as np

dof, samples = map(int, sys.argv[1:3])
s = np.arange(samples) / samples
phase = np.arange(dof)[:, None]
q, p = np.sin(2 * np.pi * s + phase), np.cos(2 * np.pi * s + phase)
k = np.arange(samples // 2 + 1)
k[-1] *= samples % 2  # the Nyquist mode of an even number stays out


def loop_integral():
    q_modes, p_modes = np.fft.rfft(q, axis=1), np.fft.rfft(p, axis=1)
    terms = k * (p_modes.imag * q_modes.real - p_modes.real * q_modes.imag)
    return 4 * np.pi / samples**2 * terms.sum()


times = []
for _ in range(7):
    start = time.perf_counter_ns()
    value = loop_integral()
    times.append(time.perf_counter_ns() - start)
assert abs(value / (np.pi * dof) - 1) < 1e-12, value
print(sorted(times)[len(times) // 2])
