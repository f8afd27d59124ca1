"""Runs the code of README.md and of the book, and compares its output with the output in the pages.

    python python/tools/run_pages.py                 all pages: report every difference
    python python/tools/run_pages.py --write         replace outputs that differ
    python python/tools/run_pages.py docs/faq.md     one page
    python python/tools/run_pages.py --benches docs/performance.md

Each page runs from its beginning in an empty folder, which has a link `examples` to the examples of the repository.

* A block of `sh` runs in bash with the program `symplint` on the path, and ends at the first command that fails.
* A block of `python` runs in the interpreter of this script; all Python blocks of a page share their variables.
* A block of `text` after such a block is its output. A block without output has no block of `text` after it.
* `<!-- table: COMMAND -->` and `<!-- /table -->` enclose Markdown that a command writes. A command that draws pictures writes them to the
  folder `$PICTURES`. `<!-- table needs=A: COMMAND -->` has the setting `needs` of blocks.

Words after the language of a block are settings. GitHub and mdBook do not show them:

    exit=1          the exit status of the block; 0 by default
    file=NAME       do not run the block but write it to this file
    source=PATH     do not run the block; it has to be equal to this file of the repository, and is written to the page's folder
    needs=A,B       skip the block if a program on the path, `python:MODULE`, `library` (the C interface) or a file in `target/` is missing
    as=COMMAND      run this command instead, which has the same effect here
    picture=A:B,…   the block writes a picture A, which the page shows as B
    run=no          do not run the block; another step of .ci/run runs the same command
    run=benches     with the option --benches, run the block in the root of the repository; otherwise leave it
    head=N          of a block of text: the first N lines of the output, then a line with "…"
    grep=TEXT       of a block of text: the lines of the output that contain TEXT, in upper or lower case
    within=F        of a block of text: numbers are measured; they may differ from the page by this factor, or by any (inf)

The program is target/release/symplint, or the program that the variable SYMPLINT names.
"""

from __future__ import annotations

import argparse
import concurrent.futures
import contextlib
import dataclasses
import difflib
import functools
import importlib.util
import io
import multiprocessing
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
BLOCK = re.compile(
    r"^(?P<fence>```+)(?P<info>[^\n`]*)\n(?P<body>.*?)^(?P=fence)[ \t]*$"
    r"|^<!-- table(?: needs=(?P<needs>\S+))?: (?P<command>.*?) -->\n(?P<table>.*?)^<!-- /table -->$",
    re.DOTALL | re.MULTILINE,
)


class PageError(Exception):
    """A block that cannot be run, or that fails."""


@dataclasses.dataclass
class Result:
    """A page after its run: its new text, the differences, and what was skipped."""

    page: str
    text: str
    problems: list[str]
    skipped: list[str]
    seconds: float


def settings_of(info: str) -> tuple[str, dict[str, str]]:
    """The language of a block, and its settings."""
    words = shlex.split(info)
    language = words[0] if words else ""
    return language, dict(word.split("=", 1) for word in words[1:])


@functools.cache
def prefix() -> Path | None:
    """A folder with the C interface installed, from the library in target/; None if the library was not built."""
    if not (REPOSITORY / "target/release/libsymplint_c.so").exists():
        return None
    folder = Path(tempfile.gettempdir()) / f"symplint-pages-{os.getppid()}-{os.getpid()}"
    command = ["make", "--silent", "-C", str(REPOSITORY / "crates/symplint-c"), "install", f"PREFIX={folder}", "CARGO=true"]
    subprocess.run(command, check=True, env=os.environ | {"CARGO_TARGET_DIR": str(REPOSITORY / "target")})
    return folder


def is_missing(need: str) -> bool:
    """Whether a program, a module, the library or a file is missing."""
    if need == "library":
        return shutil.which("pkg-config") is None or prefix() is None
    if need.startswith("python:"):
        return importlib.util.find_spec(need.removeprefix("python:")) is None
    if need.startswith("target/"):
        return not (REPOSITORY / need).exists()
    return shutil.which(need) is None


