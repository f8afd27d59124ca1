"""Checks the links of README.md, CONTRIBUTING.md and the book: files, headings and pictures. Links to the network are not opened.

Every page of docs/ has to be in docs/SUMMARY.md, and every picture in docs/images has to be shown.

With a folder as argument, copies the files outside docs/ that pages link to into this folder. The book is built into its folder docs/, so
that its links to the files work: mdbook build docs && python python/tools/check_links.py target/book
"""

import html
import re
import shutil
import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
FENCED = re.compile(r"^(```+).*?^\1\s*$", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\(([^)\s]+)\)|(?:src|srcset)=\"([^\"]+)\"")


def anchors(page: Path) -> set[str]:
    """The anchors of all headings, as GitHub and mdBook make them."""
    text = FENCED.sub("", page.read_text(encoding="utf-8"))
    found = set()
    for heading in re.findall(r"^#+ (.*)$", text, re.MULTILINE):
        plain = re.sub(r"[^\w\- ]", "", heading.lower().replace("`", ""))
        found.add(plain.strip().replace(" ", "-"))
    return found


def copy(folder: Path, targets: set[Path]) -> None:
    """Copy files and folders to the same places under `folder`."""
    for target in targets - {REPOSITORY / "docs"}:
        copied = folder / target.relative_to(REPOSITORY)
        copied.parent.mkdir(parents=True, exist_ok=True)
        if target.is_dir():
            shutil.copytree(target, copied, dirs_exist_ok=True)
        elif target.suffix == ".md":
            # mdBook turns links to .md into links to .html.
            text = html.escape(target.read_text(encoding="utf-8"))
            copied.with_suffix(".html").write_text(f'<!doctype html><meta charset="utf-8"><pre>{text}</pre>', encoding="utf-8")
        else:
            shutil.copyfile(target, copied)


def main() -> None:
    files = {*REPOSITORY.glob("*.md"), REPOSITORY / "python/README.md", *(REPOSITORY / "docs").rglob("*")}
    pages = sorted(file for file in files if file.suffix == ".md")
    problems, targets = [], set()
    for page in pages:
        name = page.relative_to(REPOSITORY)
        text = FENCED.sub("", page.read_text(encoding="utf-8"))
        for link in (first or second for first, second in LINK.findall(text)):
            if re.match(r"[a-z]+:", link):
                continue
            path, _, anchor = link.partition("#")
            target = (page.parent / path).resolve() if path else page
            targets.add(target)
            if not target.exists():
                problems.append(f"{name}: {link} does not exist")
            elif anchor and target.suffix == ".md" and anchor not in anchors(target):
                problems.append(f"{name}: {link}: {target.name} has no such heading")
    summary = (REPOSITORY / "docs/SUMMARY.md").read_text(encoding="utf-8")
    for file in sorted(files):
        name = file.relative_to(REPOSITORY)
        if name.parts[0] != "docs" :
            continue
        inside = name.relative_to("docs").as_posix()
        if file.suffix == ".md" and inside != "SUMMARY.md" and f"({inside})" not in summary:
            problems.append(f"{name} is not in docs/SUMMARY.md")
        if file.suffix in (".svg", ".png") and file not in targets:
            problems.append(f"{name} is not shown on any page")
    if len(sys.argv) > 1:
        copy(Path(sys.argv[1]), {target for target in targets if target.exists() and REPOSITORY / "docs" not in target.parents})
    print("\n".join(problems) or f"{len(pages)} pages, all links lead somewhere")
    sys.exit(bool(problems))


if __name__ == "__main__":
    main()
