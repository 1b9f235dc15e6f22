"""The number of threads does not change a bit of the frames (E14)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from trees import LOCAL, PD_BOND, PD_ELASTIC, Tree, box, scene

import perimpm

H, DX = 0.025, 0.05  # m
SOFT: Tree = {"youngs_modulus": 2e4}
FLOOR: Tree = {"shape": {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0]}, "friction": 0.3}
VON_MISES: Tree = {"type": "von_mises", "poisson_ratio": 0.3, "yield_stress": 300.0, "hardening": 1e3}
BALL: Tree = {"shape": {"type": "sphere", "center": [0.2, 0.1, 0.2], "radius": 0.1}, "velocity": [0.0, 0.0, 0.5]}


def thrown(tree: Tree, fields: list[str], **more: Any) -> Tree:
    """Falls at 2 m/s on a floor at y = 0 or on what `more` adds, with six frames."""
    tree["simulation"] |= {"end_time": 0.1, "frame_rate": 50.0, "gravity": [0.0, -9.81, 0.0]}
    tree["output"] = {"formats": ["hdf5"], "fields": fields}
    for body in tree["body"]:
        body["initial_velocity"] = [0.3, -2.0, 0.1]
        body["initial_angular_velocity"] = [1.0, 2.0, 3.0]
    return tree | more


def block_of(law: Tree, precision: str = "float", transfer: Tree | None = None) -> Tree:
    shape = box([0, 0.02, 0], [0.4, 0.42, 0.4])
    return scene({**law, **SOFT}, shape, H, dx=DX, precision=precision, transfer=transfer)


def yielding(law: Tree) -> Tree:
    """Some families yield where the block hits the floor, others do not. The spacing is a power of two: families lie in
    slices, and go one by one where they yield."""
    return scene({**law, **SOFT, "yield_stress": 3e3}, box([0, 0.03125, 0], [0.375, 0.40625, 0.375]), 0.03125, dx=0.0625)


def mixed() -> Tree:
    laws = {"a": {**LOCAL, **SOFT}, "b": {**PD_ELASTIC, **SOFT}, "c": {**PD_BOND, **SOFT}}
    bodies = [("a", box([0, 0.2, 0], [0.3, 0.5, 0.3])), ("b", box([0.3, 0.2, 0], [0.6, 0.5, 0.3]))]
    bodies += [("c", box([0, 0.2, 0.3], [0.6, 0.5, 0.5]))]
    return scene(laws, bodies, H, dx=DX, precision="float")


def breaking(transfer: str, law: Tree = PD_BOND, fracture: Tree | None = None, **material: Any) -> Tree:
    tree = block_of(law, transfer={"type": transfer})
    tree["material"]["m"] |= material
    tree["material"]["m"]["fracture"] = fracture or {"type": "critical_stretch", "critical_stretch": 0.02}
    return tree


def pieces() -> Tree:
    """Cut along planes, beside bodies that stay whole: crack surfaces touch all of them."""
    tree = mixed()
    for name in ("b", "c"):
        tree["material"][name]["fracture"] = {"type": "plane_cut", "threshold": 0.03}
    return tree


COMMON = ["x", "v", "id"]
SCENES = {
    "fixed_corotated": lambda: thrown(block_of(LOCAL), [*COMMON, "F", "C"], collider=[FLOOR]),
    "fixed_corotated double flip": lambda: thrown(
        block_of(LOCAL, "double", {"type": "flip", "order": 3}), COMMON, collider=[FLOOR]
    ),
    "von_mises": lambda: thrown(block_of(VON_MISES), [*COMMON, "F", "plastic_strain"], collider=[FLOOR]),
    "pd_elastic": lambda: thrown(block_of(PD_ELASTIC), [*COMMON, "force"], collider=[FLOOR]),
    "deviatoric_plastic yielding": lambda: thrown(
        yielding({"type": "deviatoric_plastic"}), [*COMMON, "force", "has_yielded"], collider=[FLOOR]
    ),
    "pd_lps yielding": lambda: thrown(
        yielding({"type": "pd_lps", "yield": "family"}), [*COMMON, "force", "has_yielded"], collider=[FLOOR]
    ),
    "pd_bond": lambda: thrown(block_of(PD_BOND), [*COMMON, "force"], collider=[FLOOR]),
    "pd_bond without grid": lambda: thrown(block_of(PD_BOND, transfer={"type": "particle"}), COMMON, collider=[FLOOR]),
    "mixed, colliders": lambda: thrown(mixed(), [*COMMON, "body"], collider=[FLOOR, BALL]),
    "fracture": lambda: thrown(breaking("apic"), [*COMMON, "broken_bonds"], collider=[FLOOR]),
    "plane_cut, other bodies": lambda: thrown(pieces(), [*COMMON, "fragment"], collider=[FLOOR, BALL]),
    "fracture in fields": lambda: thrown(
        breaking("apic", crack_surface="fragment"), [*COMMON, "broken_bonds"], collider=[FLOOR]
    ),
    "fracture by energy": lambda: thrown(
        breaking("apic", PD_ELASTIC, {"type": "energy", "fracture_energy": 0.5}),
        [*COMMON, "broken_bonds"],
        collider=[FLOOR],
    ),
    "fracture without grid": lambda: thrown(breaking("particle"), [*COMMON, "broken_bonds"], collider=[FLOOR]),
}


def frames(tree: Tree, threads: int, folder: Path) -> dict[str, np.ndarray]:
    perimpm.Simulation(tree, threads=threads).run(output=folder)
    values: dict[str, np.ndarray] = {}
    for file in sorted(folder.glob("frame.*.h5")):
        with h5py.File(file) as h5:
            names: list[str] = []
            h5.visit(names.append)
            values |= {f"{file.name}/{name}": h5[name][()] for name in names if isinstance(h5[name], h5py.Dataset)}
    return values


@pytest.mark.parametrize("name", list(SCENES))
def test_threads_do_not_change_a_bit(name: str, tmp_path: Path) -> None:
    one, two = (frames(SCENES[name](), threads, tmp_path / str(threads)) for threads in (1, 2))
    assert one.keys() == two.keys()
    assert len({key.split("/")[0] for key in one}) == 6
    for key in one:
        assert one[key].tobytes() == two[key].tobytes(), key
    last = {key.rpartition("/")[2]: value for key, value in one.items() if key.startswith("frame.0006")}
    assert np.isfinite(last["x"]).all()
    if name == "von_mises":
        assert 0.01 < last["plastic_strain"].max()
    if "yielding" in name:
        assert 0.02 < np.mean(last["has_yielded"]) < 0.98
    if "fracture" in name:
        assert 0 < last["broken_bonds"].sum() < last["broken_bonds"].size * 122


def test_the_same_input_twice(tmp_path: Path) -> None:
    first, second = (frames(SCENES["mixed, colliders"](), 2, tmp_path / str(run)) for run in (1, 2))
    assert all(first[key].tobytes() == second[key].tobytes() for key in first)
