"""Bad input (E13): each error names place, cause and remedy, the command ends with code 2, no frame
exists."""

from __future__ import annotations

from pathlib import Path

import pytest
from bad_scenes import CASES, good, put, require_refused, spoil
from trees import write

import perimpm
from perimpm.cli import main

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"


@pytest.mark.parametrize("case", list(CASES))
def test_refused(case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    require_refused(spoil(case), CASES[case][1], tmp_path, capsys)


def test_the_good_scene_runs(tmp_path: Path) -> None:
    perimpm.Simulation(good()).run(output=tmp_path / "out")
    assert (tmp_path / "out" / "frame.0002.h5").exists()


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("empty", "", ["mesh.obj", "cannot be read", "too small"]),
        ("noise", "v 0 0\nf one two\n", ["mesh.obj", "cannot be read", "face index"]),
        ("open", TETRAHEDRON + "f 1 3 2\nf 1 2 4\nf 1 4 3\n", ["mesh.obj", "open", "edge"]),
        ("index out of range", TETRAHEDRON + "f 1 3 9\n", ["mesh.obj", "cannot be read", "out of range"]),
        ("not a number", "v nan 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", ["mesh.obj", "3 vertices", "finite"]),
    ],
)
def test_broken_mesh(
    name: str, text: str, words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "mesh.obj").write_text(text)
    require_refused(put(good(), "body.0.shape", {"type": "mesh", "file": "mesh.obj"}), words, tmp_path, capsys)


def test_syntax_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scene.toml"
    file.write_text("format = 1\n[simulation\n")
    assert main(["run", str(file)]) == 2
    assert "scene.toml:2" in capsys.readouterr().err


def test_missing_scene(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(good(), tmp_path / "bar.toml")
    assert main(["run", str(tmp_path / "baar.toml")]) == 2
    shown = capsys.readouterr().err
    assert "baar.toml: error: there is no such scene" in shown and "did you mean 'bar.toml'?" in shown


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("material.mm.density=900", ["--set material.mm.density", "no material 'mm'", "did you mean 'm'?", "accepted: m"]),
        ("gravity=0", ["unknown key 'gravity'", "did you mean 'simulation.gravity'?"]),
    ],
)
def test_override_beside_the_mark(
    change: str, words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(perimpm.InputError) as caught:
        perimpm.Simulation(good(), [change])
    assert main(["explain", str(write(good(), tmp_path / "bar.toml")), "--set", change]) == 2
    shown = capsys.readouterr().err
    for word in words:
        assert word in str(caught.value) and word in shown
