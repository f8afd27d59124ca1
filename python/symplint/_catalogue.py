"""Signatures and docstrings of the functions that make systems and integrators, from the catalogue of the library."""

from __future__ import annotations

import inspect
import json
import re
from dataclasses import dataclass
from typing import Any

__all__ = ["Argument", "choice", "docstring", "of_key", "sentence", "signature"]


@dataclass(frozen=True)
class Argument:
    """A keyword argument: its name, its type in stubs and in docstrings, its default, and what it means."""

    name: str
    annotation: str
    described: str
    default: Any
    help: str


def choice(name: str, values: list[str], help: str, *, default: Any = None, more: str = "") -> Argument:
    """An argument that is one of some texts; `more` are further types, as in a stub."""
    listed = ", ".join(f'"{value}"' for value in values)
    annotation = f"Literal[{listed}]{more}" + (" | None" if default is None else "")
    return Argument(name, annotation, f"{{{listed}}}" + (" or dict" if "Mapping" in more else ""), default, help)


def of_key(name: str, default: str | None, help: str) -> Argument:
    """The argument of a key of a configuration, whose default is a value of TOML; None without one."""
    value = None if default is None else json.loads(default)
    if isinstance(value, str) and name not in ("q0", "p0"):
        # The help names the other texts, and a file as { file = "…" }.
        texts = re.findall(r'"([^"]+)"', re.sub(r"\{.*?\}", "", help))
        more = " | Mapping[str, Any]" if "{ file" in help else ""
        return choice(name, list(dict.fromkeys([value, *texts])), help, default=value, more=more)
    if isinstance(value, bool):
        return Argument(name, "bool", "bool", value, help)
    if name in ("q0", "p0") or isinstance(value, list) or "a list" in help:
        return Argument(name, "npt.ArrayLike", "array_like", value, help)
    if value is None:
        of_each = "one for each" in help
        return Argument(name, "npt.ArrayLike | None" if of_each else "float | None", "array_like" if of_each else "float", None, help)
    kind = type(value).__name__
    return Argument(name, kind, kind, value, help)


def signature(positional: list[inspect.Parameter], arguments: list[Argument], result: str) -> inspect.Signature:
    """The signature of a function with these keyword arguments."""
    keyword = inspect.Parameter.KEYWORD_ONLY
    by_name = [inspect.Parameter(of.name, keyword, default=of.default, annotation=of.annotation) for of in arguments]
    return inspect.Signature([*positional, *by_name], return_annotation=result)


def sentence(text: str, *, capital: bool = True) -> str:
    """The text as a sentence. A symbol at the beginning keeps its letter."""
    first = re.match(r"[^\W\d_]+", text)
    if capital and first and text[0].islower():
        is_word = len(first[0]) > 1 and first[0].isascii() and not text.startswith(f"{first[0]}_")
        text = text[0].upper() + text[1:] if is_word else f"Value of {text}"
    return text if text.endswith(".") else f"{text}."


def docstring(summary: str, arguments: list[Argument], result: str, meaning: str, before: str = "", after: str = "") -> str:
    """A docstring in the style of NumPy; `before` are the lines of other parameters, `after` are further sections."""
    lines = []
    for of in arguments:
        default = ", optional" if of.default is None else f", default {json.dumps(of.default)}"
        lines.append(f"{of.name} : {of.described}{default}\n    {sentence(of.help)}")
    parameters = "\n".join([*([before] if before else []), *lines])
    head = f"\n\nParameters\n----------\n{parameters}" if parameters else ""
    return f"{summary}{head}\n\nReturns\n-------\n{result}\n    {meaning}\n{after}"
