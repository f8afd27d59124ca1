"""Draws the picture of README.md, for light and dark pages: `python picture.py FOLDER`. Needs matplotlib."""

import sys
from pathlib import Path

import matplotlib
import numpy as np
import symplint

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402

THEMES = {
    "light": {"ink": "#24292f", "before": "#57606a", "leapfrog": "#0969da", "midpoint": "#bc4c00"},
    "dark": {"ink": "#e6edf3", "before": "#8b949e", "leapfrog": "#58a6ff", "midpoint": "#f0883e"},
}


def leapfrog(q, p, h):
    q = q + 0.5 * h * p
    p = p - h * np.sin(q)
    return q + 0.5 * h * p, p


def midpoint(q, p, h):
    q_half, p_half = q + 0.5 * h * p, p - 0.5 * h * np.sin(q)
    return q + h * p_half, p - h * np.sin(q_half)


def draw(folder: Path, theme: str) -> None:
    """The loop after a step, and the change of its integral against the step size."""
    colours = THEMES[theme]
    ink = {key: colours["ink"] for key in ("text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color")}
    with plt.rc_context({"svg.hashsalt": "symplint", "font.size": 10, **ink}):
        figure, (left, right) = plt.subplots(1, 2, figsize=(7.6, 3.2), layout="constrained")
        q, p = symplint.circle(0.7, 1.0, radius=1.0, samples=400)
        area = symplint.loop_integral(q, p).value
        left.plot(np.append(q, q[0]), np.append(p, p[0]), "--", color=colours["before"], label="loop before the step")
        for name, step in (("leapfrog", leapfrog), ("midpoint", midpoint)):
            q1, p1 = step(q, p, 1.0)
            change = symplint.loop_integral(q1, p1).value / area - 1
            shown = "area unchanged" if abs(change) < 1e-12 else f"area {change:+.0%}".replace("-", "−")
            label = {"leapfrog": "leapfrog", "midpoint": "Runge–Kutta 2"}[name]
            left.plot(np.append(q1, q1[0]), np.append(p1, p1[0]), color=colours[name], label=f"{label}: {shown}")
            points = symplint.check(step, 0.7, 1.0).points
            own = points[points["loop"] == 0]
            changed = own["defect"] > 0
            right.loglog(own["step_size"][changed], own["defect"][changed], "o-", color=colours[name], label=label, markersize=4)
            right.plot(own["step_size"][~changed], np.full(np.sum(~changed), 2e-17), "v", color=colours[name], fillstyle="none", markersize=5)
        left.set(xlabel="position q", ylabel="momentum p", aspect="equal", title="a loop of states, one step of h = 1", xlim=(-0.9, 3.5), ylim=(-1.1, 3.1))
        left.legend(frameon=False, loc="upper left", fontsize=8)
        right.set(xlabel="step size h", title="relative change of its area", ylim=(1e-17, 3))
        right.legend(frameon=False, loc="center right", fontsize=9)
        for axes in (left, right):
            axes.patch.set_alpha(0)
        figure.savefig(folder / f"readme-{theme}.svg", transparent=True, metadata={"Date": None})
        if len(sys.argv) > 2:
            figure.savefig(folder / f"readme-{theme}.png", dpi=110, facecolor="white" if theme == "light" else "#0d1117")
        plt.close(figure)


if __name__ == "__main__":
    for each in THEMES:
        draw(Path(sys.argv[1]), each)
    text = "Left: a circle of states and its image after one step. Right: the change of its area against the step size."
    print("<picture>")
    print('<source media="(prefers-color-scheme: dark)" srcset="docs/images/readme-dark.svg">')
    print(f'<img src="docs/images/readme-light.svg" width="760" alt="{text}">')
    print("</picture>")
