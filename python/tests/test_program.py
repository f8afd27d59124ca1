"""The program that the package installs."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest


def run(*arguments):
    program = shutil.which("symplint", path=Path(sys.executable).parent)
    if program is None:
        pytest.skip("the package is not installed with this Python")
    return subprocess.run([program, *arguments], capture_output=True, text=True, check=False)


def test_a_system_is_checked_by_its_name():
    done = run("check", "pendulum", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["verdict"]["kind"] == "symplectic"
    done = run("check", "pendulum", "-q", "--set", "integrator.name=rk2")
    assert done.returncode == 1 and done.stdout.startswith("NOT SYMPLECTIC")


def test_help_and_mistakes_have_their_statuses():
    done = run("--help")
    assert done.returncode == 0 and "symplint init pendulum" in done.stdout
    done = run("check", "nowhere.toml")
    assert done.returncode == 2 and "nowhere.toml" in done.stderr


def test_a_figure_of_the_paper_is_reproduced(tmp_path):
    done = run("reproduce", "fig1", "--out", str(tmp_path / "paper"))
    assert done.returncode == 0, done.stderr
    assert list((tmp_path / "paper" / "figures").glob("*.svg"))
