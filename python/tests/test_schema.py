"""Reports have the form that docs/reference/report.schema.json describes."""

import copy
import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import symplint

jsonschema = pytest.importorskip("jsonschema")

ROOT = Path(__file__).parents[2]
PROGRAM = os.environ.get("SYMPLINT") or shutil.which("symplint")


@pytest.fixture(scope="module")
def validator():
    schema = json.loads((ROOT / "docs/reference/report.schema.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def run(*arguments):
    if PROGRAM is None:
        pytest.skip("needs the program: set SYMPLINT to its path")
    done = subprocess.run([PROGRAM, *arguments, "--json"], capture_output=True, text=True, check=False)
    assert done.returncode in (0, 1, 3), done.stderr
    return json.loads(done.stdout)


def errors(validator, report):
    return [f"{error.json_path}: {error.message}" for error in validator.iter_errors(report)]


def kick(q, p, h):
    p = p - h * np.sin(q)
    return q + h * p, p


@pytest.mark.parametrize("example", sorted(ROOT.glob("examples/*.toml")), ids=lambda path: path.stem)
def test_reports_of_examples(validator, example):
    # Enough for a verdict in a second.
    report = run("check", str(example), "--set", "diagnostic.budget=20000")
    assert errors(validator, report) == []


@pytest.mark.parametrize(
    "settings",
    [
        ["integrator.name=rk2"],
        ["integrator.name=rk2", "diagnostic.steps=100"],
        ["integrator.damping=0.1"],
        ["diagnostic.step_sizes=none"],
        ["diagnostic.sample_sweep={ from = 64, to = 256, step_size = 0.1 }"],
    ],
    ids=" ".join,
)
def test_reports_of_settings(validator, settings):
    options = [option for setting in settings for option in ("--set", setting)]
    assert errors(validator, run("check", "pendulum", *options)) == []


def test_reports_of_files(validator, tmp_path):
    path = tmp_path / "before.npz"
    q, p = symplint.circle(0.0, 0.0, radius=1.0, samples=64)
    np.savez(path, q=q, p=p)
    assert errors(validator, run("measure", str(path), str(path))) == []


@pytest.mark.parametrize("weight", [1.0, 2.0])
def test_reports_of_python(validator, weight):
    report = symplint.check(kick, 1.0, 0.5, weight=weight, budget=5000)
    assert errors(validator, json.loads(report.to_json())) == []


def test_other_forms_are_refused(validator):
    whole = json.loads(symplint.check(kick, 1.0, 0.5, budget=2000).to_json())
    assert errors(validator, whole) == []

    def refused(change):
        changed = copy.deepcopy(whole)
        change(changed)
        return errors(validator, changed) != []

    assert refused(lambda report: report.update(schema="symplint/report/2"))
    assert refused(lambda report: report.pop("provenance"))
    assert refused(lambda report: report["verdict"].update(kind="maybe"))
    assert refused(lambda report: report["verdict"].update(digits="14"))
    assert refused(lambda report: report["verdict"].update(certainty=1))
    assert refused(lambda report: report["points"][0].update(samples=1.5))
    assert refused(lambda report: report["properties"][0].pop("text"))
    assert refused(lambda report: report["evidence"].update(loops=[]))
