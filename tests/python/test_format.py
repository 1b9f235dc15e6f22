"""The C++ sources look as .clang-format says."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_sources_are_formatted() -> None:
    program = Path(sys.executable).with_name("clang-format")
    files = [file for folder in ("core", "plugins", "bindings", "tests") for file in (ROOT / folder).rglob("*.[ch]pp")]
    assert len(files) > 200
    done = subprocess.run([program, "--dry-run", "--Werror", *files], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
