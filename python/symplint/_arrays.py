"""Arrays of numbers from whatever holds some."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import InputError

Array = npt.NDArray[np.float64]


def numbers(value: Any, name: str) -> Array:
    """An array in double precision, in native byte order and aligned; a new one where `value` is of another kind.

    Raises
    ------
    TypeError
        If it does not hold real numbers.
    ValueError
        If numbers of it are masked.
    """
    array = _as_numpy(value, name)
    if isinstance(array, np.ma.MaskedArray):
        if np.ma.is_masked(array):
            raise ValueError(f"{name} has masked values; fill them with numbers")
        array = array.data
    if array.dtype.kind not in "fiub" and not _is_small_float(array.dtype):
        raise TypeError(f"{name} is of type {array.dtype}, and should hold real numbers")
    return np.require(np.asarray(array), dtype=np.float64, requirements="A")


def _as_numpy(value: Any, name: str) -> np.ndarray[Any, Any]:
    """An array of numpy from one of any library."""
    if isinstance(value, np.ndarray):
        return value
    if hasattr(value, "requires_grad"):
        value = _plain_tensor(value)
    if hasattr(value, "__dlpack__") and not hasattr(value, "__array__"):
        return np.from_dlpack(_on_cpu(value))
    try:
        return np.asarray(value)
    except TypeError:
        # Arrays of torch and CuPy on a GPU refuse to become arrays of numpy unasked.
        on_cpu = _on_cpu(value)
        if on_cpu is value:
            raise
        return np.asarray(on_cpu)
    except ValueError as error:
        raise ValueError(f"{name} is not an array of numbers: {error}") from None


def _plain_tensor(tensor: Any) -> Any:
    """A tensor of torch that may become an array of numpy: without derivatives and pending signs, and of a type that numpy has."""
    for method in ("detach", "resolve_conj", "resolve_neg"):
        if callable(plain := getattr(tensor, method, None)):
            tensor = plain()
    return tensor.float() if str(tensor.dtype) == "torch.bfloat16" else tensor


def _is_small_float(dtype: np.dtype[Any]) -> bool:
    """Whether it is bfloat16 or float8 as JAX has them, which numpy does not count as numbers."""
    return dtype.kind == "V" and dtype.names is None and dtype.name.startswith(("bfloat", "float"))


def _on_cpu(value: Any) -> Any:
    """The array in the memory of the host, where its library says how."""
    for method in ("cpu", "get"):
        if callable(copy := getattr(value, method, None)):
            return copy()
    return value


def is_single(value: Any) -> bool:
    """Whether an array is of single precision, or of less."""
    dtype = getattr(value, "dtype", None)
    return str(dtype).rsplit(".", 1)[-1] in ("float32", "float16", "bfloat16")


def vector(value: Any, name: str, length: int | None = None) -> Array:
    """A row of finite or other numbers; a single number makes `length` of them, one without a length.

    Raises
    ------
    InputError
        If it is not a row of numbers, or one of another length.
    """
    try:
        array = numbers(value, name)
    except (TypeError, ValueError) as error:
        raise InputError(str(error)) from None
    if array.ndim == 0:
        return np.full(1 if length is None else length, array)
    if array.ndim != 1:
        raise InputError(f"{name} has the shape {array.shape}; give one number for each degree of freedom, as {name}.ravel() does")
    if length is not None and array.size != length:
        raise InputError(
            f"{name} has {array.size} values for {length} degrees of freedom; give one for each, or a single number"
        )
    return array


def whole(value: Any, name: str, least: int) -> int:
    """A whole number that is not below `least`.

    Raises
    ------
    InputError
        If it is something else.
    """
    try:
        number = operator.index(value)
    except TypeError:
        number = None
    if number is None or not least <= number < 2**63:
        raise InputError(f"{name} is {value!r}; give a whole number, {least} or more")
    return number


def coordinates(dof: int, period: Any, momentum_period: Any, weight: Any) -> dict[str, list[float] | None]:
    """What the coordinates mean, as the native module takes it.

    Raises
    ------
    InputError
        If there is not one number for each degree of freedom.
    """
    stated = {"period": period, "momentum_period": momentum_period, "weight": weight}
    return {name: None if value is None else vector(value, name, dof).tolist() for name, value in stated.items()}


def cutoffs(value: Any) -> tuple[float, float]:
    """λ_q and λ_p of the finite-difference rule.

    Raises
    ------
    InputError
        If it is not a positive number or a pair of them.
    """
    pair: tuple[Any, Any] = value if isinstance(value, tuple) and len(value) == 2 else (value, value)
    try:
        found = float(pair[0]), float(pair[1])
    except (TypeError, ValueError):
        found = (0.0, 0.0)
    if not (found[0] > 0.0 and found[1] > 0.0):
        raise InputError(f"cutoff is {value!r}; give a positive number, or a pair of them for q and p")
    return found


def samples(value: Any, name: str) -> Array:
    """Samples of a loop: one row for each, one column for each degree of freedom.

    Raises
    ------
    InputError
        If it is not an array of numbers with one or two axes.
    """
    try:
        array = numbers(value, name)
    except (TypeError, ValueError) as error:
        raise InputError(str(error)) from None
    if array.ndim == 1:
        array = array.reshape(-1, 1)
    if array.ndim != 2 or array.shape[1] == 0:
        raise InputError(
            f"{name} has the shape {array.shape}; give one row for each sample and one column for each degree of freedom"
        )
    return array
