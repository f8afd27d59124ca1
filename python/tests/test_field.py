"""Forces and vector fields, called through Python."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
import json
import math
import pickle

import numpy as np
import pytest
import symplint


def waves(q, curl=0.0):
    """−∇ Σ sin(k·q), and a rotation in the plane of the first two coordinates."""
    n = q.shape[-1]
    k = np.cos(np.arange(3 * n).reshape(3, n))
    force = -np.cos(q @ k.T) @ k
    force[..., 0] -= curl * q[..., 1]
    force[..., 1] += curl * q[..., 0]
    return force


def one(q):
    """The same of one state."""
    assert q.ndim == 1
    return waves(q[None, :])[0]


def cell_list_pairs(q, cutoff):
    """All pairs of atoms that are nearer than the cut-off, by cells of that size."""
    cells = np.floor((q - q.min(axis=0)) / cutoff).astype(np.int64) + 1
    shape = cells.max(axis=0) + 2
    flat = np.ravel_multi_index(cells.T, shape)
    order = np.argsort(flat, kind="stable")
    first = np.searchsorted(flat[order], np.arange(shape.prod() + 1))
    offsets = np.array(np.meshgrid(*[[-1, 0, 1]] * 3, indexing="ij")).reshape(3, -1).T
    found = []
    for offset in offsets @ [shape[1] * shape[2], shape[2], 1]:
        neighbour = flat + offset
        counts = first[neighbour + 1] - first[neighbour]
        i = np.repeat(np.arange(len(q)), counts)
        steps = np.arange(len(i)) - np.repeat(np.cumsum(counts) - counts, counts)
        j = order[first[neighbour][i] + steps]
        near = (i < j) & (((q[i] - q[j]) ** 2).sum(axis=1) < cutoff**2)
        found.append((i[near], j[near]))
    return tuple(np.concatenate(of) for of in zip(*found, strict=True))


def lennard_jones(atoms):
    """Atoms near a cubic lattice, and their force with a list of neighbours."""
    side = int(np.ceil(atoms ** (1 / 3)))
    q0 = 1.2 * np.argwhere(np.ones((side,) * 3))[:atoms].astype(float)
    q0 += np.random.default_rng(0).uniform(-0.03, 0.03, q0.shape)
    i, j = cell_list_pairs(q0, 1.5)

    def force(q):
        d = q[i] - q[j]
        square = np.einsum("ij,ij->i", d, d)
        sixth = square**-3
        d *= (24.0 * (2.0 * sixth * sixth - sixth) / square)[:, None]
        return np.stack([np.bincount(i, x, atoms) - np.bincount(j, x, atoms) for x in d.T], axis=1)

    return q0, force


def test_cell_lists_find_all_pairs():
    q0, _ = lennard_jones(200)
    i, j = cell_list_pairs(q0, 1.5)
    distance = np.linalg.norm(q0[:, None] - q0[None], axis=-1)
    assert sorted(zip(i, j, strict=True)) == list(zip(*np.nonzero(np.triu(distance < 1.5, 1)), strict=True))


def test_a_hundred_thousand_atoms_take_as_many_evaluations_as_ten():
    made = {}
    for atoms in (10, 100_000):
        q0, force = lennard_jones(atoms)
        report = symplint.check_force(force, q0, per_sample=True, radius=0.005, loops=1, budget=150)
        assert report.kind == "gradient" and report.digits > 10, report
        made[atoms] = report.evaluations
    assert made[100_000] <= 2 * made[10]


def test_small_curls_are_found():
    q0 = [0.3, -0.4, 0.5, 1.1]
    report = symplint.check_force(waves, q0)
    assert report.kind == "gradient" and report.holds is True and report.digits > 12
    for curl in (1e-12, 1e-6, 1.0):
        report = symplint.check_force(waves, q0, args=(curl,))
        assert report.kind == "not-a-gradient" and report.holds is False
        assert report.curl.value > 0.1 * curl
        assert (report.worst.first, report.worst.second) == ("q[0]", "q[1]")
        assert abs(report.worst.curl - 2 * curl) <= report.worst.error


def test_batches_states_executors_and_shapes_agree():
    q0 = np.array([0.3, -0.4, 0.5, 1.1, 0.2, 0.9])
    batches = symplint.check_force(waves, q0)
    states = symplint.check_force(one, q0, per_sample=True)
    assert states.kind == batches.kind == "gradient"

    def shaped(q):
        assert q.shape[1:] == (2, 3)
        return waves(q.reshape(len(q), 6)).reshape(q.shape)

    assert symplint.check_force(shaped, q0.reshape(2, 3)).to_dict()["evidence"] == batches.to_dict()["evidence"]
    with ThreadPoolExecutor(2) as two, ThreadPoolExecutor(3) as three:
        found = [symplint.check_force(one, q0, per_sample=True, workers=pool).to_json() for pool in (two, three)]
    assert found[0] == found[1] == states.to_json()
    with ProcessPoolExecutor(2) as pool:
        assert symplint.check_force(waves, q0, executor=pool).kind == "gradient"
    assert symplint.check_force(one, q0, per_sample=True, workers=2).to_json() == states.to_json()
    with pytest.raises(symplint.InputError, match="one argument"):
        symplint.check_force(waves, q0, budget=1000, maxfev=1000)
    other = symplint.check_force(waves, q0, rng=np.random.default_rng(7), maxfev=1000)
    assert other.kind == "gradient" and other.to_json() != batches.to_json()


def test_results_may_be_returned_in_the_argument_and_in_other_types():
    def in_place(q):
        np.negative(q, out=q)
        return q

    assert symplint.check_force(in_place, [0.3, -0.4]).kind == "gradient"
    assert symplint.check_force(lambda q: (-q).tolist(), [0.3, -0.4]).kind == "gradient"
    assert symplint.check_force(lambda q: -(q**3), 0.7).kind == "gradient"


def test_single_precision_is_no_curl():
    def single(q):
        assert q.dtype == np.float32
        return waves(q).astype(np.float32)

    report = symplint.check_force(single, [0.3, -0.4, 0.5, 1.1], dtype="float32")
    assert report.kind == "gradient" and 3 <= report.digits < 8
    report = symplint.check_force(lambda q: waves(q, 1e-2).astype(np.float32), [0.3, -0.4, 0.5, 1.1], dtype="float32")
    assert report.kind == "not-a-gradient"


def test_random_forces_are_undecided():
    numbers = np.random.default_rng(1)

    def dropout(q):
        return waves(q) * (numbers.uniform(size=q.shape) > 0.1)

    report = symplint.check_force(dropout, [0.3, -0.4, 0.5, 1.1])
    assert report.kind == "undecided" and report.holds is None
    assert "evaluated again" in report.summary


def test_forces_that_do_not_change_are_gradients():
    for constant in (0.0, 0.3):
        report = symplint.check_force(lambda q, c=constant: np.full_like(q, c), [0.3, -0.4])
        assert report.kind == "gradient" and report.digits is None and report.curl is None


def test_periods_matter():
    def tilted(q):
        return 0.1 - np.sin(q)

    assert symplint.check_force(tilted, 1.0).kind == "gradient"
    report = symplint.check_force(tilted, 1.0, period=2 * np.pi)
    assert report.kind == "not-a-gradient"
    around = report.loops[report.loops["kind"] == "winding"]
    assert abs(around["integral"][0] - 0.2 * np.pi) < 1e-12
    with pytest.raises(symplint.InputError, match="not a period of the force"):
        symplint.check_force(tilted, 1.0, period=6.0)


def test_fields():
    mass = np.array([1.0, 3.0])

    def velocities(q, v):
        pull = np.sin(q[:, ::-1] - q)
        return v, (pull - q**3) / mass

    q0, p0 = [1.0, 0.3], [0.5, -0.2]
    assert symplint.check_field(velocities, q0, p0).kind == "not-hamiltonian"
    assert symplint.check_field(velocities, q0, p0, weight=mass).kind == "hamiltonian"
    assert symplint.check_field(velocities, q0, p0, weight=mass, radius=(0.1, [0.2, 0.3])).kind == "hamiltonian"
    report = symplint.check_field(lambda q, p: (p, -np.sin(q) - 0.1 * p), q0, p0)
    assert report.kind == "not-hamiltonian"
    assert abs(report.damping[0] - 0.1) <= report.damping[1]
    assert {report.worst.first[0], report.worst.second[0]} == {"q", "p"}


def test_reports_are_like_other_reports():
    report = symplint.check_force(waves, [0.3, -0.4], args=(0.1,))
    with pytest.raises(TypeError, match="report.holds"):
        bool(report)
    assert json.loads(report.to_json()) == report.to_dict()
    assert report.to_dict()["schema"] == "symplint/field/1"
    assert pickle.loads(pickle.dumps(report)).to_json() == report.to_json()
    assert "NOT A GRADIENT" in str(report) and repr(report) == "<symplint.FieldReport: not-a-gradient>"
    assert report._repr_html_().startswith("<pre>")
    assert report.loops["samples"].min() >= 16 and report.evaluations > 100
    assert report.advice and report.sentences


def test_failures_say_what_and_where():
    def fails(q):
        raise RuntimeError("atoms overlap")

    with pytest.raises(symplint.StepError, match="the force failed.*atoms overlap") as caught:
        symplint.check_force(fails, [1.0, 2.0], radius=0.1)
    assert isinstance(caught.value.__cause__, RuntimeError)
    with pytest.raises(symplint.StepError, match=r"F\[1\] is nan|F\[1\] is NaN"):
        symplint.check_force(lambda q: q * [1.0, np.nan], [1.0, 2.0], radius=0.1)
    with pytest.raises(symplint.StepError, match=r"f_p\[0\] is NaN"):
        symplint.check_field(lambda q, p: (p, q * np.nan), [1.0, 2.0], [1.0, 2.0], radius=0.1)
    with pytest.raises(symplint.StepError, match="return the same shape"):
        symplint.check_force(lambda q: q[:, :1], [1.0, 2.0])
    with pytest.raises(symplint.StepError, match="returned None"):
        symplint.check_force(lambda q: None, [1.0, 2.0])
    with pytest.raises(symplint.StepError, match=r"IndexError: .*; force gets arrays of shape \(samples, dof\).*per_sample=True"):
        symplint.check_force(lambda q: np.array([-q[0], -q[1]]), [1.0, 2.0])
    with pytest.raises(symplint.StepError, match=r"broadcast.*; field gets arrays of shape \(samples, dof\).*per_sample=True"):
        symplint.check_field(lambda q, p: (p, -q * np.ones(3)), [1.0, 2.0], [1.0, 2.0], radius=0.1)
    with pytest.raises(symplint.StepError, match=r"; q is an array of shape \(dof,\): take q\[0\], or write the force"):
        symplint.check_force(lambda q: [-math.sin(q)] * 2, [1.0, 2.0], per_sample=True)
    with pytest.raises(symplint.StepError, match="return two arrays"):
        symplint.check_field(lambda q, p: q, [1.0, 2.0], [1.0, 2.0])
    for arguments in (
        {"radius": "large"},
        {"radius": -1.0},
        {"radius": [1.0, 2.0, 3.0]},
        {"radius": 0.0},
        {"loops": 0},
        {"budget": 99},
        {"period": [1.0, 2.0, 3.0]},
        {"dtype": "float16"},
    ):
        with pytest.raises(symplint.InputError):
            symplint.check_force(waves, [1.0, 2.0], **arguments)
    for q0 in ([], [np.nan, 1.0], "positions", [1.0 + 2j]):
        with pytest.raises(symplint.InputError):
            symplint.check_force(waves, q0)
    with pytest.raises(symplint.InputError, match="one of both"):
        symplint.check_field(lambda q, p: (p, q), [1.0, 2.0], [1.0])
    with pytest.raises(symplint.InputError, match="give a function"):
        symplint.check_force(3.0, [1.0])
