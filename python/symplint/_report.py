"""What a check or a measurement found."""

from __future__ import annotations

import copy
import importlib
import json
import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

import numpy as np
import numpy.typing as npt

from . import _native
from ._arrays import Array, whole
from ._errors import InputError, SymplintError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Cause", "Property", "Report", "check_replaceable"]

#: Columns of `Report.points`, as in the report's JSON.
POINTS = [
    ("sweep", "U9"), ("loop", "i8"), ("step_size", "f8"), ("samples", "i8"), ("rule", "U17"),
    ("initial", "f8"), ("final", "f8"), ("signed_defect", "f8"), ("defect", "f8"),
    ("quadrature_error", "f8"), ("roundoff", "f8"), ("omitted_cells", "f8"), ("jumps", "f8"),
    ("chord", "f8"), ("closed_defect", "f8"), ("regularity", "f8"), ("evaluations", "i8"),
]  # fmt: skip

#: Columns of `Report.breaks`.
BREAKS = [
    ("loop", "i8"), ("step_size", "f8"), ("s", "f8"), ("dof", "i8"), ("jump_q", "f8"), ("jump_p", "f8"),
    ("substep", "f8"),
]  # fmt: skip

#: Files of `Report.save` that show whether symplint wrote them.
MARKED = ("config.toml", "report.json")

#: Files of `Report.save`.
SAVED = (
    *MARKED, "report.html", "points.csv",
    *(f"figures/{name}.{kind}" for name in ("step_sizes", "samples", "loop") for kind in ("svg", "pdf", "png")),
)  # fmt: skip

#: First lines of config.toml: of the program, of `check`, and of `measure`.
FIRST_LINES = ("# symplint run folder: ", "[check]", "[measure]")

States = tuple[Array, Array]


class Cause(NamedTuple):
    """The likeliest cause of a failure.

    Attributes
    ----------
    kind : str
        One word for it, such as "friction".
    text : str
        The evidence for it.
    remedy : str
        What to do about it; `Report.advice` begins with it.
    setting : str or None
        What to pass to `check`, if that makes the map symplectic: "weight = [1, 3]".
    digits : float or None
        Digits to which the map is symplectic with this setting, if that was tried.
    """

    kind: str
    text: str
    remedy: str
    setting: str | None
    digits: float | None = None


class Property(NamedTuple):
    """A property of a map.

    Attributes
    ----------
    holds : bool or None
        Whether the map has it; None if it was not tested, or the test is not precise enough.
    defect, uncertainty : float or None
        The largest deviation from the property, with its uncertainty. It is the relative change of a loop integral, the deviation
        of det DΦ from 1, or the distance between a state and the state to which the map returns it. Distances are in units of half
        the range of the loop.
    factor, factor_uncertainty : float or None
        The factor by which a step of a conformally symplectic map multiplies all areas.
    rate, rate_uncertainty : float or None
        The rate γ of uniform damping e^(−γh).
    text : str
        The property as a sentence.
    growth : str or None
        The change of the energy in many steps, if `steps` is given: "none", "bounded", "grows" or "undecided".
    order : float or None
        The k of the change of the energy in one step, if this change is proportional to h^k.
    """

    holds: bool | None
    defect: float | None
    uncertainty: float | None
    factor: float | None
    factor_uncertainty: float | None
    rate: float | None
    rate_uncertainty: float | None
    text: str
    growth: str | None = None
    order: float | None = None


