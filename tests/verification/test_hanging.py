"""Sheets and strands at rest and in motion: stretched by their weight, folded by two pins, with few bonds or none."""

from __future__ import annotations

import numpy as np
import pytest
from trees import Tree, scene

import perimpm

G, YOUNG, DENSITY, H, LENGTH = 9.81, 1e6, 1000.0, 0.02, 1.0
LAWS: dict[str, Tree] = {
    "pd_bond": {"type": "pd_bond", "youngs_modulus": YOUNG},
    "pd_elastic": {"type": "pd_elastic", "youngs_modulus": YOUNG},
    "pd_lps": {"type": "pd_lps", "youngs_modulus": YOUNG},
}
STRAND: Tree = {"type": "polyline", "points": [[0, LENGTH, 0], [0, 0, 0]]}
SHEET: Tree = {"type": "rectangle", "corner": [0, 0, 0], "edge_u": [0.4, 0, 0], "edge_v": [0, LENGTH, 0]}


@pytest.mark.parametrize("law", LAWS)
def test_strand_stretched_by_its_weight(law: str) -> None:
    """u = rho g d (L - d/2) / E at the depth d below the clamped end of length L, whatever the cross-section."""
    tree = scene(LAWS[law], dict(STRAND), H, gravity=(0.0, -G, 0.0), transfer={"type": "particle"})
    tree["body"][0]["cross_section"] = 1e-6
    clamp = {"type": "box", "min": [-1, LENGTH - 3.1 * H, -1], "max": [1, 2, 1]}
    tree["condition"] = [{"shape": clamp, "clamped": True}]
    sim = perimpm.Simulation(tree, threads=1)
    start = sim.particles["x"].copy()
    sim.relax(1e-5)
    moved = start[:, 1] - sim.particles["x"][:, 1]
    depth = start[start[:, 1] < LENGTH - 3.1 * H, 1].max() + H / 2 - start[:, 1]
    free = depth.max() + H / 2
    expected = DENSITY * G * depth * (free - depth / 2) / YOUNG
    middle = (depth > 0.2) & (depth < 0.8)
    slope = np.polyfit(expected[middle], moved[middle], 1)[0]
    print(f"strand of {law}: stiffness over the closed form {1 / slope:.4f}")
    assert slope == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("transfer", ["apic", "flip", "particle"])
def test_a_cloth_on_two_pins(transfer: str) -> None:
    """It swings below the pins, folds, and stays whole: no NaN, no bond longer than its stiffness allows."""
    law = {"type": "pd_elastic", "youngs_modulus": YOUNG, "bending_ratio": 0.3}
    tree = scene(law, dict(SHEET), H, gravity=(0.0, -G, 0.0), transfer={"type": transfer}, precision="float")
    tree["body"][0] |= {"thickness": 1e-3, "shape": SHEET | {"edge_v": [0, 0, 0.4]}}
    tree["condition"] = [
        {"shape": {"type": "sphere", "center": [x, 0, 0], "radius": 2.2 * H}, "clamped": True} for x in (0.0, 0.4)
    ]
    sim = perimpm.Simulation(tree, threads=1)
    start = sim.particles.by_id("x")
    while sim.time < 0.3:  # a plate would pass below its hinges after 0.31 s
        sim.step(50)
    x = sim.particles.by_id("x")
    assert np.isfinite(x).all() and np.isfinite(sim.particles["v"]).all()
    pinned = np.linalg.norm(x - start, axis=1) < 1e-9
    assert pinned.sum() == 2 * 4
    assert x[:, 1].min() < -0.3
    rows = np.sqrt(len(x)).astype(int)
    edges = np.linalg.norm(np.diff(x.reshape(rows, rows, 3), axis=1), axis=2)
    assert edges.max() < 1.5 * H


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("count", [1, 2])
def test_few_particles_fly(law: str, count: int) -> None:
    """One particle without a bond, two of one bond each."""
    tree = scene(
        LAWS[law], {"type": "polyline", "points": [[0, 0, 0], [count * H, 0, 0]]}, H, gravity=(0.0, -G, 0.0), dt=1e-4
    )
    tree["body"][0] |= {"cross_section": 1e-6, "initial_velocity": [1.0, 0.0, 0.0]}
    sim = perimpm.Simulation(tree, threads=1)
    assert len(sim.particles["x"]) == count
    start = sim.particles["x"].copy()
    sim.step(1000)
    expected = start + [0.1, -0.5 * G * 0.1**2, 0.0]
    assert sim.particles["x"] == pytest.approx(expected, abs=1e-3 * 0.1)