#: Whether pages are written.
WRITE = False
#: Whether blocks with run=benches run.
BENCHES = False

NUMBER = re.compile(r"[+-]?\d+(?:[.,]\d+)*(?:e[+-]?\d+)?(?: digits)?")
#: Changes below this are rounding errors.
ROUNDING = 1e-12


def is_rounding(word: str) -> bool:
    """Whether a number is a rounding error."""
    return "e" in word and abs(float(word.replace(",", ""))) < ROUNDING


def comparable(text: str) -> str:
    """The text without the digits that another processor or another version of NumPy may change.

    Numbers below 1e-12 are rounding errors, and numbers of digits follow from them. A check does not compare the other numbers in such a
    line either, as the loop or the step size with the largest rounding error, and numbers of evaluations.
    """

    def kept(match: re.Match[str]) -> str:
        word = match[0]
        if word.endswith(" digits"):
            return "N digits" if float(word.removesuffix(" digits")) > 7 else word
        return "0" if is_rounding(word) else word

    lines = []
    for line in text.splitlines():
        rounded = any(is_rounding(word.removesuffix(" digits")) for word in NUMBER.findall(line))
        if not WRITE and (rounded or "valuations" in line):
            line = NUMBER.sub("0", line)
        lines.append(NUMBER.sub(kept, line))
    return " ".join(" ".join(lines).split())


def agree(new: str, old: str, factor: float) -> bool:
    """Whether two tables agree: the names of the rows, which end at two spaces, are the same, and the numbers after them are near."""
    rows = [[re.split(r"\s{2,}", line.strip(), maxsplit=1) for line in text.strip().splitlines()] for text in (new, old)]
    return [row[0] for row in rows[0]] == [row[0] for row in rows[1]] and all(
        near(" ".join(a[1:]), " ".join(b[1:]), factor) for a, b in zip(*rows, strict=True)
    )


def near(a: str, b: str, factor: float) -> bool:
    """Whether two texts have the same words, and numbers that differ by this factor at most."""
    numbers = ([float(word.removesuffix(" digits").replace(",", "")) for word in NUMBER.findall(text)] for text in (a, b))
    return NUMBER.sub("0", a).split() == NUMBER.sub("0", b).split() and all(
        x == y or factor == float("inf") or (x * y > 0 and 1 / factor <= x / y <= factor) for x, y in zip(*numbers, strict=True)
    )


