"""Batches of a step: few sizes, and rows that are copies."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import symplint

#: The arguments of a step.
ROWS = {4**k for k in range(8)}
CENTRE = ([1.0, 0.3], [0.5, -0.2])


def verlet(q, p, h):
    p = p - 0.5 * h * np.sin(q)
    q = q + h * p
    return q, p - 0.5 * h * np.sin(q)


class Counted:
    """A step that counts its calls and rows by their number."""

    def __init__(self, step, kicks=0.0):
        self.step, self.kicks, self.sizes, self.added = step, kicks, {}, 0

    def __call__(self, q, p, h):
        assert q.shape == p.shape
        self.sizes[len(q)] = self.sizes.get(len(q), 0) + 1
        # Rows that repeat the last state at the end.
        same = (q == q[-1]).all(1) & (p == p[-1]).all(1)
        self.added += len(q) - 1 - (np.flatnonzero(~same)[-1] + 1 if not same.all() else 0)
        q, p = self.step(q, p, h)
        return q, p + h * self.kicks * (q > 0.4)


@pytest.mark.parametrize("kicks", [0.0, 0.1])
@pytest.mark.parametrize("dtype", [None, "float32"])
def test_batches_have_few_sizes_and_copies_are_no_evaluations(kicks, dtype):
    step = Counted(verlet, kicks)
    report = symplint.check(step, *CENTRE, dtype=dtype)
    assert set(step.sizes) <= ROWS
    made = report.to_dict()["evidence"]["evaluations"]["made"]
    rows = sum(size * count for size, count in step.sizes.items())
    # A state that is asked for twice looks like a copy.
    assert made <= rows <= made + step.added
    assert rows < 2 * made


def test_the_result_is_the_same_without_copies():
    batches = Counted(verlet)
    report = symplint.check(batches, *CENTRE, budget=2000)
    one = symplint.check(verlet, *CENTRE, budget=2000, per_sample=True)
    assert batches.added > 0
    assert (report.points == one.points).all() or report.to_dict()["evidence"] == one.to_dict()["evidence"]

    def in_place(q, p, h):
        q[:], p[:] = verlet(q, p, h)

    assert symplint.check(in_place, *CENTRE, budget=2000).to_dict()["evidence"] == report.to_dict()["evidence"]


def test_one_state_at_a_time_has_no_copies():
    calls = []

    def step(q, p, h):
        assert q.shape == (2,)
        calls.append(h)
        return verlet(q, p, h)

    report = symplint.check(step, *CENTRE, budget=1000, per_sample=True)
    assert len(calls) == report.to_dict()["evidence"]["evaluations"]["made"]


def test_batches_of_workers_have_the_same_sizes():
    step = Counted(verlet)
    with ThreadPoolExecutor(1) as executor:
        symplint.check(step, *CENTRE, budget=2000, executor=executor)
    assert set(step.sizes) <= ROWS


@pytest.mark.parametrize(("dof", "most"), [(1, 4096), (100, 256), (3000, 4), (40000, 1)])
def test_batches_of_many_degrees_of_freedom_are_short(dof, most):
    step = Counted(verlet)
    symplint.check(step, np.linspace(-1, 1, dof), np.zeros(dof), budget=3000, loops=1, jacobian=False, step_sizes=[0.5])
    assert max(step.sizes) <= most


def test_the_failing_state_of_a_padded_batch_is_named():
    def step(q, p, h):
        if (q > 1.9).any():
            raise ValueError("too far")
        return verlet(q, p, h)

    with pytest.raises(symplint.StepError, match="too far") as caught:
        symplint.check(step, 1.0, 0.5, step_sizes=[0.5], samples=100)
    first = int(np.ceil(100 * np.arcsin(0.9) / (2 * np.pi)))
    assert caught.value.sample == first


def test_a_step_that_chooses_substeps_for_a_batch_is_told_of_per_sample():
    def adaptive(q, p, h):
        count = int(np.ceil(10 * np.abs(p).max()))
        for _ in range(count):
            q, p = verlet(q, p, h / count)
        return q, p

    with pytest.raises(symplint.StepError, match="per_sample=True"):
        symplint.check(adaptive, 1.0, 0.5)
    assert symplint.check(adaptive, 1.0, 0.5, per_sample=True, budget=2000).kind != "symplectic"
