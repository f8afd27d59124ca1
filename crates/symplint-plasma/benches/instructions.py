"""Prints the number of instructions of each kernel of instructions.rs, counted under valgrind.

    python3 crates/symplint-plasma/benches/instructions.py

A kernel runs twice and six times; a quarter of the difference is one run, without
what it takes to start. Counts have three digits: fewer than what varies from run to run.
"""

import json
import re
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
FEW, MANY = 2, 6


def executable():
    build = "cargo bench --profile release --locked -p symplint-plasma --bench instructions --no-run --message-format=json"
    messages = subprocess.run(build.split(), cwd=ROOT, check=True, capture_output=True, text=True)
    found = [json.loads(line).get("executable") for line in messages.stdout.splitlines()]
    return next(path for path in found if path)


def instructions(program, kernel, times):
    with tempfile.NamedTemporaryFile() as out:
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out.name}"]
        done = subprocess.run(
            command + [program, kernel, str(times)], check=True, capture_output=True, text=True
        )
    return int(re.search(r"Collected : (\d+)", done.stderr).group(1))


def main():
    program = executable()
    kernels = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    for kernel in kernels.splitlines():
        name, units, unit = kernel.split("\t")
        count = instructions(program, name, MANY) - instructions(program, name, FEW)
        each = count / (MANY - FEW) / int(units)
        print(f"{name:<36}{float(f'{each:.3g}'):>12,.10g}  for each {unit}", flush=True)


if __name__ == "__main__":
    main()
