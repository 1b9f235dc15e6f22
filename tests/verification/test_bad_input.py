"""Bad input (Must show 8, E13): each error names place, cause and remedy, the command ends with code 2, no frame
exists."""

from __future__ import annotations

import copy
import json
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import LOCAL, PD_BOND, PD_ELASTIC, Tree, box, scene

import perimpm
from perimpm.cli import main

NAN, INFINITY = float("nan"), float("inf")
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"


def good() -> Tree:
    tree = scene(LOCAL, box([0] * 3, [0.4] * 3), 0.1, precision="float")
    tree["simulation"] |= {"end_time": 0.02, "frame_rate": 50.0}
    tree["grid"]["domain"] = {"min": [-1.0] * 3, "max": [1.0] * 3}
    tree["output"] = {"formats": ["hdf5"]}
    return tree


def put(tree: Tree, path: str, value: Any) -> Tree:
    """Sets a value at "a.b.0.c"; None removes the key."""
    tree = copy.deepcopy(tree)
    *parents, last = path.split(".")
    at: Any = tree
    for key in parents:
        at = at[int(key)] if isinstance(at, list) else at.setdefault(key, {})
    if value is None:
        del at[last]
    else:
        at[int(last) if isinstance(at, list) else last] = value
    return tree


def toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(toml(item) for item in value) + "]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)


def law(key: str, value: Any, base: Tree = LOCAL) -> Callable[[Tree], Tree]:
    return lambda tree: put(tree, "material.m.constitutive", {**base, key: value})


