"""Writes the reference chapters of the book: `python reference.py commands|configuration|catalogue|python|c|rust|report`.

Everything comes from the program `symplint` on the path, the installed package, the C header and the Rust sources. The pages in
docs/reference run this script, and .ci/run compares: see run_pages.py.
"""

from __future__ import annotations

import enum
import inspect
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
UNDERLINED = re.compile(r"^(\w[\w ]+)\n-{3,}\n", re.MULTILINE)
KEY = re.compile(r"^(# )?([a-z][a-z_0-9]*) = (.*?)(?:\s+# (.*))?$")


def run(*arguments: str, width: int = 100) -> str:
    """The standard output of the program. With width 0, lines are not broken."""
    environment = {name: value for name, value in os.environ.items() if name != "COLUMNS"} | {"NO_COLOR": "1"}
    if width:
        environment["COLUMNS"] = str(width)
    done = subprocess.run(["symplint", *arguments], capture_output=True, text=True, env=environment)
    if done.returncode not in (0, 1):
        raise SystemExit(f"symplint {' '.join(arguments)} failed: {done.stderr}")
    return done.stdout


def cell(text: str) -> str:
    """Text of a cell of a table."""
    return " ".join(text.split()).replace("|", "\\|")


def table(head: list[str], rows: list[list[str]]) -> str:
    """A table of Markdown."""
    lines = [head, ["---"] * len(head), *[[cell(text) for text in row] for row in rows]]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def commands() -> Iterator[str]:
    """The help text of each command."""
    listed = run("--help").partition("\nCommands:\n")[2].partition("\n\n")[0]
    names = [name for name in re.findall(r"^  ([a-z]+)  ", listed, re.MULTILINE) if name != "help"]
    for name in names:
        yield f"## symplint {name}\n\n```text out=no\n{run(name, '--help').rstrip()}\n```\n"


def starter(system: str) -> dict[str, list[list[str]]]:
    """The keys of a starter configuration by section: key, example or default, meaning."""
    environment = os.environ | {"NO_COLOR": "1"}
    done = subprocess.run(["symplint", "init", "--all", system], capture_output=True, text=True, env=environment)
    text = done.stdout if done.returncode == 0 else run("init", system)
    sections: dict[str, list[list[str]]] = {}
    rows: list[list[str]] = []
    for line in text.splitlines():
        if match := re.match(r"^\[(\w+)\]", line):
            rows = sections.setdefault(match[1], [])
        elif match := re.match(r"^\s{8,}# (.*)$", line):
            rows[-1][2] += f" {match[1]}"
        elif match := KEY.match(line):
            optional, key, value, meaning = match.groups()
            rows.append([f"`{key}`", f"`{value}`" + (" (not set)" if optional else ""), meaning or ""])
    return sections


def systems() -> list[str]:
    """The names of all systems."""
    return re.findall(r"^(\S+) {2,}\S", run("list", "systems", width=0), re.MULTILINE)


def configuration() -> Iterator[str]:
    """Every key of every section."""
    head = ["key", "value", "meaning"]
    names = systems()
    sections = starter(names[0])
    for name in ("integrator", "loop", "diagnostic", "trace"):
        yield f"## [{name}]\n\n{table(head, sections[name])}"
    yield "## [system]\n\nThe key `name` chooses the system. Each system has its keys.\n"
    for name in names:
        yield f"### {name}\n\n{table(head, [row for row in starter(name)['system'] if row[0] != '`name`'])}"


def catalogue() -> Iterator[str]:
    """Systems, integrators, rules and items of the paper."""
    for what in ("systems", "integrators", "rules", "figures"):
        rows = re.findall(r"^(\S+) {2,}(.*)$", run("list", what, width=0), re.MULTILINE)
        yield f"## {what.capitalize()}\n\n`symplint list {what}`:\n\n" + table(["name", "description"], [[f"`{name}`", text] for name, text in rows])


