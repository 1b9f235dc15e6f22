"""What a scene does not need is not there: read from a process of its own, out of its memory map and its
allocated arrays, not from a printout."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from trees import LOCAL, PD_BOND, PD_ELASTIC, Tree, box, scene

import perimpm

PROBE = """
import json, sys
import perimpm
sim = perimpm.Simulation(*json.loads(sys.argv[1]), threads=1)
frames = 2 if len(sys.argv) > 2 else None
sim.run(frames=frames, output=sys.argv[2]) if frames else sim.step(2)
libraries = {line.split()[-1].rpartition("/")[2] for line in open("/proc/self/maps") if ".so" in line}
fields = set(sim.particles)
for material in sim.plan.materials:
    fields |= set(sim.particles.of(material.name))
print(json.dumps({"libraries": sorted(libraries), "fields": sorted(fields), "arrays": [a.name for a in sim.plan.arrays],
                  "passes": [p.name for p in sim.pass_times], "bytes": {a.name: a.bytes for a in sim.plan.arrays},
                  "opened": sim.plan.libraries}))
"""


@dataclass
class Seen:
    libraries: list[str]
    fields: list[str]
    arrays: list[str]
    passes: list[str]
    bytes: dict[str, int]
    opened: list[str]

    def maps(self, part: str) -> bool:
        return any(part in name for name in self.libraries)

    def holds(self, part: str) -> bool:
        return any(part in name for name in self.arrays)


def probe(scene: Tree | Path, *arguments: str, overrides: list[str] | None = None) -> Seen:
    """In a process of its own; with an argument the run writes two frames there."""
    what = json.dumps([str(scene) if isinstance(scene, Path) else scene, overrides or []])
    done = subprocess.run(
        [sys.executable, "-c", PROBE, what, *arguments], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return Seen(**json.loads(done.stdout))


BUNNIES = Path(__file__).parents[2] / "scenes" / "bunnies.toml"


def block(law: Tree, **more: Any) -> Tree:
    return scene(law, box([0] * 3, [0.4] * 3), 0.1, precision="float", **more)


def test_local_law_has_no_bonds() -> None:
    seen = probe(block(LOCAL))
    assert "F" in seen.fields and seen.maps("fixed_corotated.so") and seen.maps("apic.so")
    for absent in ("bonds", "force", "positions by four", "grid order"):
        assert not seen.holds(absent)
    for absent in ("pd_elastic.so", "pd_bond.so", "critical_stretch.so", "flip.so", "pic.so", "particle.so"):
        assert absent not in seen.libraries
    assert "bond forces" not in seen.passes


@pytest.mark.parametrize(("law", "other"), [(PD_ELASTIC, "pd_bond.so"), (PD_BOND, "pd_elastic.so")])
def test_bond_law_has_no_deformation_gradient(law: Tree, other: str) -> None:
    seen = probe(block(law))
    assert seen.maps(law["type"] + ".so") and seen.holds("bonds.neighbour")
    assert "F" not in seen.fields and not seen.holds(".F")
    assert not seen.maps("fixed_corotated.so")
    assert not seen.maps(other)
    assert "bond forces" in seen.passes


def test_one_line_swaps_what_the_bunnies_hold() -> None:
    coarse = "grid.spacing=0.04"
    swap = 'material.rubber.constitutive={ type = "fixed_corotated", youngs_modulus = 2e5, poisson_ratio = 0.25 }'
    bonded, local = (probe(BUNNIES, overrides=[coarse, *more]) for more in ([], [swap]))
    assert bonded.maps("pd_elastic.so") and bonded.holds("rubber.bonds.neighbour")
    assert not bonded.maps("fixed_corotated.so") and "F" not in bonded.fields
    assert local.maps("fixed_corotated.so") and "F" in local.fields and local.holds("rubber.F")
    assert not local.maps("pd_elastic.so") and not local.holds("bonds")


def test_one_spring_per_bond_needs_no_mean_deformation() -> None:
    assert probe(block(PD_ELASTIC)).holds("mean_deformation")
    seen = probe(block({**PD_ELASTIC, "bending_ratio": 0.0}))
    assert not seen.holds("mean_deformation") and not seen.holds("shape_inverse")


@pytest.mark.parametrize("law", [LOCAL, PD_ELASTIC])
def test_no_meshes_no_files(law: Tree) -> None:
    seen = probe(block(law))
    for absent in ("assimp", "openvdb", "perimpm_mesh", "hdf5"):
        assert not seen.maps(absent)


@pytest.mark.parametrize("part", ["crack", "condition", "collider"])
def test_meshes_of_every_part_are_in_the_plan(part: str, tmp_path: Path) -> None:
    file = tmp_path / "wall.obj"
    corners = [(x, y, z) for x in (0.2, 0.9) for y in (-1, 1) for z in (-1, 1)]
    faces = ((1, 2, 4), (1, 4, 3), (5, 7, 8), (5, 8, 6), (1, 5, 6), (1, 6, 2), (3, 4, 8), (3, 8, 7), (1, 3, 7), (1, 7, 5))
    faces = (*faces, (2, 6, 8), (2, 8, 4))
    file.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {a} {b} {c}\n" for a, b, c in faces))
    table: Tree = {"shape": {"type": "mesh", "file": str(file)}} | ({"clamped": True} if part == "condition" else {})
    seen = probe(block(PD_BOND, **{part: [table]}))
    assert seen.maps("openvdb") and "module/mesh" in seen.opened


def test_files_open_hdf5_only(tmp_path: Path) -> None:
    tree = block(LOCAL) | {"output": {"formats": ["hdf5"]}}
    seen = probe(tree, str(tmp_path / "out"))
    assert seen.maps("hdf5") and not seen.maps("assimp") and not seen.maps("openvdb")


def test_no_criterion_no_flags() -> None:
    seen = probe(block(PD_BOND))
    assert not seen.holds("bonds.broken") and "broken_bonds" not in seen.fields and "fracture" not in seen.passes
    tree = block(PD_BOND)
    tree["material"]["m"]["fracture"] = {"type": "critical_stretch", "critical_stretch": 0.1}
    seen = probe(tree)
    assert seen.holds("bonds.broken") and "broken_bonds" in seen.fields and "fracture" in seen.passes


def test_transfers_hold_what_they_use() -> None:
    seen = {name: probe(block(LOCAL, transfer={"type": name})) for name in ("pic", "flip", "apic")}
    assert [name for name in seen if "C" in seen[name].fields] == ["apic"]
    # flip keeps the velocities before forces beside those after: twice the grid
    assert seen["flip"].bytes["grid"] == 2 * seen["apic"].bytes["grid"]
    assert seen["pic"].bytes["grid"] == seen["apic"].bytes["grid"]


def test_particles_without_grid() -> None:
    seen = probe(block(PD_BOND, transfer={"type": "particle"}))
    for absent in ("C", "grid", "m.grid order"):
        assert absent not in seen.arrays
    assert not {"sort", "clear grid", "grid update", "gather"} & set(seen.passes)


def test_no_colliders_no_pass() -> None:
    assert "particle collisions" not in probe(block(LOCAL)).passes
    floor = {"shape": {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]}}
    assert "particle collisions" in probe(block(LOCAL, collider=[floor])).passes


@pytest.mark.parametrize(("law", "checked"), [(LOCAL, set()), (PD_BOND, {"pd_bond.so"})])
def test_material_without_bodies_is_not_there(law: Tree, checked: set[str]) -> None:
    """A law that nobody uses is opened to check its parameters, and that is all."""
    tree = block(LOCAL)
    tree["material"]["unused"] = {"density": 2000.0, "constitutive": dict(law)}
    seen, plain = probe(tree), probe(block(LOCAL))
    assert set(seen.libraries) ^ set(plain.libraries) == checked
    assert (seen.fields, seen.arrays, seen.passes, seen.bytes) == (plain.fields, plain.arrays, plain.passes, plain.bytes)


@pytest.mark.parametrize(("criterion", "arrays"), [("critical_stretch", set()), ("energy", {"energies of bonds"})])
def test_criterion_adds_its_own_only(criterion: str, arrays: set[str]) -> None:
    """The rest of the elastic block is the same with and without."""
    plain = probe(block(PD_ELASTIC))
    tree = block(PD_ELASTIC)
    tree["material"]["m"]["fracture"] = {"type": criterion, "fracture_energy": 1e9}
    seen = probe(tree)
    assert set(seen.libraries) - set(plain.libraries) == {f"{criterion}.so"}
    assert set(seen.fields) - set(plain.fields) == {"broken_bonds", "damage"}
    assert set(seen.arrays) - set(plain.arrays) == {"m.bonds.broken"} | arrays
    assert set(seen.passes) - set(plain.passes) == {"fracture"}
    for part in ("libraries", "fields", "arrays", "passes"):
        assert set(getattr(plain, part)) < set(getattr(seen, part))
    assert {name: seen.bytes[name] for name in plain.arrays} == plain.bytes


def test_collider_adds_its_own_only() -> None:
    floor = {"shape": {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0]}}
    plain, seen = probe(block(LOCAL)), probe(block(LOCAL, collider=[floor]))
    assert set(seen.passes) - set(plain.passes) == {"particle collisions"}
    assert (seen.libraries, seen.fields, seen.bytes) == (plain.libraries, plain.fields, plain.bytes)


@pytest.mark.parametrize("law", [LOCAL, PD_BOND, {"type": "pd_correspondence", "law": LOCAL}], ids=lambda law: law["type"])
def test_plan_lists_the_plugins_that_are_mapped(law: Tree) -> None:
    tree = block(law)
    stretch = {"type": "critical_stretch", "critical_stretch": 0.1}
    tree["material"]["unused"] = {"density": 2000.0, "constitutive": dict(PD_ELASTIC), "fracture": stretch}
    seen = probe(tree)
    built_in = {f"{name}.so" for names in perimpm.plugins().values() for name in names}
    listed = {name.rpartition("/")[2] + ".so" for name in seen.opened if not name.startswith("module/")}
    assert {"pd_elastic.so", "critical_stretch.so", law["type"] + ".so"} < listed
    assert listed == built_in & set(seen.libraries)


def test_explain_says_the_same() -> None:
    deformation = "deformation gradient F and stress (no SVD)", "no law of this scene asks for F"
    bonds = "bond families and bond forces", "no law of this scene asks for bonds"
    for law, absent, present in ((PD_ELASTIC, deformation, bonds), (LOCAL, bonds, deformation)):
        skipped = [(item.what, item.why) for item in perimpm.Simulation(block(law)).plan.skipped]
        assert absent in skipped and present not in skipped
