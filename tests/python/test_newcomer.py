"""What a first user stumbles over: the command says what happened and what to do."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from trees import Tree, write

import perimpm
from perimpm.cli import main


@pytest.mark.parametrize("key", ["body.0.particle_spacing", "grid.spacing"])
@pytest.mark.parametrize("spacing", [2e-4, 1e-5, 1e-9])
@pytest.mark.parametrize("shape", ["box", "sphere"])
def test_a_tiny_spacing_is_answered_at_once(box: Tree, key: str, spacing: float, shape: str) -> None:
    """The leanest case, 0.11 m^3 at 0.2 mm: 1.4e10 particles, 2 TB."""
    if key == "grid.spacing":
        del box["body"][0]["particle_spacing"]
    if shape == "sphere":
        box["body"][0]["shape"] = {"type": "sphere", "center": [0.0, 0.8, 0.0], "radius": 0.3}
    start = time.perf_counter()
    with pytest.raises(perimpm.InputError, match=f"body 'body 0'.* particles.* GB.*{key.rpartition('.')[2]}"):
        perimpm.Simulation(box, [f"{key}={spacing}"])
    assert time.perf_counter() - start < 2


def test_bodies_count_together(box: Tree) -> None:
    """Eighty bodies of which one alone would fit into 2 % of the memory of this machine."""
    import os

    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    box["body"][0]["particle_spacing"] = (0.6**3 * 150 / (0.02 * memory)) ** (1 / 3)
    thin = {"type": "box", "min": [-0.3, 0.5, -0.3], "max": [0.3, 1.1, 0.3]}
    box["body"] = [{**box["body"][0], "shape": thin} for _ in range(80)]
    box["body"][0]["particle_spacing"] *= 0.25  # 64 times as many: more than there is room for
    with pytest.raises(perimpm.InputError, match="brings the scene to about"):
        perimpm.Simulation(box)


def test_a_run_says_what_it_replaces(scene_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    words = ["run", str(scene_file), "-o", str(out), "--frames", "2"]
    assert main(words) == 0
    assert "replacing" not in capsys.readouterr().err
    (out / "pictures").mkdir()
    for name in ("frame.0001.png", "frame.0024.png", "poster.png", "animation.mp4", "mine.png"):
        (out / "pictures" / name).touch()
    assert main(words) == 0
    assert f"replacing the 2 frames of an earlier run in {out}" in capsys.readouterr().err
    assert [f.name for f in (out / "pictures").iterdir()] == ["mine.png"]


def test_a_body_inside_a_collider_is_mentioned_once(box: Tree, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """6 of 12 layers lie below y = 0.8."""
    box["collider"] = [{"name": "floor", "shape": {"type": "plane", "point": [0, 0.8, 0], "normal": [0, 1, 0]}}]
    file = write(box, tmp_path / "box.toml")
    assert main(["run", str(file), "-o", str(tmp_path / "out"), "--frames", "1"]) == 0
    message = "warning: 864 of 1728 particles of body 'body 0' start inside collider 'floor'"
    assert capsys.readouterr().err.count(message) == 1
    with pytest.warns(UserWarning, match="864 of 1728 particles"):
        perimpm.Simulation(box)


SLIPS = {
    "no closing quote": ('type = "apic"', 'type = "apic', [":10:", "closing quote"]),
    "no quotes": ('type = "apic"', "type = apic", [":10:", "needs quotes"]),
    "one bracket": ("[[body]]", "[body]", [":14:", "'body'", "list", "[[body]]"]),
    "bare law": ('{ type = "pd_elastic", youngs_modulus = 5e4 }', '"pd_elastic"', ['{ type = "pd_elastic", ... }']),
    "bare shape": ('{ type = "sphere", center = [0, 1, 0], radius = 0.2 }', '"sphere"', ['{ type = "sphere", ... }']),
    "no format": ("format = 1\n", "\n", ["format = 1", "above the first"]),
    "comma": ("spacing = 0.1", "spacing = 0,1", [":8:", "point"]),
    "open header": ("[transfer]", "[transfer", [":9:", "brackets"]),
}
SCENE = """format = 1

[simulation]
end_time = 1
gravity = [0, -9.81, 0]

[grid]
spacing = 0.1
[transfer]
type = "apic"
[material.jelly]
density = 1000
constitutive = { type = "pd_elastic", youngs_modulus = 5e4 }
[[body]]
material = "jelly"
shape = { type = "sphere", center = [0, 1, 0], radius = 0.2 }
"""


@pytest.mark.parametrize("slip", list(SLIPS))
def test_slips_of_the_pen(slip: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    old, new, words = SLIPS[slip]
    assert old in SCENE
    file = tmp_path / "first.toml"
    file.write_text(SCENE.replace(old, new))
    assert main(["explain", str(file)]) == 2
    shown = capsys.readouterr().err
    assert "first.toml" in shown
    for word in words:
        assert word in shown, shown


def test_describe_lists_what_it_knows(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["describe"]) == 0
    shown = capsys.readouterr().out
    for word in ("scene", "simulation", "body", "collider", "pd_elastic", "apic", "critical_stretch"):
        assert word in shown
    assert main(["describe", "bodi"]) == 2
    shown = capsys.readouterr().err
    assert "did you mean 'body'" in shown and "collider" in shown and "pd_elastic" in shown


@pytest.mark.parametrize(("topic", "word"), [("body", "sampling"), ("mesh", "rotation"), ("transfer", "blend")])
def test_describe_a_table_or_a_family(topic: str, word: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["describe", topic]) == 0
    assert word in capsys.readouterr().out


def test_the_first_frame_knows_no_eta(scene_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(scene_file), "-o", str(tmp_path / "out"), "--frames", "2"]) == 0
    first, second = [line for line in capsys.readouterr().err.splitlines() if line.startswith("frame ")]
    assert first.startswith("frame 1/2") and first.endswith("ETA unknown")
    assert second.endswith("ETA 0 s")


def test_a_material_without_bodies_is_mentioned(box: Tree) -> None:
    """As a slip in an override makes one."""
    law = '{ type = "fixed_corotated", youngs_modulus = 2e5, poisson_ratio = 0.2 }'
    with pytest.warns(UserWarning, match="no body is of material 'ruber'"):
        perimpm.Simulation(box, [f"material.ruber={{ density = 900.0, constitutive = {law} }}"])


def test_linear_splines_are_warned_of(box: Tree) -> None:
    box["transfer"]["order"] = 1
    assert any("transfer.order = 1" in text for text in perimpm.Simulation(box).plan.warnings)
    box["transfer"]["order"] = 2
    assert not perimpm.Simulation(box).plan.warnings
