"""Arrays that a step gets, and what it may return."""

import gc

import numpy as np
import pytest
import symplint

CENTRE = ([1.0, 0.3], [0.5, -0.2])
SIZES = {"step_sizes": [0.5, 0.25, 0.125]}


def step(q, p, h):
    p = p - h * np.sin(q + 0.5 * q[:, ::-1])
    return q + h * p, p


def kick_and_drift(q, p, h):
    """One that is symplectic: the force is the gradient of a potential."""
    p = p - h * np.sin(q.sum(axis=1, keepdims=True)) * np.ones(2)
    return q + h * p, p


def points(step, **arguments):
    return symplint.check(step, *CENTRE, **(SIZES | arguments)).points


def same(a, b):
    return all(np.array_equal(a[name], b[name], equal_nan=a[name].dtype.kind == "f") for name in a.dtype.names)


@pytest.fixture(scope="module")
def reference():
    found = points(kick_and_drift)
    assert found["defect"].max() < 1e-13
    return found


def in_place(q, p, h):
    new_q, new_p = kick_and_drift(q, p, h)
    q[...] = new_q
    p[...] = new_p


def in_place_returned(q, p, h):
    in_place(q, p, h)
    return q, p


def momentum_in_place(q, p, h):
    new_q, p[...] = kick_and_drift(q, p, h)
    return new_q, p


def as_lists(q, p, h):
    q, p = kick_and_drift(q, p, h)
    return [q.tolist(), p.tolist()]


def as_one_array(q, p, h):
    return np.array(kick_and_drift(q, p, h))


def in_c_order(q, p, h):
    return tuple(np.ascontiguousarray(x) for x in kick_and_drift(q, p, h))


def in_fortran_order(q, p, h):
    return tuple(np.asfortranarray(x) for x in kick_and_drift(q, p, h))


def reversed_in_memory(q, p, h):
    return tuple(np.ascontiguousarray(x[::-1, ::-1])[::-1, ::-1] for x in kick_and_drift(q, p, h))


def read_only(q, p, h):
    q, p = kick_and_drift(q, p, h)
    q.flags.writeable = p.flags.writeable = False
    return q, p


def unaligned(q, p, h):
    def copy(x):
        memory = np.zeros(8 * x.size + 1, dtype=np.uint8)[1:].view(np.float64).reshape(x.shape)
        memory[...] = x
        assert not memory.flags.aligned
        return memory

    return tuple(copy(x) for x in kick_and_drift(q, p, h))


def of_other_byte_order(q, p, h):
    return tuple(x.astype(">f8") for x in kick_and_drift(q, p, h))


def masked_nowhere(q, p, h):
    return tuple(np.ma.masked_invalid(x) for x in kick_and_drift(q, p, h))


def of_other_library(q, p, h):
    return tuple(Exported(x) for x in kick_and_drift(q, p, h))


class Exported:
    """An array of another library, which exports it by DLPack alone."""

    def __init__(self, array):
        self.array = np.ascontiguousarray(array)

    def __dlpack__(self, **arguments):
        return self.array.__dlpack__(**arguments)

    def __dlpack_device__(self):
        return self.array.__dlpack_device__()


class Interface:
    """An array of another library, which has the array interface alone."""

    def __init__(self, array):
        self.array = np.ascontiguousarray(array)
        self.__array_interface__ = self.array.__array_interface__


def by_array_interface(q, p, h):
    return tuple(Interface(x) for x in kick_and_drift(q, p, h))


class OnDevice:
    """An array on a GPU, as CuPy has them: it refuses to become an array of numpy unasked."""

    def __init__(self, array):
        self.array = array

    def __array__(self, *arguments, **keywords):
        raise TypeError("implicit conversion is not allowed")

    def get(self):
        return self.array.copy()


def on_a_device(q, p, h):
    return tuple(OnDevice(x) for x in kick_and_drift(q, p, h))


@pytest.mark.parametrize(
    "form",
    [
        in_place, in_place_returned, momentum_in_place, as_lists, as_one_array, in_c_order, in_fortran_order,
        reversed_in_memory, read_only, unaligned, of_other_byte_order, masked_nowhere, of_other_library,
        by_array_interface, on_a_device,
    ],
)  # fmt: skip
def test_results_in_every_form_are_the_same_to_the_last_bit(form, reference):
    assert same(points(form), reference)


def test_one_state_at_a_time_is_the_same(reference):
    def of_state(q, p, h):
        assert q.shape == p.shape == (2,)
        q, p = kick_and_drift(q[np.newaxis], p[np.newaxis], h)
        return q[0], p[0]

    def of_state_in_place(q, p, h):
        q[:], p[:] = of_state(q, p, h)

    def of_state_as_lists(q, p, h):
        q, p = of_state(q, p, h)
        return q.tolist(), p.tolist()

    for form in (of_state, of_state_in_place, of_state_as_lists):
        assert same(points(form, per_sample=True), reference)


def test_numbers_for_one_degree_of_freedom():
    def of_state(q, p, h):
        p = p[0] - h * np.sin(q[0])
        return q[0] + h * p, p

    assert symplint.check(of_state, 1.0, 0.5, per_sample=True, **SIZES).kind == "symplectic"

    def of_row(q, p, h):
        q, p = q[:, 0], p[:, 0]
        p = p - h * np.sin(q)
        return q + h * p, p

    assert symplint.check(of_row, 1.0, 0.5, **SIZES).kind == "symplectic"


