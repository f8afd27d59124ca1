"""The stubs: against a file of a user, against the package, against the catalogue."""

import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent


def run(*command):
    done = subprocess.run(
        [sys.executable, *command], capture_output=True, text=True, check=False, cwd=HERE / "typing"
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_mypy_knows_every_type(tmp_path):
    pytest.importorskip("mypy")
    run("-m", "mypy", "--strict", f"--cache-dir={tmp_path}", "user.py")


def test_pyright_knows_every_type():
    pytest.importorskip("pyright")
    run("-m", "pyright", "--pythonpath", sys.executable, "user.py")


def test_pyright_finds_no_error_in_the_package():
    pytest.importorskip("pyright")
    run("-m", "pyright", "--pythonpath", sys.executable, str(HERE.parent / "symplint"))


def test_stubs_agree_with_the_package():
    pytest.importorskip("mypy")
    modules = ("symplint._native", "symplint.systems", "symplint.integrators")
    run("-m", "mypy.stubtest", *modules, "--ignore-missing-stub", "--ignore-disjoint-bases")


def test_stubs_agree_with_the_catalogue():
    run(str(HERE.parent / "tools" / "stubs.py"), "--check")


def test_the_file_of_the_user_runs():
    run("user.py")
