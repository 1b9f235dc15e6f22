"""README's scenes and scripts run as they stand: pieces of scenes below the first scene, scripts in the repository."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import perimpm

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "README.md").read_text()
COARSE = ["grid.spacing=0.05"]


def blocks(language: str) -> list[str]:
    fenced = re.findall(r"^```(\w*)\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
    return [text for name, text in fenced if name == language]


FIRST, *PIECES = blocks("toml")
SCRIPTS = blocks("python")


def test_blocks_are_found() -> None:
    assert FIRST.startswith("format = 1") and len(PIECES) == 3 and len(SCRIPTS) == 2


@pytest.mark.parametrize("piece", ["", *PIECES, "".join(PIECES)], ids=["first", "sheet", "crack", "condition", "all"])
def test_scene(piece: str, tmp_path: Path) -> None:
    file = tmp_path / "box.toml"
    file.write_text(FIRST + piece)
    perimpm.Simulation(file, COARSE).run(frames=2, output=tmp_path)
    assert (tmp_path / "frame.0002.h5").exists()


def test_the_other_criterion(tmp_path: Path) -> None:
    """The one behind the comment sign, in place of the one before it."""
    crack = next(piece for piece in PIECES if "# fracture = " in piece)
    swapped = re.sub(r"^fracture = .*\n# fracture", "fracture", crack, flags=re.MULTILINE)
    assert swapped != crack
    (tmp_path / "box.toml").write_text(FIRST + swapped)
    assert perimpm.Simulation(tmp_path / "box.toml", COARSE).plan.materials[1].criterion == "critical_stretch"


@pytest.mark.parametrize("script", SCRIPTS, ids=["first", "conditions"])
def test_script(script: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = (ROOT / "scenes" / "falling_box.toml").read_text()
    (tmp_path / "scenes").mkdir()
    (tmp_path / "scenes" / "falling_box.toml").write_text(scene.replace("end_time = 1.0", "end_time = 0.3"))
    monkeypatch.chdir(tmp_path)
    exec(compile(script, "README.md", "exec"), {})
    assert list(tmp_path.glob("out/*/frame.0008.h5"))


def test_the_mistake_is_answered_as_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shown = next(block for block in blocks("") if "youngs_module" in block).rstrip(" .\n")
    monkeypatch.chdir(tmp_path)
    Path("box.toml").write_text(FIRST.replace("youngs_modulus", "youngs_module"))
    with pytest.raises(perimpm.InputError) as caught:
        perimpm.Simulation("box.toml")
    assert str(caught.value).startswith(shown)


def test_scene_and_readme_agree_on_the_time_that_the_bunnies_take() -> None:
    time = re.search(r"The bunnies .*?take (\d+ s)", TEXT, re.DOTALL)
    assert time and f" {time[1]} on two cores" in (ROOT / "scenes" / "bunnies.toml").read_text().partition("\n")[0]
