"""Tests an installed wheel: five lines of Python, the program, a figure of the paper. It needs no other package."""

import shutil
import subprocess
import sys
import tempfile

import numpy as np
import symplint


def step(q, p, h):
    p = p - h * np.sin(q)
    return q + h * p, p


assert symplint.check(step, 1.0, 0.5).is_symplectic
assert symplint.check(symplint.integrators.rk2(symplint.systems.pendulum())).is_symplectic is False

program = shutil.which("symplint")
assert program is not None, "the wheel has no program"
with tempfile.TemporaryDirectory() as folder:
    for status, *arguments in (
        (0, "check", "pendulum", "--quiet"),
        (1, "check", "pendulum", "--set", "integrator.name=rk2", "--quiet"),
        (0, "reproduce", "fig1", "--out", folder, "--quiet"),
    ):
        done = subprocess.run([program, *arguments], check=False)
        assert done.returncode == status, f"symplint {' '.join(arguments)} ends with {done.returncode}, not {status}"
print(f"symplint {symplint.__version__} works with Python {sys.version.split()[0]}")