def test_a_factory_is_called_once_for_each_step_size(reference):
    made = []

    def make(h):
        made.append(h)
        return lambda q, p: kick_and_drift(q, p, h)

    assert same(points(make, make=True), reference)
    assert sorted(set(made)) == sorted(made) and set(made) >= {0.5, 0.25, 0.125}


def test_arrays_are_lent_by_strides_and_writable():
    seen = []

    def look(q, p, h):
        seen.append((q.shape, q.strides, q.flags.writeable, q.flags.aligned, p.shape))
        assert q.flags.f_contiguous and p.flags.f_contiguous
        assert type(q) is np.ndarray and q.dtype == p.dtype == np.float64
        assert not np.shares_memory(q, p)
        return kick_and_drift(q, p, h)

    points(look)
    wide = [entry for entry in seen if entry[0][0] > 1]
    assert wide
    for (samples, dof), strides, writeable, aligned, shape in wide:
        assert dof == 2 and shape == (samples, dof)
        # Samples are neighbours in memory, and nothing lies between the rows of two degrees of freedom.
        assert strides == (8, 8 * samples)
        assert writeable and aligned


def test_views_of_the_arrays_as_results():
    # A rotation by a quarter of a turn, exact in every step: the arrays themselves, swapped.
    def swapped(q, p, h):
        np.negative(q, out=q)
        return p, q

    report = symplint.check(swapped, *CENTRE, **SIZES)
    assert report.points["defect"].max() < 1e-15

    # Degrees of freedom exchanged: views that overlap with where results are expected.
    def exchanged(q, p, h):
        return q[:, ::-1], p[:, ::-1]

    assert symplint.check(exchanged, *CENTRE, **SIZES).points["defect"].max() < 1e-15

    # The first column for both degrees of freedom: of the areas π and π/2, the first is counted twice.
    def broadcast(q, p, h):
        return np.broadcast_to(q[:, :1], q.shape), np.broadcast_to(p[:, :1], p.shape)

    report = symplint.check(broadcast, *CENTRE, radius=(1.0, [1.0, 0.5]), **SIZES)
    assert report.kind != "symplectic"
    assert np.allclose(report.points["signed_defect"][report.points["loop"] == 0], 1 / 3)


def test_one_array_for_both():
    # q and p become the same: ∮ p dq vanishes.
    def both(q, p, h):
        return p, p

    report = symplint.check(both, *CENTRE, **SIZES, loops=1, jacobian=False)
    assert report.kind == "not-symplectic"
    assert abs(report.points["final"]).max() < 1e-14


def test_arrays_that_are_kept_stay_as_they_are():
    kept = []

    def keeps(q, p, h):
        # Views of views, and a memory view: everything that refers to the same memory.
        kept.append((q[:, 0], memoryview(p[:, 1]), q.copy(), p.copy()))
        return kick_and_drift(q, p, h)

    report = symplint.check(keeps, *CENTRE, **SIZES)
    assert report.kind == "symplectic"
    gc.collect()
    # Memory that is used again would be overwritten by this.
    symplint.check(kick_and_drift, *CENTRE, **SIZES)
    assert len(kept) > 10
    for q, p, copy_q, copy_p in kept:
        assert np.array_equal(q, copy_q[:, 0]) and np.array_equal(np.asarray(p), copy_p[:, 1])
        q[:] = 0.0


def test_writing_to_kept_arrays_changes_nothing(reference):
    kept = []

    def writes_later(q, p, h):
        for old in kept:
            old[...] = np.nan
        kept.append(q)
        kept.append(p)
        result = kick_and_drift(q, p, h)
        kept.extend(result)
        return result

    assert same(points(writes_later), reference)


def test_lent_arrays_cannot_be_resized():
    def resizes(q, p, h):
        for array in (q, p, q.base):
            with pytest.raises((ValueError, AttributeError)):
                array.resize((1, 1), refcheck=False)
        return kick_and_drift(q, p, h)

    points(resizes)


def test_arrays_of_one_call_are_distinct_for_each_sample():
    kept = []

    def keeps(q, p, h):
        kept.append((q, q.copy()))
        q, p = kick_and_drift(q[np.newaxis], p[np.newaxis], h)
        return q[0], p[0]

    symplint.check(keeps, *CENTRE, **SIZES, per_sample=True, budget=2000)
    assert all(np.array_equal(q, copy) for q, copy in kept)


@pytest.mark.parametrize(
    ("result", "cause", "words"),
    [
        (lambda q, p: q, TypeError, "return q and p"),
        (lambda q, p: (q, p, p), TypeError, "length 3"),
        (lambda q, p: 3.0, TypeError, "float"),
        (lambda q, p: (q[:-1], p), ValueError, "shape"),
        (lambda q, p: (q, p[:, :1]), ValueError, "shape"),
        (lambda q, p: (q.T, p.T), ValueError, "shape"),
        (lambda q, p: (q[:, 0], p[:, 0]), ValueError, "shape"),
        (lambda q, p: (q * 1j, p), TypeError, "complex128, and should hold real numbers"),
        (lambda q, p: (q.astype(str), p), TypeError, "real numbers"),
        (lambda q, p: (np.ma.masked_less(q, 1e9), p), ValueError, "masked"),
        (lambda q, p: ({}, p), TypeError, "real numbers"),
        (lambda q, p: (q, None), TypeError, "real numbers"),
    ],
)
def test_wrong_results_are_named(result, cause, words):
    def wrong(q, p, h):
        q, p = kick_and_drift(q, p, h)
        return result(q, p) if q.shape[0] > 1 else (q, p)

    with pytest.raises(symplint.StepError, match=words) as caught:
        points(wrong)
    assert isinstance(caught.value.__cause__, cause)
    assert caught.value.h == 0.5
