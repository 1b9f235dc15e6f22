"""Pictures: light on a known shape, and the road from frames to PNG and MP4."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import perimpm
from perimpm.cli import main
from perimpm.render import first_peak, missing_parts, pieces
from perimpm.shading import Lighting, blur, spacing_of

needs_gl = pytest.mark.skipif(bool(missing_parts()), reason=missing_parts())


def lattice(low: tuple[int, int, int], high: tuple[int, int, int], h: float) -> Any:
    axes = [np.arange(a, b) * h for a, b in zip(low, high)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)


def test_spacing_of_a_lattice() -> None:
    assert spacing_of(lattice((0, 0, 0), (9, 9, 9), 0.02)) == pytest.approx(0.02)


def test_blur_keeps_the_sum() -> None:
    grid = np.zeros((21, 21), np.float32)
    grid[10, 10] = 3.0
    soft = blur(grid, 3, (0, 1))
    assert soft.sum() == pytest.approx(3.0, rel=1e-5)
    assert soft.max() < 0.1
    assert np.allclose(soft, soft[::-1, ::-1], atol=1e-6)


def test_top_is_lit_and_bottom_is_not() -> None:
    x = lattice((0, 0, 0), (20, 20, 20), 0.01) + [0.0, 0.01, 0.0]
    light = Lighting(x, 0.01, 0.0)
    shine, seen = light.particle_light(), x[light.seen]
    inner = (np.abs(seen[:, [0, 2]] - 0.095) < 0.05).all(axis=1)
    top, bottom = inner & (seen[:, 1] > 0.195), inner & (seen[:, 1] < 0.015)
    assert shine[top].mean() > 3 * shine[bottom].mean()
    assert len(seen) < len(x)  # what is buried is not drawn


def test_floor_is_dark_below_a_body() -> None:
    x = lattice((-10, 0, -10), (10, 20, 10), 0.01) + [0.0, 0.01, 0.0]
    floor = Lighting(x, 0.01, 0.0).floor_light(np.zeros(2), 1.0, 200)
    assert floor[100, 100].mean() < 0.5 * floor[5, 5].mean()


def test_pieces() -> None:
    a, b = lattice((0, 0, 0), (5, 5, 5), 0.1), lattice((20, 0, 0), (25, 5, 5), 0.1)
    label = pieces(np.concatenate([a, b]))
    assert len(set(label[:125])) == len(set(label[125:])) == 1
    assert label[0] != label[125]


def test_first_peak() -> None:
    assert first_peak(np.array([0.0, 0.1, 0.0, 6.0, 8.0, 7.0, 9.0, 1.0])) == 4
    assert first_peak(np.array([0.0, 1.0, 2.0])) == 2
    assert first_peak(np.array([3.0])) == 0


@needs_gl
def test_render(box: dict[str, Any], tmp_path: Path) -> None:
    from PIL import Image

    perimpm.Simulation(box).run(output=tmp_path)
    assert main(["render", str(tmp_path), "--size", "320x180", "--frames", "2-3", "--color", "v"]) == 0
    made = tmp_path / "pictures"
    assert sorted(f.name for f in made.iterdir()) == ["animation.mp4", "frame.0002.png", "frame.0003.png", "poster.png"]
    picture = np.asarray(Image.open(made / "frame.0002.png")).astype(int)
    assert picture.shape == (180, 320, 3)
    grey = np.abs(picture - picture.mean(axis=2, keepdims=True)).max(axis=2) < 20
    assert 0.01 < 1 - grey.mean() < 0.9  # coloured particles on a grey floor
    assert (made / "animation.mp4").stat().st_size > 1000


@needs_gl
def test_unknown_field_and_empty_folder(box: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", str(tmp_path)]) == 2
    assert "no frames" in capsys.readouterr().err
    perimpm.Simulation(box).run(frames=1, output=tmp_path)
    assert main(["render", str(tmp_path), "--color", "J"]) == 2
    assert "no field 'J'" in capsys.readouterr().err
    assert main(["render", str(tmp_path), "--frames", "7"]) == 2
    assert "none of the frames" in capsys.readouterr().err


def test_missing_packages_are_named(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    find = __import__("importlib.util").util.find_spec
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "pyvista" else find(name))
    assert main(["render", "anywhere"]) == 2
    assert "pip install 'perimpm[render]'" in capsys.readouterr().err
