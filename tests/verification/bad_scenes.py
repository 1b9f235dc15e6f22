"""Ways to spoil a good scene, and the words that the message must hold."""

from __future__ import annotations

import copy
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from trees import LOCAL, PD_BOND, PD_ELASTIC, Tree, box, scene, write

import perimpm
from perimpm.cli import main

NAN, INFINITY = float("nan"), float("inf")

BUNNY = Path(__file__).parents[2] / "scenes" / "assets" / "bunny.obj"


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


def law(key: str, value: Any, base: Tree = LOCAL) -> Callable[[Tree], Tree]:
    return lambda tree: put(tree, "material.m.constitutive", {**base, key: value})


def sheet(thickness: float | None) -> Callable[[Tree], Tree]:
    """The body becomes a sheet of a bond law."""

    def change(tree: Tree) -> Tree:
        shape = {"type": "rectangle", "corner": [0, 0, 0], "edge_u": [0.4, 0, 0], "edge_v": [0, 0.4, 0]}
        tree = put(put(tree, "body.0.shape", shape), "material.m.constitutive", PD_BOND)
        return tree if thickness is None else put(tree, "body.0.thickness", thickness)

    return change


# what is done to a good scene, and words that the message must hold: the place, then cause or remedy
CASES: dict[str, tuple[Callable[[Tree], Tree] | tuple[str, Any], list[str]]] = {
    "unknown key": (("simulation.end_tim", 1.0), ["simulation", "end_tim", "end_time"]),
    "unknown table": (("colliders", []), ["colliders", "collider"]),
    "key above its section": (("gravity", [0.0, 0.0, 0.0]), ["gravity", "did you mean 'simulation.gravity'?", "transfer"]),
    "key above its body": (("initial_velocity", [0.0, 0.0, 0.0]), ["initial_velocity", "'body.N.initial_velocity'"]),
    "key of two sections": (("friction", 0.5), ["unknown key 'friction' in the scene", "accepted: format"]),
    "unknown key of a model": (law("young_modulus", 1.0), ["material.m.constitutive", "youngs_modulus"]),
    "missing key": (("simulation.end_time", None), ["simulation", "end_time"]),
    "missing grid spacing": (("grid", None), ["spacing", "grid", "apic"]),
    "text for a number": (("simulation.end_time", "long"), ["simulation.end_time", "number"]),
    "number for a table": (("grid", 1.0), ["grid", "table"]),
    "two numbers for a vector": (("simulation.gravity", [0.0, 1.0]), ["simulation.gravity", "list of 3 numbers", "got 2"]),
    "unknown word": (("simulation.precision", "half"), ["simulation.precision", "float", "double"]),
    "later format": (("format", 2), ["format", "reads scenes of format 1", "got format 2"]),
    "negative end": (("simulation.end_time", -1.0), ["simulation.end_time", "above 0"]),
    "zero dt": (("simulation.dt", 0.0), ["simulation.dt", "above 0"]),
    "negative dt": (("simulation.dt", -1e-3), ["simulation.dt", "above 0"]),
    "dt not a number": (("simulation.dt", NAN), ["simulation.dt", "finite"]),
    "dt above the bound": (("simulation.dt", 1.0), ["simulation.dt", "stable", "auto", "allow_unstable_dt"]),
    "safety above one": (("simulation.safety", 1.5), ["simulation.safety", "at most 1"]),
    "infinite gravity": (("simulation.gravity", [0.0, -INFINITY, 0.0]), ["simulation.gravity", "finite"]),
    "zero spacing": (("grid.spacing", 0.0), ["grid.spacing", "above 0"]),
    "flat domain": (("grid.domain.max", [1.0, -1.0, 1.0]), ["grid.domain", "max"]),
    "order 4": (("transfer.order", 4), ["transfer.order", "at most 3"]),
    "order 2.5": (("transfer.order", 2.5), ["transfer", "order", "integer"]),
    "mls with linear splines": (
        ("transfer", {"type": "apic", "order": 1, "stress_divergence": "mls"}),
        ["transfer", "stress_divergence", "order"],
    ),
    "zero density": (("material.m.density", 0.0), ["material.m.density", "above 0"]),
    "negative density": (("material.m.density", -1.0), ["material.m.density", "above 0"]),
    "zero modulus": (law("youngs_modulus", 0.0), ["youngs_modulus", "above 0"]),
    "negative modulus": (law("youngs_modulus", -1.0), ["youngs_modulus", "above 0"]),
    "nu = 0.5": (law("poisson_ratio", 0.5), ["poisson_ratio", "below 0.5"]),
    "nu = 0.6": (law("poisson_ratio", 0.6), ["poisson_ratio", "below 0.5"]),
    "nu = -1": (law("poisson_ratio", -1.0), ["poisson_ratio", "above -1"]),
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
    "body beyond the reach of the grid": (
        lambda tree: put(
            put(tree, "grid.domain", None), "body.0.shape", box([8e3, 0, 0], [8000.4, 0.4, 0.4])
        ),
        ["body.0", "body 0", "6553.6", "origin", "double"],
    ),
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
    "plane that turns": (
        (
            "collider",
            [
                {
                    "angular_velocity": [0.0, 0.0, 1.0],
                    "shape": {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0]},
                }
            ],
        ),
        ["collider.0.angular_velocity", "plane", "box"],
    ),
    "more frames than have numbers": (("simulation.frame_rate", 1e12), ["simulation.frame_rate", "frames", "1e+09"]),
    "negative friction": (
        ("collider", [{"friction": -1.0, "shape": {"type": "sphere", "center": [0, 0, 0], "radius": 0.1}}]),
        ["collider.0.friction", "at least 0"],
    ),
    "missing mesh": (
        ("body.0.shape", {"type": "mesh", "file": "nowhere.obj"}),
        ["body.0.shape", "nowhere.obj", "no .obj, .ply, .stl, .gltf, .glb file"],
    ),
    "mesh with a slip": (
        ("body.0.shape", {"type": "mesh", "file": str(BUNNY.with_name("buny.obj"))}),
        ["body.0.shape", "buny.obj", "did you mean 'bunny.obj'?"],
    ),
    "mesh of a missing folder": (
        ("body.0.shape", {"type": "mesh", "file": "nowhere/bunny.obj"}),
        ["body.0.shape", "nowhere/bunny.obj", "there is no folder"],
    ),
    "sheet without thickness": (sheet(None), ["body.0", "thickness", "[m]", "rectangle"]),
    "strand without cross-section": (
        ("body.0.shape", {"type": "polyline", "points": [[0, 0, 0], [0.4, 0, 0]]}),
        ["body.0", "cross_section", "[m^2]", "polyline"],
    ),
    "thick box": (("body.0.thickness", 1e-3), ["body.0.thickness", "sheets", "rectangle", "box"]),
    "thickness below zero": (sheet(-1e-3), ["body.0.thickness", "above 0 m"]),
    "cross-section of a sheet": (
        lambda tree: put(sheet(1e-3)(tree), "body.0.cross_section", 1e-6),
        ["body.0.cross_section", "strands", "polyline"],
    ),
    "sheet with slanted edges": (
        lambda tree: put(sheet(1e-3)(tree), "body.0.shape.edge_v", [0.1, 0.3, 0.0]),
        ["body.0.shape.edge_v", "right angles"],
    ),
    "strand of one point": (
        ("body.0.shape", {"type": "polyline", "points": [[0, 0, 0]]}),
        ["body.0.shape.points", "two points"],
    ),
    "strand of flat points": (
        ("body.0.shape", {"type": "polyline", "points": [[0, 0], [0.4, 0]]}),
        ["body.0.shape.points", "[x, y, z]"],
    ),
    "strand that stands still": (
        ("body.0.shape", {"type": "polyline", "points": [[0, 0, 0], [0, 0, 0]]}),
        ["body.0.shape.points", "differ"],
    ),
    "irregular rectangle": (
        lambda tree: put(sheet(1e-3)(tree), "body.0.sampling", "poisson"),
        ["body.0.sampling", "lattice", "mesh"],
    ),
    "surface of a mesh on a lattice": (
        lambda tree: put(
            put(tree, "body.0.shape", {"type": "mesh", "file": str(BUNNY)}), "body.0.thickness", 1e-3
        ),
        ["body.0", "sampling", "poisson"],
    ),
    "sheet of a local law": (
        lambda tree: put(sheet(1e-3)(tree), "material.m.constitutive", LOCAL),
        ["body.0", "fixed_corotated", "sheet", "bond law", "pd_elastic"],
    ),
    "sheet that yields": (
        lambda tree: put(
            sheet(1e-3)(tree),
            "material.m.constitutive",
            {"type": "deviatoric_plastic", "youngs_modulus": 1e5, "yield_stress": 1e3},
        ),
        ["material.m.constitutive.yield_stress", "solids", "sheet"],
    ),
    "sheet with the Poisson's ratio of solids": (
        lambda tree: put(
            sheet(1e-3)(tree), "material.m.constitutive", {**PD_ELASTIC, "poisson_ratio": 0.25}
        ),
        ["material.m.constitutive.poisson_ratio", "1/3", "pd_lps"],
    ),
    "solid and sheet of one material": (
        lambda tree: put(sheet(1e-3)(tree), "body", [*tree["body"], sheet(1e-3)(tree)["body"][0]]),
        ["body.1", "material of their own"],
    ),
    "collider without inside": (
        (
            "collider",
            [{"shape": {"type": "rectangle", "corner": [0, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, 0, 1]}}],
        ),
        ["collider.0.shape", "rectangle", "bodies", "box"],
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
    file = write(tree, folder / "scene.toml")
    capsys.readouterr()
    code = main(["run", str(file), "-o", str(folder / "out"), "--threads", "1"])
    shown = capsys.readouterr().err
    assert code == 2, shown
    assert "error: " in shown and "Traceback" not in shown
    place = re.search(r"scene\.toml:(\d+):\d+", shown)
    line = file.read_text().splitlines()[int(place[1]) - 1] if place else ""
    for word in words:
        assert word in str(caught.value)
        # the command names a place like "body.0.shape" by file, line and column instead
        key = ([part for part in word.split(".") if not part.isdigit()] or [word])[-1]
        assert word in shown or ("." in word and key in line), f"{word!r} is neither in {shown!r} nor in {line!r}"
    assert not list(folder.glob("out/*"))
