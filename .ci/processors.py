"""Compares what the program finds on processors with other vector instructions: `python3 .ci/processors.py target/release/symplint`.

`qemu-x86_64` stands for them. With AVX2 and fused multiply-adds, as with AVX-512 where this processor has it, reports are the same
to the last bit. Without them sines may differ in their last bit: verdicts, orders and breaks are the same, and loop
integrals agree within their errors.
"""

import json
import subprocess
import sys

EXAMPLES = [
    "pendulum", "interpolated-pendulum", "absolute-value", "henon-heiles", "kepler", "fput", "standard-map", "pendulum-rattle",
    "charged-particle", "pic-1d", "two-cell",
]  # fmt: skip


def report(symplint: str, processor: str | None, arguments: list[str]) -> dict:
    command = [symplint, "check", *arguments, "--json", "--threads", "1"]
    if processor is not None:
        command = ["qemu-x86_64", "-cpu", processor, *command]
    found = subprocess.run(command, stdout=subprocess.PIPE, check=False)
    if found.returncode not in (0, 1, 3):
        sys.exit(f"{' '.join(command)} ended with {found.returncode}")
    report = json.loads(found.stdout)
    del report["provenance"]
    return report


def differences(one: dict, other: dict) -> list[str]:
    """In what two reports differ by more than errors."""
    found = [key for key in ("kind", "order") if one["verdict"].get(key) != other["verdict"].get(key)]
    found += ["points"] if len(one["points"]) != len(other["points"]) else []
    for a, b in zip(one["points"], other["points"], strict=False):
        errors = [point["quadrature_error"] + point["roundoff"] for point in (a, b)]
        if abs(a["signed_defect"] - b["signed_defect"]) > sum(errors):
            found.append(f"defect at h = {a['step_size']}: {a['signed_defect']} and {b['signed_defect']}")
    return found


def main() -> None:
    symplint = sys.argv[1]
    wrong = 0
    for example in EXAMPLES:
        for settings in ([], ["--set", "integrator.name=rk4"]):
            if settings and example in ("standard-map", "pendulum-rattle", "two-cell"):
                continue
            arguments = [f"examples/{example}.toml", "--set", "diagnostic.budget=5000", *settings]
            here = report(symplint, None, arguments)
            with_avx2 = report(symplint, "max", arguments)
            portable = report(symplint, "qemu64", arguments)
            found = differences(here, portable)
            same = here == with_avx2
            wrong += bool(found) or not same
            bits = "the same bits with AVX2" if same else "OTHER BITS WITH AVX2"
            print(f"{example} {' '.join(settings[1:])}: {bits}; without it {'; '.join(found) or 'the same within errors'}")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
