"""A cantilever under its weight: what surface treatments do to bending."""

from __future__ import annotations

import numpy as np
import pytest
from trees import Tree, box, scene

import perimpm

YOUNG, DENSITY, GRAVITY, LENGTH, WIDTH = 2e7, 1000.0, 10.0, 0.8, 0.2
BENDING = DENSITY * GRAVITY * WIDTH**2 * LENGTH**4 / (8 * YOUNG * WIDTH**4 / 12)
SHEAR = DENSITY * GRAVITY * LENGTH**2 / (2 * 5 / 6 * YOUNG / 2.5)  # nu = 1/4
CLOSED_FORM = BENDING + SHEAR  # Timoshenko's beam, 1 % of the length
LAWS = ("pd_bond", "pd_elastic", "pd_lps")


def sag(law: str, across: int, **parameters: object) -> float:
    """Of the tip over the closed form, `across` particles wide and deep; held are all behind x = 0, a face of particles."""
    h = WIDTH / across
    model: Tree = {"type": law, "youngs_modulus": YOUNG, **parameters}
    tree = scene(model, box([-4 * h, 0, 0], [LENGTH, WIDTH, WIDTH]), h, transfer={"type": "particle"})
    tree["simulation"] |= {"gravity": [0, -GRAVITY, 0], "precision": "double"}
    tree["condition"] = [{"shape": {"type": "plane", "point": [0, 0, 0], "normal": [1, 0, 0]}, "clamped": True}]
    simulation = perimpm.Simulation(tree, threads=1)
    X = simulation.particles.by_id("x").copy()
    simulation.relax(residual=1e-5)
    tip = X[:, 0] > LENGTH - 1.01 * h
    return float((X - simulation.particles.by_id("x"))[tip, 1].mean()) / CLOSED_FORM


@pytest.mark.parametrize("law", LAWS)
def test_default_weights_converge(law: str) -> None:
    """One-sided families see the strain nearer to the middle than their particles are: soft, less so on finer lattices, with an
    order between first and second."""
    coarse, fine = sag(law, 4) - 1, sag(law, 8) - 1
    print(f"\n{law}: sag over the closed form {1 + coarse:.3f} at 4 particles, {1 + fine:.3f} at 8")
    assert 0 < fine <= 0.11
    assert 3 <= coarse / fine <= 4.5


@pytest.mark.slow
def test_table_of_surfaces() -> None:
    """The other treatments converge to their lattice's stiffness."""
    for law in LAWS:
        error = {}
        for across in (4, 8, 12):
            row = {surface: sag(law, across, surface=surface) for surface in ("none", "family", "moment", "ghost")}
            print(f"\n{across} particles, {law}: " + ", ".join(f"{name} {value:.3f}" for name, value in row.items()), end="")
            error[across] = row["moment"] - 1
        order = np.log(error[8] / error[12]) / np.log(1.5)
        print(f"\n{law}, moment: order {order:.2f}", end="")
        assert 1.5 <= order <= 2.2
