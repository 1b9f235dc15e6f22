"""The scenes that ship: each can be assembled, and the main one does what its title says."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import perimpm

SCENES = Path(__file__).parents[2] / "scenes"


def bunnies() -> ModuleType:
    spec = importlib.util.spec_from_file_location("bunnies", SCENES / "bunnies.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("file", sorted(SCENES.glob("*.toml")), ids=lambda file: file.stem)
def test_every_scene_can_be_assembled(file: Path) -> None:
    plan = perimpm.Simulation(file).plan
    assert plan.particles > 0 and plan.dt > 0 and not plan.warnings


def test_file_and_script_are_one_scene() -> None:
    tomllib = pytest.importorskip("tomllib")
    tree = tomllib.loads((SCENES / "bunnies.toml").read_text())
    assert tree == bunnies().scene("pd_elastic")
    assert perimpm.Simulation(SCENES / "bunnies.toml").plan.particles >= 50_000
    assert tree["simulation"]["end_time"] * tree["simulation"]["frame_rate"] >= 36


@pytest.mark.parametrize("law", ["pd_elastic", "fixed_corotated"])
@pytest.mark.parametrize("meet", [True, False])
def test_bunnies_deform_and_part(law: str, meet: bool) -> None:
    """At 2.5 times the spacing, until one nears the floor: each is thrown back the way it came, and on the way they store
    half of their energy as they deform. Nothing of that without the other in the way."""
    tree = bunnies().scene(law)
    tree["grid"]["spacing"] *= 2.5
    tree["output"] = {"formats": []}
    if not meet:
        tree["body"][0]["shape"]["translation"] = [-0.55, 0.45, 1.5]
    sim = perimpm.Simulation(tree, folder=SCENES)
    left = sim.particles.by_id("x")[:, 0] < 0
    start, stored = sim.ledger.kinetic, 0.0
    while sim.particles["x"][:, 1].min() > tree["grid"]["spacing"]:
        sim.step(2)
        stored = max(stored, sim.ledger.elastic)
    v = sim.particles.by_id("v")[:, 0]
    speeds = float(v[left].mean()), float(v[~left].mean())
    print(f"\n{law}: along x {speeds[0]:.2f} and {speeds[1]:.2f} m/s, stored {stored / start:.1e} of the kinetic energy")
    if meet:
        assert speeds[0] < -1 and speeds[1] > 1 and stored > 0.5 * start
    else:
        assert speeds == pytest.approx((3, -3), abs=1e-2) and stored < 1e-3 * start
