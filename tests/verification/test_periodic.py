"""Periodic faces: a body that crosses them is none the wiser."""

from __future__ import annotations

import numpy as np
import pytest
from support import Array, drift, momentum_scale
from trees import LOCAL, Tree, box, scene

import perimpm

CELLS = 16
TRANSFERS = [{"type": name, "order": order} for name in ("apic", "flip") for order in (2, 3)]
NAMES = [f"{t['type']}-{t['order']}" for t in TRANSFERS]


def ring(transfer: Tree, precision: str = "double") -> Tree:
    """A bar around the periodic axis 0 <= x < 1, two cells wide between slip faces."""
    dx = 1 / CELLS
    tree = scene(LOCAL, box([0] * 3, [1, 2 * dx, 2 * dx]), dx / 2, transfer=transfer, precision=precision)
    faces = {f"{end}_{axis}": "periodic" if axis == "x" else "slip" for end in ("min", "max") for axis in "xyz"}
    tree["grid"]["domain"] = {"min": [0.0] * 3, "max": [1.0, 2 * dx, 2 * dx], "faces": faces}
    return tree


@pytest.mark.parametrize("transfer", TRANSFERS, ids=NAMES)
def test_uniform_flow_stays_uniform(transfer: Tree) -> None:
    """Through the border several times at c/3: no stress, no change of velocity."""
    tree = ring(transfer)
    tree["body"][0]["initial_velocity"] = [4.0, 0.0, 0.0]
    sim = perimpm.Simulation(tree)
    while sim.time < 0.6:
        sim.step()
    x, v = sim.particles["x"][:, 0], sim.particles["v"]
    assert x.min() > -1 / CELLS and x.max() < 1 + 1 / CELLS  # wrapped when sorted
    assert np.abs(v - [4.0, 0, 0]).max() < 1e-10
    assert np.abs(sim.particles["F"] - np.eye(3)).max() < 1e-10


@pytest.mark.parametrize("transfer", TRANSFERS, ids=NAMES)
def test_small_body_crosses_the_border(transfer: Tree) -> None:
    """A shaken block that flies through the border ends as one that flies the same way in open space."""

    def fly(start: float, closed: bool) -> tuple[perimpm.Simulation, Array]:
        dx = 1 / CELLS
        tree = scene(LOCAL, box([start, 0, 0], [start + 0.25, 0.25, 0.25]), dx / 2, transfer=transfer, dt=5e-4)
        tree["body"][0]["initial_velocity"] = [8.0, 0.0, 0.0]
        size = 1.0 if closed else 9.0
        faces = {f"{end}_{axis}": "open" for end in ("min", "max") for axis in "xyz"}
        if closed:
            faces |= {"min_x": "periodic", "max_x": "periodic"}
        tree["grid"]["domain"] = {"min": [-size] * 3, "max": [size] * 3, "faces": faces}
        sim = perimpm.Simulation(tree)
        y = sim.particles["x"][:, 1].copy()
        sim.particles["v"][:, 0] += 2 * np.sin(9 * y)
        sim.step(200)
        return sim, sim.particles.by_id("x") - [start, 0, 0]

    across, x = fly(0.5, True)
    alone, y = fly(0.5, False)
    apart = x - y
    apart[:, 0] = (apart[:, 0] + 1) % 2 - 1
    assert np.abs(apart).max() < 1e-9
    assert x[:, 0].min() < -0.5  # some have passed the border
    assert drift(across.ledger.momentum, alone.ledger.momentum, momentum_scale(alone)) < 1e-12


def travelling(cells: int, transfer: Tree) -> float:
    """Error of a wave u = A sin 2 pi (X - c t) after a period, over A: exact for fixed-corotated in uniaxial strain."""
    tree = ring(transfer)
    dx, speed, amplitude = 1 / cells, float(np.sqrt(1.2 * LOCAL["youngs_modulus"] / 1000)), 1e-3
    tree["grid"] |= {"spacing": dx}
    tree["grid"]["domain"]["max"] = [1.0, 2 * dx, 2 * dx]
    tree["body"][0] |= {"shape": box([0] * 3, [1, 2 * dx, 2 * dx]), "particle_spacing": dx / 2}
    tree["simulation"]["dt"] = dt = 0.1 * dx / speed
    sim = perimpm.Simulation(tree, threads=1)
    particles = sim.particles
    X = particles["x"][:, 0].copy()
    start = particles.by_id("x")[:, 0]
    k = 2 * np.pi
    particles["x"][:, 0] += amplitude * np.sin(k * X)
    particles["F"][:, 0, 0] += amplitude * k * np.cos(k * X)
    late = X + speed * dt / 2  # velocities live half a step before positions
    particles["v"][:, 0] = -amplitude * k * speed * np.cos(k * late)
    particles["C"][:, 0, 0] = amplitude * k * k * speed * np.sin(k * late)
    sim.step(round(1 / speed / dt))
    exact = amplitude * np.sin(k * (start - speed * sim.time))
    error = (particles.by_id("x")[:, 0] - start - exact + 0.5) % 1.0 - 0.5
    return float(np.sqrt(np.mean(error**2))) / amplitude


def test_travelling_wave_is_second_order() -> None:
    coarse, fine = (travelling(cells, {"type": "apic", "order": 2}) for cells in (16, 32))
    print(f"\ne/A {coarse:.2e} at 16 cells, {fine:.2e} at 32")
    assert np.log2(coarse / fine) >= 1.9


def test_same_bits_for_one_and_two_threads() -> None:
    tree = ring({"type": "apic", "order": 2}, "float")
    tree["body"][0]["initial_velocity"] = [4.0, 0.0, 0.0]
    states = []
    for threads in (1, 2):
        sim = perimpm.Simulation(tree, threads=threads)
        sim.particles["v"][:, 0] += np.sin(2 * np.pi * sim.particles["x"][:, 0])
        sim.step(300)
        states.append(sim.particles.by_id("x"))
    assert np.array_equal(*states)


def test_bonds_across_the_border_are_refused() -> None:
    tree = ring(TRANSFERS[0])
    tree["material"]["m"]["constitutive"] = {"type": "pd_bond", "youngs_modulus": 1e5}
    with pytest.raises(perimpm.InputError, match="bonds do not reach across periodic faces"):
        perimpm.Simulation(tree)