class Page:
    """One run of one page."""

    def __init__(self, name: str, folder: Path) -> None:
        self.name, self.folder = name, folder
        self.namespace: dict[str, object] = {"__name__": "__main__"}
        self.output: str | None = None
        self.problems: list[str] = []
        self.skipped: list[str] = []

    def environment(self) -> dict[str, str]:
        """Variables of all commands: no colours, one width, and the library if it is installed."""
        own = {
            "NO_COLOR": "1", "COLUMNS": "100", "LC_ALL": "C.UTF-8", "PYTHONDONTWRITEBYTECODE": "1", "REPOSITORY": str(REPOSITORY),
            "PICTURES": str(REPOSITORY / "docs/images" if WRITE else self.folder),
            "PATH": f"{self.folder.parent / 'bin'}:{Path(sys.executable).parent}:{os.environ['PATH']}",
        }  # fmt: skip
        installed = prefix.cache_info().currsize and prefix()
        if installed:
            own |= {"PKG_CONFIG_PATH": f"{installed}/lib/pkgconfig", "LD_LIBRARY_PATH": f"{installed}/lib"}
        return os.environ | own

    def replaced(self, match: re.Match[str]) -> str:
        """Run one block, and return it as it should be."""
        whole = match[0]
        try:
            if match["command"] is not None:
                if self.skips(match["needs"], match["command"]):
                    return whole
                table = self.shell(match["command"], 0).rstrip()
                # The mask of rounding errors would hide numbers of the truth set: its tables are equal, or differ.
                same = str.split if "target/tmp/truth" in match["command"] else comparable
                if same(table) == same(match["table"]):
                    return whole
                first, _ = whole.split("\n", 1)
                return f"{first}\n{table}\n<!-- /table -->"
            language, settings = settings_of(match["info"])
            fence = match["fence"]
            body = self.block(language, settings, match["body"])
            if body is not None and language == "text":
                within = settings.get("within")
                measured = within and not WRITE and agree(body, match["body"], float(within))
                if measured or comparable(body) == comparable(match["body"]):
                    body = None
            return whole if body is None else f"{fence}{match['info']}\n{body}{fence}"
        except PageError as error:
            line = match.string.count("\n", 0, match.start()) + 1
            self.problems.append(f"{self.name}:{line}: {error}")
            self.output = None
            return whole

    def block(self, language: str, settings: dict[str, str], body: str) -> str | None:
        """Run a block of this language; the new body of a block that is a copy of something."""
        if language == "text":
            return self.text(settings)
        self.output = None
        is_bench = settings.get("run") == "benches"
        if settings.get("run") == "no" or (is_bench and not BENCHES):
            return None
        if self.skips(settings.get("needs"), (body.splitlines() or [settings.get("source", "")])[0]):
            return None
        if source := settings.get("source"):
            body = (REPOSITORY / source).read_text(encoding="utf-8")
            (self.folder / settings.get("file", Path(source).name)).write_text(body, encoding="utf-8")
            return body
        if file := settings.get("file"):
            path = self.folder / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(body, encoding="utf-8")
            return None
        folder = REPOSITORY if is_bench else self.folder
        if language == "sh":
            self.output = self.shell(settings.get("as", body), int(settings.get("exit", "0")), folder)
        elif language == "python":
            self.output = self.python(body)
        if picture := settings.get("picture"):
            for pair in picture.split(","):
                new, old = pair.split(":")
                self.picture(folder / new, old, compare=language == "sh" and not is_bench)
        return None

    def skips(self, needs: str | None, first: str) -> bool:
        """Whether something is missing that a block needs, whose first line is given."""
        missing = [need for need in (needs or "").split(",") if need and is_missing(need)]
        if missing:
            self.skipped.append(f"{self.name}: {first} ({', '.join(missing)} missing)")
        return bool(missing)

    def text(self, settings: dict[str, str]) -> str | None:
        """The output of the block before, as far as the page shows it."""
        if self.output is None:
            return None
        lines = [line.rstrip() for line in self.output.rstrip().split("\n")]
        if part := settings.get("grep"):
            lines = [line for line in lines if part.lower() in line.lower()]
        if (head := int(settings.get("head", "0"))) and head < len(lines):
            lines = [*lines[:head], "…"]
        self.output = None
        if not any(lines):
            raise PageError("the block before has no output")
        return "\n".join(lines) + "\n"

    def shell(self, script: str, expected: int, folder: Path | None = None) -> str:
        """Run commands in this folder, or the page's, and return their standard output."""
        done = subprocess.run(
            ["bash", "-e", "-o", "pipefail", "-c", script], cwd=folder or self.folder, env=self.environment(), capture_output=True, text=True, stdin=subprocess.DEVNULL
        )
        if done.returncode != expected:
            raise PageError(f"exit status {done.returncode} instead of {expected}: {script.strip()}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
        return done.stdout

    def python(self, code: str) -> str:
        """Run Python code and return what it prints."""
        stream = io.StringIO()
        here = os.getcwd()
        os.chdir(self.folder)
        try:
            with contextlib.redirect_stdout(stream):
                exec(compile(code, f"{self.name}", "exec"), self.namespace)
        except Exception as error:
            raise PageError(f"{type(error).__name__}: {error}\n{code}") from error
        finally:
            os.chdir(here)
        return stream.getvalue()

    def picture(self, new: Path, shown: str, compare: bool) -> None:
        """Compare a picture with its copy in the book, or copy it."""
        old = (REPOSITORY / self.name).parent / shown
        if not new.exists():
            raise PageError(f"the picture {new.name} was not written")
        if not old.exists() or (compare and new.read_bytes() != old.read_bytes()):
            if not WRITE:
                raise PageError(f"the picture {shown} differs from {new.name}")
        if WRITE:
            old.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(new, old)


def run(name: str, program: str, write: bool, benches: bool) -> Result:
    """Run one page."""
    global WRITE, BENCHES
    WRITE, BENCHES = write, benches
    os.environ.setdefault("MPLBACKEND", "Agg")
    os.environ["COLUMNS"] = "100"
    start = time.monotonic()
    text = (REPOSITORY / name).read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "page"
        folder.mkdir()
        (Path(scratch) / "bin").mkdir()
        (Path(scratch) / "bin/symplint").symlink_to(program)
        (folder / "examples").symlink_to(REPOSITORY / "examples")
        # Figures of matplotlib have the same bytes in each run.
        (Path(scratch) / "matplotlibrc").write_text("svg.hashsalt: symplint\n", encoding="utf-8")
        os.environ |= {"MATPLOTLIBRC": scratch, "SOURCE_DATE_EPOCH": "0"}
        page = Page(name, folder)
        new = BLOCK.sub(page.replaced, text)
        if prefix.cache_info().currsize and prefix():
            shutil.rmtree(prefix())
            prefix.cache_clear()
    if new != text:
        if write:
            (REPOSITORY / name).write_text(new, encoding="utf-8")
        else:
            page.problems.append("".join(difflib.unified_diff(text.splitlines(True), new.splitlines(True), name, f"{name}, run again", n=1)))
    return Result(name, new, page.problems, page.skipped, time.monotonic() - start)


def main() -> None:
    parser = argparse.ArgumentParser(description="Run the code of README.md and of the book, and compare its output.")
    parser.add_argument("pages", nargs="*", help="pages, relative to the repository; all by default")
    parser.add_argument("--write", action="store_true", help="replace outputs that differ")
    parser.add_argument("--strict", action="store_true", help="a program or module that is missing is an error")
    parser.add_argument("--benches", action="store_true", help="run the blocks that measure times, too")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="pages at a time")
    parser.add_argument("--times", action="store_true", help="print the time of each page")
    options = parser.parse_args()
    program = Path(os.environ.get("SYMPLINT", REPOSITORY / "target/release/symplint")).resolve()
    if not program.exists():
        sys.exit(f"{program} does not exist: build the program, or name it by SYMPLINT")
    pages = options.pages or [
        str(path.relative_to(REPOSITORY))
        for path in [REPOSITORY / "README.md", REPOSITORY / "python/README.md", *sorted((REPOSITORY / "docs").rglob("*.md"))]
    ]
    # The slowest first.
    pages.sort(key=lambda name: "symplint reproduce" not in (REPOSITORY / name).read_text(encoding="utf-8"))
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(options.workers, mp_context=context, max_tasks_per_child=1) as pool:
        tasks = [pool.submit(run, name, str(program), options.write, options.benches) for name in pages]
        results = [task.result() for task in tasks]
    for result in results:
        if options.times:
            print(f"{result.seconds:6.1f} s  {result.page}")
        for line in result.skipped:
            print(f"skipped: {line}")
        for problem in result.problems:
            print(problem)
    failed = sum(bool(result.problems) for result in results)
    skipped = sum(len(result.skipped) for result in results)
    print(f"{len(results)} pages, {failed} with differences, {skipped} blocks skipped")
    if failed and not options.write:
        print(f"python python/tools/run_pages.py --write{' --benches' * options.benches} replaces outputs that differ")
    if any(result.problems for result in results) or (options.strict and skipped):
        sys.exit(1)


if __name__ == "__main__":
    main()
