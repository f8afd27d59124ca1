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


def of_key(name: str, default: str | None, help: str, kind: str, texts: list[str]) -> Argument:
    """The argument of a key of a configuration, whose default is a value of TOML; None without one.

    `kind` is "plain", "numbers", "choice" or "choice-or-file", as the table of keys states it.
    """
    value = None if default is None else json.loads(default)
    if texts:
        return choice(name, texts, help, default=value, more=" | Mapping[str, Any]" if kind == "choice-or-file" else "")
    type_name = "float" if value is None else type(value).__name__
    annotation, described = ("npt.ArrayLike", "array_like") if kind == "numbers" else (type_name, type_name)
    return Argument(name, annotation + (" | None" if value is None else ""), described, value, help)


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
