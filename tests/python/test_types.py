"""The stubs agree with the compiled module, and the package type-checks."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import perimpm

pytest.importorskip("mypy")

#: pybind11's own metaclass, and the constructors of classes that only C++ makes: stubs cannot say either.
ALLOWED = r"""
perimpm\._core\.[A-Z]\w*(\.[A-Z]\w*)?
perimpm\._core\.(FamilyStiffness|Fragment|Ledger|MeasuredStiffness|Model|Param|PassTime|Plan|Progress|Relaxation|Section)\.__init__
perimpm\._core\.Plan\.[A-Z]\w*\.__init__
"""


def run(*words: str, folder: Path) -> None:
    done = subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, check=False, cwd=folder)
    assert done.returncode == 0, done.stdout + done.stderr


def test_stubs_match_the_module(tmp_path: Path) -> None:
    (tmp_path / "allowed").write_text(ALLOWED)
    run("mypy.stubtest", "perimpm._core", "--allowlist", "allowed", "--ignore-unused-allowlist", folder=tmp_path)


def test_package_type_checks(tmp_path: Path) -> None:
    source = Path(perimpm.__file__).parent
    settings = Path(__file__).parents[2] / "pyproject.toml"
    run("mypy", "--config-file", str(settings), "-p", "perimpm", "--cache-dir", "cache", folder=tmp_path)
    assert (source / "py.typed").exists()