def described(docstring: str) -> str:
    """A docstring in the style of NumPy as Markdown."""
    parts = UNDERLINED.split(docstring)
    text = [parts[0].rstrip(), ""]
    for title, body in zip(parts[1::2], parts[2::2], strict=True):
        text += [f"**{title}**", ""]
        if title == "Examples":
            text += ["```pycon", body.strip(), "```", ""]
        elif re.search(r"^\S.*\n {4}", body, re.MULTILINE) and title not in ("Notes",):
            for entry in re.split(r"\n(?=\S)", body.strip("\n")):
                name, _, meaning = entry.partition("\n")
                first, _, kind = name.partition(" : ")
                kind = f" ({kind})" if kind else ""
                text.append(f"* `{first}`{kind}: {' '.join(inspect.cleandoc(meaning).split())}" if meaning else f"* {name}")
            text.append("")
        else:
            text += [body.strip(), ""]
    return "\n".join(text)


def python() -> Iterator[str]:
    """Every public name of the package with its docstring."""
    import symplint

    values = {name: getattr(symplint, name) for name in symplint.__all__}
    functions = {name: value for name, value in values.items() if inspect.isfunction(value)}
    classes = {name: value for name, value in values.items() if inspect.isclass(value)}
    errors = {name: value for name, value in classes.items() if issubclass(value, BaseException)}
    adapters = {f"adapters.{name}": getattr(symplint.adapters, name) for name in symplint.adapters.__all__}
    classes |= {name: value for name, value in adapters.items() if inspect.isclass(value)}
    adapters = {name: value for name, value in adapters.items() if inspect.isfunction(value)}
    for title, listed in (("Functions", functions), ("Adapters", adapters)):
        yield f"## {title}\n"
        for name in sorted(listed):
            value = listed[name]
            arguments = ", ".join(argument_text(argument) for argument in inspect.signature(value).parameters.values())
            yield f"### {name}\n\n`symplint.{name}({arguments})`\n\n{described(inspect.getdoc(value) or '')}"
    yield "## Classes\n"
    for name in sorted(set(classes) - set(errors)):
        value = classes[name]
        yield f"### {name}\n\n{described(inspect.getdoc(value) or '')}"
        members = [
            (member, found)
            for member, found in vars(value).items()
            if not member.startswith("_") and (isinstance(found, property) or inspect.isfunction(found))
        ]
        rows = [
            [f"`{member}`" if isinstance(found, property) else f"`{member}()`", (inspect.getdoc(found) or "").split("\n\n")[0]]
            for member, found in members
        ]
        if rows:
            yield table(["member", "meaning"], rows)
    yield "## Errors\n\n" + table(
        ["error", "also", "meaning"],
        [
            [f"`{name}`", ", ".join(f"`{base.__name__}`" for base in public_bases(value)), (inspect.getdoc(value) or "").split("\n\n")[0]]
            for name, value in sorted(errors.items())
        ],
    )


def public_bases(error: type) -> Iterator[type]:
    """The classes that an error is of, without private ones between."""
    for base in error.__bases__:
        if base.__name__.startswith("_"):
            yield from public_bases(base)
        else:
            yield base


def argument_text(argument: inspect.Parameter) -> str:
    """An argument with its default."""
    star = {argument.VAR_POSITIONAL: "*", argument.VAR_KEYWORD: "**"}.get(argument.kind, "")
    default = argument.default
    if isinstance(default, enum.Enum):
        default = default.value
    return f"{star}{argument.name}" + ("" if default is argument.empty else f"={default!r}")


def c() -> Iterator[str]:
    """Every declaration of the header."""
    header = (REPOSITORY / "crates/symplint-c/include/symplint.h").read_text(encoding="utf-8")
    functions, types = [], []
    for comment, declaration in re.findall(r"^/\*\*\n(.*?)^ \*/\n(.*?;(?=\n\n|\n#|\Z))", header, re.DOTALL | re.MULTILINE):
        text = re.sub(r"^ \* ?", "", comment, flags=re.MULTILINE).strip()
        text = re.sub(r"^# (\w+)$", r"**\1**", text, flags=re.MULTILINE)
        name = re.findall(r"\w+", declaration)[-1] if declaration.startswith("typedef") and "(*" not in declaration else None
        match = re.search(r"\(\*(\w+)\)|(\w+)\(", declaration)
        name = name or (match and (match[1] or match[2])) or declaration
        (types if declaration.startswith("typedef") else functions).append((name, text, declaration))
    for title, entries in (("Functions", functions), ("Types", types)):
        yield f"## {title}\n"
        for name, text, declaration in entries:
            yield f"### {name}\n\n{text}\n\n```c run=no\n{declaration}\n```\n"


