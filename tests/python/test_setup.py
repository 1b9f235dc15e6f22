"""What the scripts say when a command of theirs does not finish."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

SETUP = Path(__file__).parents[2] / ".ci" / "setup.sh"
pytestmark = pytest.mark.skipif(not shutil.which("bash"), reason="no bash")


def logged(root: Path, command: str) -> subprocess.CompletedProcess[str]:
    script = 'set -euo pipefail; root=$1; source "$2"; logged try.log sh -c "$3"; echo ready'
    return subprocess.run(["bash", "-c", script, "-", root, SETUP, command], capture_output=True, text=True, check=False)


def test_a_command_that_finishes_says_so_in_its_log(tmp_path: Path) -> None:
    seen = logged(tmp_path, "echo one")
    assert (seen.returncode, seen.stdout, seen.stderr) == (0, "ready\n", "")
    first, *middle, last = (tmp_path / "build" / "try.log").read_text().splitlines()
    assert first.endswith(": sh -c echo one") and middle == ["one"] and last == "== finished"


@pytest.mark.parametrize(
    ("command", "why"),
    [
        ("echo two; exit 3", "exit code 3"),
        ("echo two; kill -9 $$", "killed from outside by signal 9; run again"),
        ("echo two; kill -TERM $PPID; sleep 1", "stopped from outside; run again"),
        ("echo two; echo 'c++: fatal error: Killed signal terminated program cc1plus'; exit 1", "a process in it was killed"),
    ],
)
def test_a_command_that_does_not_finish(command: str, why: str, tmp_path: Path) -> None:
    logged(tmp_path, "echo one")
    seen = logged(tmp_path, command)
    assert seen.returncode == 1 and "ready" not in seen.stdout
    shown = seen.stderr.splitlines()
    assert "two" in shown and "one" not in shown
    assert shown[-1].startswith(f"== did not finish: {why}") and "try.log, which is of this attempt only" in shown[-1]
    assert f"== did not finish: {why}" in (tmp_path / "build" / "try.log").read_text().splitlines()[-1]
