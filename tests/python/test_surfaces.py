"""Meshes of fragments."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from trees import Tree, box, scene

import perimpm
from perimpm.cli import main


def cut_cube(fields: list[str]) -> Tree:
    half = {"shape": {"type": "plane", "point": [0.2, 0, 0], "normal": [1.0, 0, 0]}}
    tree = scene({"type": "pd_bond", "youngs_modulus": 1e5}, box([0] * 3, [0.4] * 3), 0.05, crack=[half])
    tree["simulation"] |= {"end_time": 0.1, "frame_rate": 10.0}
    return tree | {"output": {"fields": fields}}


def objects(file: Path) -> dict[str, float]:
    """Volume of each object of an OBJ file."""
    points: list[list[float]] = []
    volumes: dict[str, float] = {}
    name = ""
    for line in file.read_text().splitlines():
        kind, *words = line.split()
        if kind == "o":
            name = words[0]
            volumes[name] = 0.0
        elif kind == "v":
            points.append([float(word) for word in words])
        else:
            a, b, c = (np.array(points[int(word) - 1]) for word in words)
            volumes[name] += float(a @ np.cross(b, c)) / 6
    return volumes


def test_an_object_per_fragment(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    perimpm.Simulation(cut_cube(["x", "fragment"])).run(output=tmp_path, frames=2)
    assert main(["surface", str(tmp_path)]) == 0
    files = [Path(line) for line in capsys.readouterr().out.split()]
    assert [file.name for file in files] == ["frame.0001.obj", "frame.0002.obj"]
    for file in files:
        volumes = objects(file)
        assert len(volumes) == 2
        assert all(name.startswith("fragment_") for name in volumes)
        assert list(volumes.values()) == pytest.approx([0.032, 0.032], rel=0.1)


def test_frames_without_pieces_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    perimpm.Simulation(cut_cube(["x"])).run(output=tmp_path, frames=1)
    assert main(["surface", str(tmp_path)]) == 2
    assert "output.fields" in capsys.readouterr().err