class Report:
    """The verdict on a map, with the measurements behind it.

    Printing it shows the verdict, a table of your loop and the findings. A report can be pickled. The pickled report has no map, so
    `plot_loop` does not work on it.
    """

    def __init__(self, native: _native.Report, image: Callable[[float, int], tuple[States, States]]) -> None:
        self._native = native
        self._image = image
        self._dict: dict[str, Any] | None = None

    @property
    def kind(self) -> str:
        """The verdict: "symplectic", "not-symplectic", "broken-loops" or "undecided"."""
        return self._native.kind

    @property
    def is_symplectic(self) -> bool | None:
        """Whether the map is symplectic; None if the verdict is undecided."""
        return {"symplectic": True, "undecided": None}.get(self.kind, False)

    @property
    def digits(self) -> float | None:
        """Digits to which a symplectic map conserves loop integrals."""
        return self._native.digits

    @property
    def order(self) -> float | None:
        """The k of defect ~ h^k, if the defects follow a power of h."""
        return self._native.order

    @property
    def headline(self) -> str:
        """The verdict in a few words."""
        return self._native.headline

    @property
    def summary(self) -> str:
        """The reason for the verdict, as a sentence."""
        return self._native.summary

    @property
    def sentences(self) -> list[str]:
        """The other findings, as sentences."""
        return self._native.sentences

    @property
    def evidence(self) -> list[str]:
        """The same as `sentences`: the former name."""
        return self.sentences

    @property
    def cause(self) -> Cause | None:
        """The likeliest cause of a failure; None if the evidence shows no cause, or the map is symplectic.

        `kind` is one of "friction", "wall", "clipped", "chosen-step-length", "period", "force-jump", "solver-tolerance" and others,
        `text` has the evidence, `remedy` what to do, `setting` what to pass to `check`, if a setting makes the map symplectic.
        """
        found = self.to_dict()["verdict"]["cause"]
        return None if found is None else Cause(**found)

    @property
    def advice(self) -> list[str]:
        """What to do next, as sentences."""
        return self._native.advice

    @property
    def properties(self) -> dict[str, Property]:
        """The properties of the map by name: those that were tested, and those that follow from the verdict.

        "symplectic"; "conformal" (all areas change by one factor) and "volume" (det DΦ = 1), from the Jacobian in at most eight
        degrees of freedom; "reversible" (a step, reversed momenta, and a step again return states of the loop and inside it); and
        "symmetric" (a step of size -h undoes one of size h), if asked for by ``symmetric=True``; "energy" (a step of the largest size
        conserves it; its defect is in units of the range of the energy on the loop), if ``energy=`` is given. `holds` is None if a property
        was not tested, or the test is not precise enough. Maps on a manifold or in non-canonical coordinates have no "volume", and
        "reversible" only with ``reversal=``. With ``properties=False`` there is "symplectic" alone.
        """
        return {found["name"]: _property(found) for found in self.to_dict()["properties"]}

    def __bool__(self) -> NoReturn:
        """Raise: a report is neither true nor false."""
        raise TypeError(
            "a report has no truth value: test report.is_symplectic, which is True, False or None, or call symplint.assert_symplectic"
        )

    @property
    def evaluations(self) -> int:
        """Number of states that were advanced by one step."""
        return self._native.evaluations

    @property
    def points(self) -> npt.NDArray[np.void]:
        """All measured points, as a structured array. Quantities that a rule does not give are NaN.

        Its fields are those of ``points`` in the JSON: ``step_size``, ``samples``, ``initial`` and ``final`` (loop
        integrals), ``defect``, ``quadrature_error``, ``roundoff`` (relative to the initial integral) and others. ``loop``
        is 0 for your loop.
        """
        return _table(self.to_dict()["points"], POINTS)

    @property
    def breaks(self) -> npt.NDArray[np.void]:
        """The breaks of the advanced loops, as a structured array.

        Its fields are ``loop``, ``step_size``, ``s``, ``dof``, ``jump_q``, ``jump_p`` and ``substep``.
        """
        return _table(self.to_dict()["evidence"]["breaks"], BREAKS)

    def to_json(self) -> str:
        """The report as JSON, schema ``symplint/report/3``.

        Returns
        -------
        str
            Its text.
        """
        return self._native.to_json()

    def to_dict(self) -> dict[str, Any]:
        """The report as a dictionary, with the keys of the JSON.

        Returns
        -------
        dict
            The contents of the JSON.
        """
        contents = self._dict
        if contents is None:
            contents = self._dict = json.loads(self.to_json())
        return contents

    def to_dataframe(self) -> Any:
        """The measured points as a table of pandas, which has to be installed.

        Returns
        -------
        pandas.DataFrame
            One row for each point, with the columns of `points`.
        """
        # It need not be installed where types are checked.
        return importlib.import_module("pandas").DataFrame(self.points)

    def to_html(self) -> str:
        """The report as a page of HTML, without references to other files.

        Returns
        -------
        str
            The page.
        """
        return self._native.to_html()

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Write report.json, report.html, points.csv, config.toml and figures into a folder.

        Files of these names are replaced if symplint wrote them.

        Parameters
        ----------
        folder : path
            The folder, which is created if it does not exist.

        Raises
        ------
        InputError
            If the path is empty, or the folder has a file of these names that symplint did not write.
        """
        path = os.fsdecode(folder)
        if not path:
            raise InputError("folder is an empty path; give a folder")
        check_replaceable(path)
        self._native.save(path)

    def plot(self, ax: Axes | None = None, **kwargs: Any) -> Axes:
        """Draw the defects of all loops against step sizes.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; new axes by default.
        **kwargs
            The style of the line of your loop, as ``matplotlib.axes.Axes.plot`` takes it.

        Returns
        -------
        matplotlib.axes.Axes
            The axes with the figure.
        """
        from ._plot import plot_defects

        return plot_defects(self, ax, kwargs)

    def plot_loop(self, ax: Axes | None = None, *, dof: int = 0, samples: int = 256, **kwargs: Any) -> Axes:
        """Draw your loop before and after one step of the largest size, with its breaks.

        Advances `samples` states by one step.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Axes to draw into; new axes by default.
        dof : int
            The degree of freedom whose plane is shown.
        samples : int
            Number of states to draw. The report of `measure` draws all of its states.
        **kwargs
            The style of the states after the step, as ``matplotlib.axes.Axes.plot`` takes it.

        Returns
        -------
        matplotlib.axes.Axes
            The axes with the figure.

        Raises
        ------
        InputError
            If the map has no degree of freedom `dof`.
        """
        from ._plot import plot_loop

        points = self.points
        sizes = points["step_size"][points["sweep"] == "step-size"]
        known = sizes[np.isfinite(sizes)]
        largest = float(known[np.argmax(np.abs(known))]) if known.size else float("nan")
        before, after = self._image(largest, samples)
        count = before[0].shape[1]
        if whole(dof, "dof", 0) >= count:
            raise InputError(f"dof is {dof}; give {'0' if count == 1 else f'a number from 0 to {count - 1}'}")
        breaks = self.breaks
        broken = breaks["s"][(breaks["loop"] == 0) & (breaks["step_size"] == largest) & (breaks["dof"] == dof)]
        return plot_loop(before, after, largest, dof, broken, ax, kwargs)

    def reasons(self) -> str:
        """The summary and the findings as one text, as exceptions show it.

        Returns
        -------
        str
            The text, of several lines.
        """
        return self._native.reasons()

    def __copy__(self) -> Report:
        return Report(self._native, self._image)

    def __deepcopy__(self, memo: dict[int, Any]) -> Report:
        return copy.copy(self)

    def __reduce__(self) -> tuple[Any, ...]:
        # Without the map, which need not be picklable.
        return _restored, (self.to_json(), self._native.title)

    def __str__(self) -> str:
        return self._native.text(False)

    def __repr__(self) -> str:
        return f"<symplint.Report: {self.headline}>"

    def _repr_html_(self) -> str:
        return self._native.fragment()


def check_replaceable(folder: str, names: tuple[str, ...] = SAVED) -> None:
    """Refuse a folder with files of these names that symplint did not write.

    Only config.toml and report.json show who wrote them. The other files belong to symplint if one of these two does.

    Raises
    ------
    InputError
        If there is such a file.
    """
    there = [name for name in names if os.path.lexists(os.path.join(folder, name))]
    shown = [name for name in MARKED if os.path.lexists(os.path.join(folder, name))]
    ours = [name for name in shown if _is_ours(folder, name)]
    for name in there:
        if name not in ours and (name in MARKED or not ours):
            raise InputError(f"symplint did not write {name} in {folder!r}, and does not replace it; give another folder")


def _is_ours(folder: str, name: str) -> bool:
    """Whether symplint wrote this config.toml or report.json."""
    try:
        with open(os.path.join(folder, name), encoding="utf-8") as file:
            if name == "config.toml":
                return file.readline().startswith(FIRST_LINES)
            contents = json.load(file)
    except (OSError, ValueError):
        return False
    return isinstance(contents, dict) and str(contents.get("schema")).startswith("symplint/")


def _restored(text: str, title: str) -> Report:
    """The report that was pickled."""

    def image(size: float, samples: int) -> tuple[States, States]:
        raise SymplintError("the report was pickled, which leaves out the map and the loop; draw the loop before that")

    return Report(_native.Report.from_json(text, title), image)


def _table(records: list[dict[str, Any]], columns: list[tuple[str, str]]) -> npt.NDArray[np.void]:
    """Records as a structured array; what is not given is NaN."""
    rows = [tuple(np.nan if record[name] is None else record[name] for name, _ in columns) for record in records]
    return np.array(rows, dtype=columns)


def _property(found: dict[str, Any]) -> Property:
    """A property from the JSON of a report."""
    factor, factor_uncertainty = found["factor"] or (None, None)
    rate, rate_uncertainty = found["rate"] or (None, None)
    return Property(
        holds={"yes": True, "no": False}.get(found["holds"]),
        defect=found["defect"],
        uncertainty=found["uncertainty"],
        factor=factor,
        factor_uncertainty=factor_uncertainty,
        rate=rate,
        rate_uncertainty=rate_uncertainty,
        text=found["text"],
        growth=found.get("growth"),
        order=found.get("order"),
    )
