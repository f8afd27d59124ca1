"""The native part of symplint."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, TypedDict, final, type_check_only

import numpy as np
import numpy.typing as npt

from ._errors import StepError

_Array = npt.NDArray[np.float64]
_Vector = _Array | Sequence[float]

__version__: str

@final
class Memory:
    """Numbers that numpy arrays may refer to, as long as one of them exists."""

@final
class Loop:
    """A loop of the library."""

    @staticmethod
    def circle(
        q0: _Vector,
        p0: _Vector,
        radii_q: _Vector,
        radii_p: _Vector,
        dofs: Sequence[int] | None,
        phases: tuple[str, int],
    ) -> Loop: ...
    @staticmethod
    def fourier(q0: _Vector, p0: _Vector, radii_q: _Vector, radii_p: _Vector, seed: int) -> Loop: ...
    @staticmethod
    def sampled(q: _Array, p: _Array, stated: Mapping[str, _Vector | None]) -> Loop: ...
    @property
    def dof(self) -> int: ...
    def sample(self, samples: int) -> tuple[_Array, _Array]: ...
    def at(self, s: _Vector) -> tuple[_Array, _Array]: ...

@final
class System:
    """A system with an initial state."""

    def __new__(cls, name: str, keys: Mapping[str, Any]) -> System: ...
    @property
    def name(self) -> str: ...
    @property
    def dof(self) -> int: ...
    @property
    def q0(self) -> _Array: ...
    @property
    def p0(self) -> _Array: ...
    def config(self) -> str: ...

@final
class SharedJournal:
    """The journal of a check whose states are advanced elsewhere."""

    def find(self, h: float, q: _Array, p: _Array) -> tuple[object, tuple[_Array, _Array] | None]: ...
    def note(self, call: object, q: _Array, p: _Array) -> None: ...

def advance(
    function: Callable[..., Any],
    h: float | None,
    reset: Callable[[], object] | None,
    per_sample: bool,
    single: bool,
    q: _Array,
    p: _Array,
) -> tuple[tuple[_Array, _Array] | None, tuple[int, Exception] | None]: ...
@final
class Integrator:
    """One step of a method for a system."""

    def __new__(cls, name: str | None, system: System, keys: Mapping[str, Any]) -> Integrator: ...
    @property
    def name(self) -> str: ...
    @property
    def system(self) -> System: ...
    @property
    def dof(self) -> int: ...
    def config(self) -> str: ...
    def advance(self, q: _Array, p: _Array, h: float) -> tuple[_Array, _Array]: ...

@final
class Report:
    """A report: the verdict, all points, and where they come from."""

    @property
    def kind(self) -> str: ...
    @property
    def digits(self) -> float | None: ...
    @property
    def order(self) -> float | None: ...
    @property
    def headline(self) -> str: ...
    @property
    def summary(self) -> str: ...
    @property
    def sentences(self) -> list[str]: ...
    @property
    def advice(self) -> list[str]: ...
    @property
    def evaluations(self) -> int: ...
    @property
    def title(self) -> str: ...
    @staticmethod
    def from_json(text: str, title: str) -> Report: ...
    def to_json(self) -> str: ...
    def text(self, all: bool) -> str: ...
    def reasons(self) -> str: ...
    def fragment(self) -> str: ...
    def to_html(self) -> str: ...
    def save(self, folder: str | PathLike[str]) -> None: ...

@type_check_only
class _Catalogue(TypedDict):
    systems: list[tuple[str, str, list[tuple[str, str | None, str, str, list[str]]]]]
    integrators: list[tuple[str, str, str, list[str], bool]]
    aliases: list[tuple[str, str, list[str]]]

def catalogue() -> _Catalogue: ...
def check(
    subject: Mapping[str, Any],
    settings: Mapping[str, Any],
    title: str,
    config: str,
    progress: Callable[[int, int, float | None], object] | None = None,
    journal: tuple[str, str] | None = None,
) -> tuple[Report, StepError | None]: ...
def program(arguments: Sequence[str]) -> int: ...
def settings() -> list[str]: ...
def check_field(
    subject: Mapping[str, Any], settings: Mapping[str, Any], journal: tuple[str, str] | None = None
) -> str: ...
def image(
    subject: Mapping[str, Any], h: float, samples: int, repeat: int
) -> tuple[tuple[_Array, _Array], tuple[_Array, _Array]]: ...
def measure(
    before: tuple[_Array, _Array, bool],
    after: Sequence[tuple[_Array, _Array, bool]],
    h: Sequence[float | None],
    stated: Mapping[str, _Vector | None],
    title: str,
    config: str,
) -> Report: ...
def loop_integral(
    q: _Array, p: _Array, rule_name: str, cutoffs: tuple[float, float], stated: Mapping[str, _Vector | None]
) -> tuple[float, float | None, float, list[float]]: ...
def advance_seconds(
    subject: Mapping[str, Any], h: float, samples: int, repetitions: int
) -> list[float]: ...
