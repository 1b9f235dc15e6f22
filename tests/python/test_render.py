"""Pictures: light on a known shape, and the road from frames to PNG and MP4."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import perimpm
from perimpm.cli import main
from perimpm.render import first_peak, first_share, in_sight, missing_parts, pieces
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


def test_the_camera_lets_few_strays_go() -> None:
    """A cube that turns and loses its last forty particles, and a small body far away."""
    cube, small = lattice((0, 0, 0), (10, 10, 10), 0.1), lattice((50, 0, 0), (52, 2, 2), 0.1)
    start, bodies = np.concatenate([cube, small]), np.repeat([0, 1], [len(cube), len(small)])
    x = start.copy()
    x[:1000] = x[:1000] @ [[0, -1, 0], [1, 0, 0], [0, 0, 1]] + [3, 0, 0]
    assert in_sight(x, start, bodies).all()
    x[960:1000] += [0, 40, 0]
    assert np.flatnonzero(~in_sight(x, start, bodies)).tolist() == list(range(960, 1000))
    x[500:1000] = x[500:1000] + [0, 40, 0]  # half of it is no stray
    assert in_sight(x, start, bodies).mean() >= 0.95
    three = lattice((0, 0, 0), (3, 1, 1), 0.1)
    assert in_sight(three + np.array([[0, 0, 0], [0, 0, 0], [0, 9, 0]]), three, np.zeros(3, int)).all()
    spread = cube * [3, 1, 3]  # a pile that runs apart has a front, but no strays
    assert in_sight(spread, cube, np.zeros(1000, int)).all()


def test_first_peak() -> None:
    assert first_peak(np.array([0.0, 0.1, 0.0, 6.0, 8.0, 7.0, 9.0, 1.0])) == 4
    assert first_peak(np.array([0.0, 1.0, 2.0])) == 2
    assert first_peak(np.array([3.0])) == 0


def test_first_share() -> None:
    assert first_share(np.array([0, 1, 3, 9, 9]), 1 / 3) == 2
    assert first_share(np.array([0, 6]), 1.0) == 1


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


def test_particles_without_the_field_are_grey(tmp_path: Path) -> None:
    """A field of two bodies, on a scale for one of them."""
    h5py = pytest.importorskip("h5py")
    pytest.importorskip("matplotlib")
    from perimpm.frames import FrameFolder
    from perimpm.render import WITHOUT, _FieldColors

    with h5py.File(tmp_path / "frame.0000.h5", "w") as frame:
        frame["x"], frame["damage"] = np.zeros((4, 3)), [0.0, 0.5, np.nan, np.nan]
        frame["damage"].attrs["unit"] = "1"
    painter = _FieldColors(FrameFolder(tmp_path), [0], "damage")
    colors = painter.albedo(0)
    assert colors[2:] == pytest.approx(np.array(WITHOUT * 2).reshape(2, 3) ** 2.2)
    assert np.ptp(colors[:2], axis=1).min() > 0.05
    assert painter._scale.startswith("damage: ") and painter._scale.endswith("grey: lacks it")


@needs_gl
def test_colliders_stand_where_they_are() -> None:
    """A quarter turn about the pivot (1, 0, 0) and a move along y: the corner (2, 0, 0) goes to (1, 3, -1)."""
    from perimpm.scenery import obstacles

    shape = {"type": "box", "min": [0, 0, 0], "max": [2, 1, 1]}
    moving = {"velocity": [0, 1, 0], "angular_velocity": [0, np.pi / 6, 0], "pivot": [1, 0, 0], "shape": shape}
    floor = {"shape": {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0]}}
    wall = {"shape": {"type": "plane", "point": [0, 0, 0], "normal": [1, 0, 0]}}
    found = obstacles({"collider": [floor, moving, wall]}, np.zeros(3), np.ones(3))
    assert [o.bounded for o in found] == [True, False]  # the floor is the stage's own
    assert found[0].placement(3.0) @ [2, 0, 0, 1] == pytest.approx([1, 3, -1, 1])
    found[0].cover(0.05)
    covered = found[0].points(0.0)
    assert covered.min(axis=0) == pytest.approx([0, 0, 0], abs=0.02) and covered.max(axis=0) == pytest.approx([2, 1, 1], abs=0.02)


@needs_gl
@pytest.mark.parametrize("kind", ["sphere", "box", "cylinder", "mesh"])
def test_colliders_are_drawn(kind: str, box: dict[str, Any], tmp_path: Path) -> None:
    """A grey body in front of the backdrop covers what was seen there."""
    from PIL import Image

    low, high = [-0.3, 0.2, 0.5], [0.3, 0.8, 0.9]
    bunny = str(Path(__file__).parents[2] / "scenes" / "assets" / "bunny.obj")
    shapes: dict[str, dict[str, Any]] = {
        "sphere": {"center": [0, 0.4, 0.8], "radius": 0.3},
        "box": {"min": low, "max": high},
        "cylinder": {"start": [-0.4, 0.4, 0.8], "end": [0.4, 0.4, 0.8], "radius": 0.2},
        "mesh": {"file": bunny, "scale": 4, "translation": [0, 0.1, 0.8]},
    }
    box["collider"] = [{"shape": {"type": kind, **shapes[kind]}}]
    perimpm.Simulation(box).run(frames=1, output=tmp_path)
    pictures = []
    for _ in range(2):
        assert main(["render", str(tmp_path), "--size", "320x180"]) == 0
        pictures.append(np.asarray(Image.open(tmp_path / "pictures" / "frame.0001.png")).astype(int))
        record = tmp_path / "run.json"
        record.write_text(record.read_text().replace('"collider"', '"no collider"'))
    changed = np.abs(pictures[0] - pictures[1]).max(axis=2) > 25
    assert changed.mean() > 0.02


@needs_gl
def test_unknown_field_and_empty_folder(box: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", str(tmp_path)]) == 2
    assert "no frames" in capsys.readouterr().err
    perimpm.Simulation(box).run(frames=1, output=tmp_path)
    assert main(["render", str(tmp_path), "--color", "J"]) == 2
    shown = capsys.readouterr().err
    assert "no field 'J'" in shown and "Add it" not in shown and "F, " in shown
    assert main(["render", str(tmp_path), "--color", "C"]) == 2
    assert "Add it to output.fields" in capsys.readouterr().err
    assert main(["render", str(tmp_path), "--frames", "7"]) == 2
    assert "none of the frames" in capsys.readouterr().err


def test_missing_packages_are_named(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    find = __import__("importlib.util").util.find_spec
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "pyvista" else find(name))
    assert main(["render", "anywhere"]) == 2
    assert "pip install 'perimpm[render]'" in capsys.readouterr().err
