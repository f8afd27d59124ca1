"""Kills diagnoses at random moments, resumes them, and compares: `python python/tools/kill_and_resume.py --runs 200`.

Each run is killed once by SIGKILL, from its start to its end with equal chance, and then continues. Its report has to be that of a
run that was never stopped, but for the provenance, and the map may not have been called again for states that it had
advanced before. The map counts its calls itself, at their ends. A call that ended in the instant of the kill, and was not noted yet,
is made again: these are told.

Runs of the program need the variable SYMPLINT, its path.
"""

import argparse
import hashlib
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

KINDS = ("batches", "samples", "executor", "command")

#: A program as a map. Its last argument is the file of counts.
PROGRAM = """
import hashlib, os, sys, time
import numpy as np

before, after, h, counts = sys.argv[1], sys.argv[2], float(sys.argv[3]), sys.argv[4]
file = np.load(before)
q, p = file["q"], file["p"]
name = hashlib.sha256(repr(h).encode() + q.tobytes() + p.tobytes()).hexdigest()
q = q + 0.5 * h * p
p = p - h * np.sin(q)
np.savez(after, q=q + 0.5 * h * p, p=p)
with open(counts, "a") as file:
    file.write(name + "\\n")
os._exit(0)
"""

CONFIGURATION = """
[system]
name = "command"
command = ["{python}", "program.py", "{{before}}", "{{after}}", "{{h}}", "{counts}"]
files = ["program.py"]
q0 = [1.0]
p0 = [0.5]
workers = 1
batch = 16

[diagnostic]
step_sizes = [0.5, 0.25]
budget = 200
loops = 2
"""


def check(kind: str, folder: Path, counts: Path) -> None:
    """One run, in this process or as the program."""
    if kind == "command":
        program = [os.environ["SYMPLINT"], "check", str(folder.parent / "run.toml"), "--out", str(folder), "--quiet"]
        os.execv(program[0], program)
    import numpy as np
    import symplint

    def step(q, p, h):
        name = hashlib.sha256(repr(h).encode() + q.tobytes() + p.tobytes()).hexdigest()
        time.sleep(2e-3 if q.ndim == 1 else 3e-2)
        q = q + 0.5 * h * p
        p = p - h * np.sin(q)
        with open(counts, "a") as file:
            file.write(name + "\n")
        return q + 0.5 * h * p, p

    settings = {"step_sizes": [0.5, 0.25], "budget": 300, "loops": 3, "out": folder}
    if kind == "executor":
        # Threads end with the process: what is under way is lost. Both are one process: it does not compare itself with another process.
        with ThreadPoolExecutor(2) as executor:
            symplint.check(step, 1.0, 0.5, executor=executor, per_sample=True, **settings)
    else:
        symplint.check(step, 1.0, 0.5, per_sample=kind == "samples", **settings)


def start(kind: str, folder: Path, counts: Path) -> subprocess.Popen:
    folder.parent.mkdir(parents=True, exist_ok=True)
    (folder.parent / "program.py").write_text(PROGRAM)
    # One path for all runs: it is part of the configuration.
    link = folder.parent / "counts"
    text = CONFIGURATION.format(python=sys.executable, counts=link.name)
    (folder.parent / "run.toml").write_text(text)
    if not link.is_symlink():
        link.symlink_to(counts)
    return subprocess.Popen([sys.executable, __file__, "--one", kind, folder, counts], stdout=subprocess.DEVNULL)


def finish(kind: str, folder: Path, counts: Path) -> float:
    """How many seconds a run takes to its end."""
    begin = time.monotonic()
    status = start(kind, folder, counts).wait()
    # The budget of the program is too small to decide.
    if status not in (0, 3):
        raise SystemExit(f"a run of {kind} ended with {status}")
    return time.monotonic() - begin


def report(folder: Path) -> dict:
    found = json.loads((folder / "report.json").read_text())
    del found["provenance"]
    # The program of every run lies in a separate folder.
    found["config"].get("system", {}).pop("folder", None)
    return found


def calls(counts: Path) -> Counter:
    return Counter(counts.read_text().split()) if counts.exists() else Counter()


def one(kind: str, scratch: Path, number: int, whole: tuple[dict, Counter, float]) -> tuple[bool, int, int]:
    """Kills a run and resumes it: whether the report is the same, calls before the kill, and calls made again."""
    expected, needed, seconds = whole
    folder, counts = scratch / kind / str(number) / "run", scratch / kind / str(number) / "calls"
    process = start(kind, folder, counts)
    time.sleep(random.Random(f"{kind} {number}").uniform(0.0, seconds))
    process.send_signal(signal.SIGKILL)
    process.wait()
    # A program that was called when it happened ends with it.
    time.sleep(0.3 if kind == "command" else 0.0)
    before = calls(counts).total()
    finish(kind, folder, counts)
    again = calls(counts) - needed
    same = report(folder) == expected and not needed - calls(counts)
    return same, before, again.total()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=200, help="runs in all")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=list(KINDS), help="maps")
    parser.add_argument("--one", nargs=3, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        kind, folder, counts = arguments.one
        check(kind, Path(folder), Path(counts))
        return
    wrong = 0
    with tempfile.TemporaryDirectory() as scratch:
        for k, kind in enumerate(arguments.kinds):
            folder, counts = Path(scratch) / kind / "whole" / "run", Path(scratch) / kind / "whole" / "calls"
            seconds = finish(kind, folder, counts)
            whole = report(folder), calls(counts), seconds
            runs = range(k, arguments.runs, len(arguments.kinds))
            with ThreadPoolExecutor(2) as pool:
                found = list(pool.map(lambda number: one(kind, Path(scratch), number, whole), runs))
            different = sum(not same for same, _, _ in found)
            again = [made for _, _, made in found]
            wrong += different + sum(made > 1 for made in again)
            inside = sum(0 < before < whole[1].total() for _, before, _ in found)
            print(
                f"{kind}: {len(found)} runs of {whole[1].total()} calls killed, {inside} of them between two calls; "
                f"{different} reports differ; calls made again: {sum(again)}, at most {max(again)} in a run"
            )
    if wrong:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