# what is done to a good scene, and words that the message must hold: the place, then cause or remedy
CASES: dict[str, tuple[Callable[[Tree], Tree] | tuple[str, Any], list[str]]] = {
    "unknown key": (("simulation.end_tim", 1.0), ["simulation", "end_tim", "end_time"]),
    "unknown table": (("colliders", []), ["colliders", "collider"]),
    "unknown key of a model": (law("young_modulus", 1.0), ["material.m.constitutive", "youngs_modulus"]),
    "missing key": (("simulation.end_time", None), ["simulation", "end_time"]),
    "missing grid spacing": (("grid", None), ["spacing", "grid", "apic"]),
    "text for a number": (("simulation.end_time", "long"), ["simulation.end_time", "number"]),
    "number for a table": (("grid", 1.0), ["grid", "table"]),
    "two numbers for a vector": (("simulation.gravity", [0.0, 1.0]), ["simulation.gravity", "3"]),
    "unknown word": (("simulation.precision", "half"), ["simulation.precision", "float", "double"]),
    "later format": (("format", 2), ["format", "1", "2"]),
    "negative end": (("simulation.end_time", -1.0), ["simulation.end_time", "above 0"]),
    "zero dt": (("simulation.dt", 0.0), ["simulation.dt", "above 0"]),
    "negative dt": (("simulation.dt", -1e-3), ["simulation.dt", "above 0"]),
    "dt not a number": (("simulation.dt", NAN), ["simulation.dt", "finite"]),
    "dt above the bound": (("simulation.dt", 1.0), ["simulation.dt", "stable", "auto", "allow_unstable_dt"]),
    "safety above one": (("simulation.safety", 1.5), ["simulation.safety", "1"]),
    "infinite gravity": (("simulation.gravity", [0.0, -INFINITY, 0.0]), ["simulation.gravity", "finite"]),
    "zero spacing": (("grid.spacing", 0.0), ["grid.spacing", "above 0"]),
    "flat domain": (("grid.domain.max", [1.0, -1.0, 1.0]), ["grid.domain", "max"]),
    "order 4": (("transfer.order", 4), ["transfer", "order", "3"]),
    "order 2.5": (("transfer.order", 2.5), ["transfer", "order", "integer"]),
    "mls with linear splines": (
        ("transfer", {"type": "apic", "order": 1, "stress_divergence": "mls"}),
        ["transfer", "stress_divergence", "order"],
    ),
    "zero density": (("material.m.density", 0.0), ["material.m.density", "above 0"]),
    "negative density": (("material.m.density", -1.0), ["material.m.density", "above 0"]),
    "zero modulus": (law("youngs_modulus", 0.0), ["youngs_modulus", "above 0"]),
    "negative modulus": (law("youngs_modulus", -1.0), ["youngs_modulus", "above 0"]),
    "nu = 0.5": (law("poisson_ratio", 0.5), ["poisson_ratio", "0.5"]),
    "nu = 0.6": (law("poisson_ratio", 0.6), ["poisson_ratio", "0.5"]),
    "nu = -1": (law("poisson_ratio", -1.0), ["poisson_ratio", "-1"]),
    "another ratio from the paper's law": (law("poisson_ratio", 0.3, PD_ELASTIC), ["poisson_ratio", "1/4", "pd_lps"]),
    "horizon below the spacing": (law("horizon", 0.9, PD_BOND), ["horizon", "above 1"]),
    "paper's calibration without mu": (law("calibration", "paper", PD_ELASTIC), ["calibration", "paper"]),
    "zero critical stretch": (
        lambda tree: put(
            law("horizon", 2.01, PD_BOND)(tree),
            "material.m.fracture",
            {"type": "critical_stretch", "critical_stretch": 0.0},
        ),
        ["critical_stretch", "above 0"],
    ),
    "infinite critical stretch": (
        lambda tree: put(
            law("horizon", 2.01, PD_BOND)(tree),
            "material.m.fracture",
            {"type": "critical_stretch", "critical_stretch": INFINITY},
        ),
        ["critical_stretch", "finite"],
    ),
    "fracture without bonds": (
        ("material.m.fracture", {"type": "critical_stretch", "critical_stretch": 0.1}),
        ["material.m.fracture", "bonds", "fixed_corotated"],
    ),
    "local law without grid": (
        ("transfer", {"type": "particle"}),
        ["material.m.constitutive", "fixed_corotated", "particle", "apic"],
    ),
    "closed faces without grid": (
        lambda tree: put(put(tree, "material.m.constitutive", PD_BOND), "transfer", {"type": "particle"}),
        ["transfer", "particle", "faces", "open", "colliders"],
    ),
    "two spacings under one bond law": (
        lambda tree: put(
            law("horizon", 2.01, PD_BOND)(tree),
            "body",
            [*tree["body"], {**tree["body"][0], "particle_spacing": 0.05}],
        ),
        ["body.1", "spacing", "material"],
    ),
    "empty scene": (lambda tree: {}, ["format"]),
    "no body": (("body", []), ["body", "nothing to simulate"]),
    "no body, a collider": (
        lambda tree: put(
            put(tree, "body", None), "collider", [{"shape": {"type": "sphere", "center": [0, 0, 0], "radius": 1}}]
        ),
        ["body", "nothing to simulate"],
    ),
    "unknown material": (("body.0.material", "n"), ["body.0.material", "'n'", "m"]),
    "unknown shape": (("body.0.shape.type", "bax"), ["body.0.shape", "bax", "box"]),
    "body without end": (
        ("body.0.shape", {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0]}),
        ["body.0.shape", "plane", "collider"],
    ),
    "box inside out": (("body.0.shape.max", [-1.0, 1.0, 1.0]), ["body.0.shape", "max"]),
    "body without particles": (("body.0.shape", box([0] * 3, [1e-3] * 3)), ["body.0", "no particle", "spacing"]),
    "body outside the domain": (("body.0.shape", box([3] * 3, [3.4] * 3)), ["body.0", "outside", "domain"]),
    "body larger than the domain": (("body.0.shape", box([-2] * 3, [2] * 3)), ["body.0", "outside", "domain"]),
    "start velocity not a number": (
        ("body.0.initial_velocity", [NAN, 0.0, 0.0]),
        ["body.0.initial_velocity", "finite"],
    ),
    "infinite spin": (
        ("body.0.initial_angular_velocity", [0.0, INFINITY, 0.0]),
        ["initial_angular_velocity", "finite"],
    ),
    "zero radius": (
        ("collider", [{"shape": {"type": "sphere", "center": [0, 0, 0], "radius": 0.0}}]),
        ["collider.0.shape", "radius", "above 0"],
    ),
    "plane without normal": (
        ("collider", [{"shape": {"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 0]}}]),
        ["collider.0.shape", "normal"],
    ),
    "negative friction": (
        ("collider", [{"friction": -1.0, "shape": {"type": "sphere", "center": [0, 0, 0], "radius": 0.1}}]),
        ["collider.0.friction", "at least 0"],
    ),
    "missing mesh": (
        ("body.0.shape", {"type": "mesh", "file": "nowhere.obj"}),
        ["body.0.shape", "nowhere.obj", "folder"],
    ),
    "unknown law": (("material.m.constitutive.type", "fixed_corotatd"), ["material.m.constitutive", "fixed_corotated"]),
    "unknown transfer": (("transfer.type", "apci"), ["transfer", "apci", "apic"]),
    "unknown output field": (("output.fields", ["x", "stress"]), ["output", "stress"]),
    "frames without positions": (("output.fields", ["v"]), ["output", "x"]),
    "unknown format": (("output.formats", ["vtk"]), ["output.formats", "vtk", "hdf5"]),
}


def spoil(case: str) -> Tree:
    change = CASES[case][0]
    return change(good()) if callable(change) else put(good(), *change)


def require_refused(tree: Tree, words: list[str], folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By the package and by the command, with every word in both messages."""
    with pytest.raises(perimpm.InputError) as caught:
        perimpm.Simulation(tree, folder=folder).run(output=folder / "out")
    file = folder / "scene.toml"
    file.write_text("".join(f"{key} = {toml(value)}\n" for key, value in tree.items()))
    capsys.readouterr()
    code = main(["run", str(file), "-o", str(folder / "out"), "--threads", "1"])
    shown = capsys.readouterr().err
    assert code == 2, shown
    assert "error: " in shown and "Traceback" not in shown
    for word in words:
        assert word in str(caught.value)
        # the command names the place by file, line and column instead
        assert word in shown or ("." in word and re.search(r"scene\.toml:\d+:\d+", shown))
    assert not list(folder.glob("out/*.h5*"))


@pytest.mark.parametrize("case", list(CASES))
def test_refused(case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    require_refused(spoil(case), CASES[case][1], tmp_path, capsys)


def test_the_good_scene_runs(tmp_path: Path) -> None:
    perimpm.Simulation(good()).run(output=tmp_path / "out")
    assert (tmp_path / "out" / "frame.0002.h5").exists()


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("empty", "", ["mesh.obj"]),
        ("noise", "v 0 0\nf one two\n", ["mesh.obj"]),
        ("open", TETRAHEDRON + "f 1 3 2\nf 1 2 4\nf 1 4 3\n", ["mesh.obj", "open", "edge"]),
        ("index out of range", TETRAHEDRON + "f 1 3 9\n", ["mesh.obj"]),
        ("not a number", "v nan 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", ["mesh.obj"]),
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
    assert main(["run", str(tmp_path / "no.toml")]) == 2
    assert "no.toml" in capsys.readouterr().err


def compile_plugin(folder: Path, source: str) -> None:
    compiler = shutil.which("g++") or shutil.which("c++")
    if not compiler:
        pytest.skip("no compiler")
    (folder / "constitutive").mkdir()
    file = folder / "stranger.cpp"
    file.write_text(source)
    subprocess.run(
        [compiler, "-shared", "-fPIC", str(file), "-o", str(folder / "constitutive" / "stranger.so")], check=True
    )


STAMP = 'extern "C" __attribute__((visibility("default"))) const struct { char magic[8]; unsigned rest[64]; } '
PLUGINS = {
    "no stamp": ("int nothing;", ["stranger.so", "perimpm_abi_stamp"]),
    "wrong stamp": (STAMP + 'perimpm_abi_stamp = {"perimpm", {999}};', ["stranger.so", "rebuild"]),
    "foreign stamp": (STAMP + 'perimpm_abi_stamp = {"another", {1}};', ["stranger.so"]),
}


@pytest.mark.parametrize("name", list(PLUGINS))
def test_plugin_that_does_not_fit(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    source, words = PLUGINS[name]
    plugins = tmp_path / "plugins"
    plugins.mkdir()
    compile_plugin(plugins, source)
    monkeypatch.setenv("PERIMPM_PLUGIN_PATH", str(plugins))
    tree = put(good(), "material.m.constitutive", {"type": "stranger"})
    require_refused(tree, ["material.m.constitutive", *words], tmp_path, capsys)


def test_plugin_that_is_no_library(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "constitutive").mkdir()
    (tmp_path / "constitutive" / "stranger.so").write_text("not a library")
    monkeypatch.setenv("PERIMPM_PLUGIN_PATH", str(tmp_path))
    tree = put(good(), "material.m.constitutive", {"type": "stranger"})
    require_refused(tree, ["material.m.constitutive", "stranger.so"], tmp_path, capsys)


@pytest.mark.parametrize("law", [LOCAL, PD_BOND], ids=["fixed_corotated", "pd_bond"])
@pytest.mark.parametrize("field", ["v", "x"])
def test_not_a_number_during_a_run(law: Tree, field: str, tmp_path: Path) -> None:
    sim = perimpm.Simulation(put(put(good(), "material.m.constitutive", law), "simulation.end_time", 1.0))
    sim.step(3)
    sim.particles[field][5, 1] = np.nan
    with pytest.raises(perimpm.SimulationError, match="finite|not a number"):
        sim.run(output=tmp_path / "out")
    assert not list((tmp_path / "out").glob("frame.*"))  # the next frame lay behind the fault
    assert (tmp_path / "out" / "failed.h5").exists()
    assert json.loads((tmp_path / "out" / "run.json").read_text())["status"] == "failed"


def test_command_ends_with_3_when_a_run_fails(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A step a hundred times too long, accepted by name."""
    tree = put(put(good(), "simulation.dt", 0.5), "simulation.allow_unstable_dt", True)
    tree = put(put(tree, "body.0.initial_angular_velocity", [0.0, 3.0, 0.0]), "grid.domain", None)
    tree["simulation"] |= {"end_time": 500.0, "frame_rate": 0.02}
    file = tmp_path / "scene.toml"
    file.write_text("".join(f"{key} = {toml(value)}\n" for key, value in tree.items()))
    assert main(["run", str(file), "-o", str(tmp_path / "out"), "--threads", "1"]) == 3
    assert "simulation failed" in capsys.readouterr().err
    assert (tmp_path / "out" / "failed.h5").exists()
