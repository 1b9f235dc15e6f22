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
def test_bunnies_deform_and_part(law: str) -> None:
    """At 2.5 times the spacing: their centres come closer than two undeformed bunnies can, and go apart again."""
    tree = bunnies().scene(law)
    tree["grid"]["spacing"] *= 2.5
    tree["output"] = {"formats": []}
    sim = perimpm.Simulation(tree, folder=SCENES)
    left = sim.particles.by_id("x")[:, 0] < 0
    apart, stored, start = [], [], sim.ledger.kinetic
    while sim.time < 1.5:
        x = sim.particles.by_id("x")
        apart.append(float(np.linalg.norm(x[left].mean(axis=0) - x[~left].mean(axis=0))))
        stored.append(sim.ledger.elastic)
        sim.step(10)
    nearest = int(np.argmin(apart))
    print(f"\n{law}: centres {apart[0]:.3f} m, nearest {apart[nearest]:.3f} m, at the end {apart[-1]:.3f} m;"
          f" stored {max(stored) / start:.2f} of the kinetic energy")
    assert max(stored) > 0.1 * start
    assert apart[-1] > 1.25 * apart[nearest]
