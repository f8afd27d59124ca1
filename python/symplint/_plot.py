"""Figures by matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._arrays import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._report import Report

#: Relative rounding: smaller defects are drawn there, as a logarithmic axis has no zero.
FLOOR = 2.0**-53


def _axes(ax: Axes | None) -> Axes:
    if ax is not None:
        return ax
    try:
        import matplotlib.pyplot as plt
    except ImportError as error:
        raise ImportError("figures need matplotlib: pip install 'symplint[plot]'") from error
    return plt.figure(layout="constrained").add_subplot()


def plot_defects(report: Report, ax: Axes | None, style: dict[str, Any]) -> Axes:
    """Defects against step sizes, with their uncertainty and the fitted order; `style` applies to your loop."""
    ax = _axes(ax)
    points = report.points
    points = points[(points["sweep"] == "step-size") & np.isfinite(points["step_size"])]
    points = points[np.argsort(points["step_size"])]
    given, others = points[points["loop"] == 0], points[points["loop"] > 0]

    def draw(rows: np.ndarray, field: str, marks: str, label: str, own: dict[str, Any] | None = None) -> None:
        known = rows[np.isfinite(rows[field])]
        if known.size:
            ax.loglog(np.abs(known["step_size"]), np.maximum(known[field], FLOOR), marks, **{"label": label} | (own or {}))

    draw(given, "defect", "o-", "your loop", style)
    draw(given, "closed_defect", "d-", "your loop, breaks closed")
    draw(others, "defect", "x", "random loops")
    uncertainty = np.nan_to_num(given["quadrature_error"]) + given["roundoff"]
    if given.size:
        ax.loglog(np.abs(given["step_size"]), np.maximum(uncertainty, FLOOR), ":", color="0.5", label="uncertainty")
    if report.order is not None and given.size:
        sizes, largest = np.abs(given["step_size"]), given[-1]
        law = largest["defect"] * (sizes / abs(largest["step_size"])) ** report.order
        ax.loglog(sizes, law, "--", color="0.7", label=f"$h^{{{report.order:g}}}$")
        ax.set_ylim(bottom=FLOOR / 2)
    ax.set_xscale("log", base=2)
    ax.set_xlabel("step size h")
    ax.set_ylabel("relative change of ∮p·dq")
    ax.set_title(report.headline)
    if ax.has_data():
        ax.legend()
    return ax


def plot_loop(
    before: tuple[Array, Array], after: tuple[Array, Array], h: float, dof: int, breaks: Array, ax: Axes | None, style: dict[str, Any]
) -> Axes:
    """A loop before and after a step, with the chords over its breaks; `style` applies to the states after the step."""
    ax = _axes(ax)
    label = f"after one step of h = {h:g}" if np.isfinite(h) else "after the step"
    closed = [np.append(row[:, dof], row[0, dof]) for row in before]
    ax.plot(*closed, "-", color="0.6", label="before")
    # Points, because a line would hide that a loop is broken.
    points: dict[str, Any] = {"marker": ".", "linestyle": "", "label": label} | style
    ax.plot(after[0][:, dof], after[1][:, dof], **points)
    for number, s in enumerate(breaks):
        samples = len(after[0])
        ends = [int(s * samples) % samples, (int(s * samples) + 1) % samples]
        ax.plot(after[0][ends, dof], after[1][ends, dof], ":", color="tab:red", label="" if number else "breaks")
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel(f"q[{dof}]")
    ax.set_ylabel(f"p[{dof}]")
    ax.legend()
    return ax