def first_sentence(text: str) -> str:
    """The first sentence of a comment, without links."""
    sentence = re.split(r"(?<=[.])\s", " ".join(text.split("\n\n")[0].split()), maxsplit=1)[0]
    return re.sub(r"\[(`[^`]*`)\]", r"\1", sentence)


def declarations(lines: list[str]) -> Iterator[tuple[str, str, str]]:
    """Kind, name and comment of the public items of a source file."""
    comment: list[str] = []
    depth = 0
    for line in lines:
        bare = line.strip()
        if bare.startswith("///"):
            comment.append(bare.removeprefix("///").strip())
        elif depth or bare.startswith("#["):
            # An attribute may have several lines.
            depth += bare.count("[") - bare.count("]")
        else:
            if match := re.match(r"pub (struct|enum|trait|fn) (\w+)", bare):
                yield match[1], match[2], "\n".join(comment)
            comment = []


def rust() -> Iterator[str]:
    """The names that the crate `symplint` exports, with the first sentence of their documentation."""
    root = REPOSITORY / "crates/symplint/src"
    library = (root / "lib.rs").read_text(encoding="utf-8")
    items = {}
    for path in sorted(root.rglob("*.rs")):
        for kind_, name, comment in declarations(path.read_text(encoding="utf-8").splitlines()):
            if comment and name[0].isupper():
                items.setdefault(name, (kind_, comment))
            elif comment:
                items.setdefault(f"{path.relative_to(root).parts[0]}::{name}", (kind_, comment))
    rows = []
    for path_ in re.findall(r"^pub use ([^;]+);", library, re.MULTILINE):
        module, _, last = path_.rpartition("::")
        for name in re.findall(r"\w+", last):
            kind_, comment = items.get(name) or items.get(f"{module}::{name}") or ("fn", "")
            rows.append([f"`symplint::{name}`", kind_, first_sentence(comment)])
    yield table(["name", "kind", "meaning"], rows)
    rows = []
    for name in re.findall(r"^pub mod (\w+);", library, re.MULTILINE):
        path = root / name / "mod.rs" if (root / name / "mod.rs").exists() else root / f"{name}.rs"
        lines = path.read_text(encoding="utf-8").splitlines()
        text = "\n".join(line.removeprefix("//!").strip() for line in lines if line.startswith("//!"))
        rows.append([f"`symplint::{name}`", first_sentence(text)])
    yield "The public modules:\n\n" + table(["module", "contents"], rows)


def paths(value: object, path: str = "") -> Iterator[tuple[str, str]]:
    """The keys of a report with their types; arrays by their first element."""
    if isinstance(value, dict):
        for key, found in value.items():
            yield from paths(found, f"{path}.{key}" if path else key)
    elif isinstance(value, list):
        if value and isinstance(value[0], dict | list):
            yield from paths(value[0], f"{path}[]")
        else:
            yield f"{path}[]", kind(value[0]) if value else "any"
    else:
        yield path, kind(value)


def kind(value: object) -> str:
    """The type of a value in JSON."""
    names = {"bool": "true or false", "int": "number", "float": "number", "str": "text", "NoneType": "null", "dict": "object", "list": "array"}
    return names[type(value).__name__]


