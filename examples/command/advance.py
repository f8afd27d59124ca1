"""One step of a pendulum by the leapfrog method, for every row of a file: advance.py BEFORE AFTER H.

BEFORE and AFTER are .npz files with arrays q and p of shape (samples, degrees of freedom).
"""

import sys

import numpy as np

before, after, h = sys.argv[1], sys.argv[2], float(sys.argv[3])
with np.load(before) as states:
    q, p = states["q"], states["p"]

q = q + 0.5 * h * p
p = p - h * np.sin(q)
q = q + 0.5 * h * p

np.savez(after, q=q, p=p)
