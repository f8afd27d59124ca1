"""The register of released packages: its table and its script belong together. The packages themselves are not installed here."""

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture
def entries(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "examples" / "python")
    import register

    yield register.ENTRIES
    for name in ("register", "register_solvers", "register_physics"):
        sys.modules.pop(name, None)


def test_every_row_has_an_entry_and_agrees_with_theory(entries):
    page = (ROOT / "docs" / "register.md").read_text(encoding="utf-8")
    rows = [line.strip("|").split("|") for line in page.splitlines() if re.match(r"\| [\w-]+ \| \d", line)]
    rows = [[cell.strip() for cell in row] for row in rows]
    theory = {(package, method): theory for _, method, package, theory in entries.values()}
    shown = {(package, method.strip("`")): of for package, _, method, of, _ in rows}
    assert shown == theory
    for package, _, method, of, verdict in rows:
        is_symplectic = verdict.startswith("symplectic to ")
        # Undecided, or broken loops: not symplectic to any digits.
        assert is_symplectic == of.startswith("symplectic"), (package, method, of, verdict)
    counted = f"{len(rows)} methods of {len({package for package, *_ in rows})} packages"
    assert counted in page