#: Keys of reports whose meaning the table states. Unknown and missing keys are errors.
MEANINGS = {
    "schema": "the version of this format",
    "symplint": "the version of the program",
    "evaluations.made": "states advanced by one step",
    "evaluations.budget": "the limit of evaluations",
    "evaluations.wanted": "evaluations that all tests would make without a limit",
    "evaluations.replayed": "evaluations that were read from a journal",
    "verdict.kind": "`symplectic`, `not-symplectic`, `broken-loops` or `undecided`",
    "verdict.digits": "digits to which loop integrals are conserved, if the verdict is `symplectic`",
    "verdict.order": "the k of change ~ hᵏ, if the changes follow a power law",
    "verdict.conserved_once_closed": "whether broken loops conserve the integral with their breaks closed",
    "verdict.summary": "the verdict in one sentence",
    "verdict.findings[].kind": "the kind of a finding",
    "verdict.findings[].text": "the finding as a sentence",
    "verdict.sentences[]": "the findings as sentences",
    "verdict.cause": "the likely cause, or null: `kind`, `text`, `remedy`, `setting`, `digits`",
    "verdict.cause.kind": "the kind of the cause",
    "verdict.cause.text": "the evidence for the cause",
    "verdict.cause.remedy": "the remedy",
    "verdict.cause.setting": "a setting that makes the map symplectic, or null",
    "verdict.cause.digits": "digits to which the map is symplectic with this setting",
    "verdict.advice[]": "the next steps, as sentences",
    "points[].sweep": "`step-size` or `samples`",
    "points[].loop": "0 for your loop, then the random loops",
    "points[].step_size": "h",
    "points[].samples": "samples of the loop",
    "points[].rule": "the rule of the integral",
    "points[].initial": "the loop integral before the step",
    "points[].final": "the loop integral after the step; of a broken loop, between the breaks",
    "points[].signed_defect": "the relative change with its sign",
    "points[].defect": "its absolute value",
    "points[].quadrature_error": "the quadrature error of the change",
    "points[].roundoff": "the rounding error of the change",
    "points[].omitted_cells": "cells that the finite-difference rule left out",
    "points[].jumps": "jumps of the advanced loop",
    "points[].chord": "the part of the integral on the curves that close breaks",
    "points[].closed_defect": "the change with the breaks closed",
    "points[].regularity": "the exponent r if the loop is in H^r: the decay of its Fourier coefficients",
    "points[].evaluations": "evaluations of this point",
}
CHECKS = {
    "memory": "does the result depend on earlier calls or on random numbers?",
    "given_loop": "your loop, at all step sizes",
    "random_loops": "random loops, at the largest step size",
    "jacobian": "MᵀJM = J at a few states",
    "constraint": "does the map move states onto a manifold?",
    "contraction": "can the loop be contracted in the domain of the map?",
    "localisation": "which substep, and which part of the loop?",
    "structure": "volume, time reversal, energy and the other properties",
}


def report() -> Iterator[str]:
    """The keys of a report, from a run."""
    found = json.loads(run("check", "pendulum", "--set", "integrator.name=rk2", "--json"))
    rows, other = [], []
    for path, type_ in dict(paths(found)).items():
        top = path.split(".")[0].removesuffix("[]")
        if path in MEANINGS:
            rows.append([f"`{path}`", type_, MEANINGS[path]])
        elif path.startswith("evaluations.by_check."):
            rows.append([f"`{path}`", type_, f"evaluations of a check: {CHECKS[path.split('.')[2]]}"])
        elif path.startswith("verdict.findings[]."):
            continue
        elif top in ("points", "verdict", "evaluations"):
            raise SystemExit(f"{path} has no meaning in MEANINGS of {Path(__file__).name}")
        elif top not in other:
            other.append(top)
    yield table(["key", "type in this run", "meaning"], rows)
    yield "A finding has further keys, which depend on its kind.\n"
    yield "Other keys hold nested values:\n"
    yield table(["key", "its keys"], [[f"`{top}`", ", ".join(f"`{key}`" for key in names(found[top]))] for top in other])


def names(value: object) -> list[str]:
    """The keys of an object, or of the first object of an array."""
    if isinstance(value, list):
        value = value[0] if value else {}
    return list(value) if isinstance(value, dict) else []


CHAPTERS = {
    "commands": commands, "configuration": configuration, "catalogue": catalogue, "python": python, "c": c, "rust": rust, "report": report,
}  # fmt: skip

if __name__ == "__main__":
    print("\n".join(CHAPTERS[sys.argv[1]]()))
