"""Writes tables of the book: `python tables.py gallery|budget|register`.

The first two are from runs of the program `symplint` on the path. The register is from the packages of this Python.
"""

from __future__ import annotations

import concurrent.futures
import importlib.metadata
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
SUPERSCRIPTS = str.maketrans("0123456789.-", "⁰¹²³⁴⁵⁶⁷⁸⁹·⁻")


def check(*arguments: str) -> dict | None:
    """The report of a check; None if the run fails."""
    done = subprocess.run(["symplint", "check", *arguments, "--json", "--threads", "1"], capture_output=True, text=True)
    return json.loads(done.stdout) if done.returncode in (0, 1, 3) else None


def many(calls: list[tuple[str, ...]]) -> list[dict | None]:
    """The reports of several checks."""
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(lambda call: check(*call), calls))


def power(order: float | None) -> str:
    """The order as a power of h."""
    return "" if order is None else f"h{f'{order:.1f}'.removesuffix('.0')}".translate(SUPERSCRIPTS)


def row(cells: list[str]) -> str:
    """A line of a table."""
    return f"| {' | '.join(cells)} |"


def gallery() -> Iterator[str]:
    """The verdict on each system with each integrator, in two tables."""
    smooth = ["pendulum", "harmonic-oscillator", "henon-heiles", "kepler", "double-pendulum", "fput", "toda"]
    other = ["interpolated-pendulum", "absolute-value", "rotational-force", "charged-particle", "pic-1d", "pic-es1"]
    for title, systems in (("Smooth systems", smooth), ("Splines, jumps and forces without a potential", other)):
        yield f"## {title}\n"
        yield from verdicts(systems)
        yield ""


def verdicts(systems: list[str]) -> Iterator[str]:
    """A table of the verdicts on some systems."""
    listed = subprocess.run(["symplint", "list", "integrators"], capture_output=True, text=True, env=os.environ | {"COLUMNS": "10000"})
    integrators = re.findall(r"^(\S+) {2,}Order", listed.stdout, re.MULTILINE)
    examples = {name: str(REPOSITORY / f"examples/{name}.toml") for name in systems}
    calls = [(examples[system], "--set", f"integrator.name={name}", "--set", "diagnostic.budget=10000") for name in integrators for system in systems]
    reports = iter(many(calls))
    yield row(["integrator", *systems])
    yield row(["---"] * (len(systems) + 1))
    for name in integrators:
        cells = [short(next(reports)) for _ in systems]
        if any(cells):
            yield row([name, *[text or "–" for text in cells]])


def short(report: dict | None) -> str:
    """A verdict in a few characters."""
    if report is None:
        return ""
    verdict = report["verdict"]
    match verdict["kind"]:
        case "symplectic":
            return f"**{verdict['digits']:.0f}**"
        case "not-symplectic":
            return power(verdict["order"]) or "no"
        case "broken-loops":
            return "closed" if verdict["conserved_once_closed"] else "broken"
    return "?"


def budget() -> Iterator[str]:
    """The verdict for each budget."""
    maps = [
        ("pendulum", "strang", []), ("pendulum", "rk2", []), ("henon-heiles", "strang", []), ("henon-heiles", "rk4", []),
        ("fput", "strang", []), ("kepler", "strang", []), ("double-pendulum", "implicit-midpoint", []), ("absolute-value", "strang", []),
        ("pic-1d", "strang", ["--set", "system.degree=1"]), ("pic-1d", "strang", []),
    ]  # fmt: skip
    budgets = ["200", "500", "2000", "10000", "100000", "auto"]
    calls = [
        (str(REPOSITORY / f"examples/{system}.toml"), "--set", f"integrator.name={integrator}", *more, "--set", f"diagnostic.budget={budget}")
        for system, integrator, more in maps
        for budget in budgets
    ]
    reports = iter(many(calls))
    yield row(["map", "integrator", *[f"{int(name):,}" if name.isdigit() else name for name in budgets]])
    yield row(["---"] * (len(budgets) + 2))
    for system, integrator, more in maps:
        degree = "" if not system.startswith("pic") else f" (degree {1 if more else 3})"
        yield row([f"{system}{degree}", integrator, *[long(next(reports)) for _ in budgets]])


def long(report: dict | None) -> str:
    """A verdict with its digits or order, and the evaluations."""
    if report is None:
        return "failed"
    verdict = report["verdict"]
    match verdict["kind"]:
        case "symplectic":
            text = f"symplectic, {verdict['digits']:.0f}"
        case "not-symplectic":
            text = f"not symplectic, {power(verdict['order'])}".removesuffix(", ")
        case "broken-loops":
            text = "broken, closed" if verdict["conserved_once_closed"] else "broken"
        case _:
            text = "undecided"
    return f"{text} ({report['evaluations']['made']:,})"


def register() -> Iterator[str]:
    """The register of packages, with new rows for the packages that are installed in the version of the page.

    The variable REGISTER has packages that must be installed, as `rebound==5.2.2`.
    """
    examples = REPOSITORY / "examples/python"
    sys.path.insert(0, str(examples))
    import register as entries

    names = {(package, argument): name for name, (_, argument, package, _) in entries.ENTRIES.items()}

    def again(line: str) -> str:
        package, version, method = [cell.strip() for cell in line.split("|")[1:4]]
        name = names.get((package, method.strip("`")))
        if name is None or is_other_version(package, version):
            if f"{package}=={version}" in os.environ.get("REGISTER", "").split():
                raise SystemExit(f"{package} {version} is not installed")
            return line
        # Some packages write files.
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, str(examples / "register.py"), "--row", name]
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        rows = [row for row in done.stdout.splitlines() if row.startswith(f"| {package} |")]
        if not rows:
            raise SystemExit(f"{name} fails:\n{done.stderr}")
        return rows[0]

    page = (REPOSITORY / "docs/register.md").read_text(encoding="utf-8")
    lines = page[page.index("| package | version |") : page.index("<!-- /table -->")].splitlines()
    yield from lines[:2]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        yield from pool.map(again, lines[2:])


def is_other_version(package: str, version: str) -> bool:
    """Whether another version of the package is installed, or none."""
    try:
        return importlib.metadata.version(package) != version
    except importlib.metadata.PackageNotFoundError:
        return True


if __name__ == "__main__":
    print("\n".join({"gallery": gallery, "budget": budget, "register": register}[sys.argv[1]]()))
