"""run.json: the scene with every default, versions and seeds; enough to run it again."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from trees import PD_BOND, PD_ELASTIC, Tree, falling_box

import perimpm
from perimpm import _core
from perimpm.cli import main

BUNNY = Path(__file__).parents[2] / "scenes" / "assets" / "bunny.obj"


def with_law(law: Tree) -> Callable[[], Tree]:
    def make() -> Tree:
        tree = falling_box()
        tree["material"]["rubber"]["constitutive"] = law
        return tree

    return make


def gridless() -> Tree:
    tree = with_law({**PD_BOND, "horizon": 2.01})() | {"transfer": {"type": "particle"}}
    tree["material"]["rubber"]["fracture"] = {"type": "critical_stretch", "critical_stretch": 0.5}
    del tree["grid"], tree["output"]
    return tree


def poisson() -> Tree:
    tree = falling_box()
    del tree["body"][0]["particle_spacing"], tree["grid"]["domain"]["faces"]
    tree["body"][0] |= {"sampling": "poisson", "seed": 7, "name": "ball", "particles_per_cell": 4}
    tree["body"][0]["shape"] = {"type": "sphere", "center": [0.0, 0.8, 0.0], "radius": 0.3}
    return tree


def mesh() -> Tree:
    tree = falling_box()
    tree["body"][0]["shape"] = {"type": "mesh", "file": "bunny.obj", "scale": 3, "translation": [0.0, 0.7, 0.0]}
    tree["collider"] = [{"shape": {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0]}}]
    return tree


# the last two refuse some of their own defaults beside the calibration that they choose
SCENES: dict[str, Callable[[], Tree]] = {
    "local law": falling_box,
    "without grid": gridless,
    "poisson": poisson,
    "mesh": mesh,
    "pd_elastic": with_law(PD_ELASTIC),
    "pd_elastic, paper": with_law({"type": "pd_elastic", "calibration": "paper", "mu": 1e4, "lambda": 1e5}),
    "pd_bond, continuum": with_law({**PD_BOND, "calibration": "continuum"}),
}


def run(tree: Tree | Path, folder: Path, base: str | Path = "") -> tuple[perimpm.Simulation, dict[str, Any]]:
    sim = perimpm.Simulation(tree, folder=base)
    sim.run(frames=2, output=folder)
    return sim, json.loads((folder / "run.json").read_text())


@pytest.mark.parametrize("name", list(SCENES))
def test_the_scene_in_it_gives_the_same_run(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "here").mkdir()
    (tmp_path / "elsewhere").mkdir()
    shutil.copy(BUNNY, tmp_path / "here")
    first, record = run(SCENES[name](), tmp_path / "first", tmp_path / "here")
    monkeypatch.chdir(tmp_path / "elsewhere")
    second, again = run(record["scene"], tmp_path / "second")
    assert again["scene"] == record["scene"]
    assert (first.steps, first.time) == (second.steps, second.time)
    for field in ("x", "v"):
        assert first.particles.by_id(field).tobytes() == second.particles.by_id(field).tobytes()


def test_every_default_is_there(tmp_path: Path) -> None:
    tree = mesh()
    del tree["output"]
    shutil.copy(BUNNY, tmp_path)
    scene = run(tree, tmp_path / "out", tmp_path)[1]["scene"]
    tables = {s.topic: {p.key for p in s.keys if p.default is not None} for s in _core.scene_reference()}
    body = scene["body"][0]
    given = {"simulation": scene["simulation"], "domain": scene["grid"]["domain"], "output": scene["output"]}
    given |= {"body": body | {"particles_per_cell": None}, "mesh": body["shape"], "collider": scene["collider"][0]}
    for topic, table in given.items():
        assert tables[topic] <= set(table), topic
    assert "particles_per_cell" not in body  # particle_spacing stands in its place
    assert scene["simulation"]["safety"] == 0.8 and scene["simulation"]["dt"] == "auto"
    assert scene["output"] == {"fields": ["x", "v", "id"], "formats": ["hdf5"]}
    assert (body["name"], body["shape"]["rotation"]) == ("body 0", [0, 0, 0])
    for models, name in ((scene["transfer"], "apic"), (scene["material"]["rubber"]["constitutive"], "fixed_corotated")):
        assert set(models) == {"type"} | {p.key for p in perimpm.describe(name).sections[0][2]}


def test_versions_and_seeds(tmp_path: Path) -> None:
    shutil.copy(BUNNY, tmp_path)
    plain, meshed = (run(t, tmp_path / n, tmp_path)[1] for t, n in ((poisson(), "plain"), (mesh(), "mesh")))
    assert plain["seeds"] == {"ball": 7} and meshed["seeds"] == {}
    own = {"perimpm", "compiler", "build", "instruction set", "Eigen", "oneTBB", "HDF5", "Python"}
    assert set(plain["versions"]) == own
    assert set(meshed["versions"]) == own | {"assimp", "OpenVDB"}
    assert plain["versions"]["perimpm"] == perimpm.__version__
    assert all(meshed["versions"].values())


def test_fields_that_frames_hold_and_could_hold(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    record = run(falling_box(), tmp_path)[1]
    with h5py.File(tmp_path / "frame.0001.h5") as file:
        assert set(record["fields"]) == set(file) - {"connectivity"}
    assert record["fields"] == ["x", "v", "id", "body"]
    assert {*record["fields"], "F", "C", "mass"} <= set(record["available_fields"])


def test_a_record_runs_again_as_it_is(tmp_path: Path) -> None:
    first, record = run(falling_box(), tmp_path / "first")
    second, again = run(tmp_path / "first" / "run.json", tmp_path / "second")
    assert again["scene"] == record["scene"]
    assert first.particles.by_id("x").tobytes() == second.particles.by_id("x").tobytes()
    words = ["run", str(tmp_path / "first" / "run.json"), "--frames", "1", "-o", str(tmp_path / "third")]
    assert main([*words, "--set", "simulation.gravity=[0.0, 0.0, 0.0]"]) == 0
    assert json.loads((tmp_path / "third" / "run.json").read_text())["scene"]["simulation"]["gravity"] == [0, 0, 0]


@pytest.mark.parametrize(
    ("text", "said"), [("{", "no JSON"), ("[]", "no record of a run"), ("{}", "no record of a run: it has no 'scene'")]
)
def test_json_that_is_no_record(text: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "run.json").write_text(text)
    assert main(["run", str(tmp_path / "run.json"), "-o", str(tmp_path / "out")]) == 2
    assert f"{tmp_path / 'run.json'}: error: this is {said}" in capsys.readouterr().err
