"""Fragments part cleanly, meet again, and momentum is kept (D8)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support import momentum_scale
from trees import Tree, box, scene

import perimpm

YOUNG, DENSITY, SPACING, SIDE = 1e6, 1000.0, 0.1, 24
WAVE = float(np.sqrt(1.2 * YOUNG / DENSITY))  # nu = 1/4
SPEED = 0.01 * WAVE
MIDDLE = SIDE * SPACING / 2


def cut_bar(horizon: float = 3.015, order: int = 2, width: int = 4, **material: Any) -> perimpm.Simulation:
    """A bar of SIDE x width x width particles, cut in the middle of its length."""
    law: Tree = {"type": "pd_bond", "youngs_modulus": YOUNG, "horizon": horizon}
    shape = box([0, 0, 0], [SIDE * SPACING, width * SPACING, width * SPACING])
    crack = {"shape": {"type": "plane", "point": [MIDDLE, 0.0, 0.0], "normal": [1.0, 0.0, 0.0]}}
    tree = scene(law, shape, SPACING, transfer={"type": "apic", "order": order}, crack=[crack])
    tree["material"]["m"] |= material
    return perimpm.Simulation(tree, threads=1)


def throw(sim: perimpm.Simulation, velocity: Any) -> np.ndarray:
    """Gives the halves opposite velocities; which particles are in the right one."""
    right = sim.particles["x"][:, 0] > MIDDLE
    sim.particles["v"][:] = np.where(right[:, None], velocity, np.negative(velocity))
    return right


def halves(sim: perimpm.Simulation, right: np.ndarray) -> tuple[float, float]:
    """Relative velocity along x of the halves' masses, and the largest difference of a particle from its half's."""
    v = sim.particles["v"]
    one, other = v[right].mean(axis=0), v[~right].mean(axis=0)
    apart = max(float(np.max(np.abs(v[right] - one))), float(np.max(np.abs(v[~right] - other))))
    return float(one[0] - other[0]), apart


FLIGHTS = [
    ("particle", 2, 3.015),
    ("particle", 3, 2.2),
    ("particle", 3, 4.015),
    ("particle", 2, 2.2),
    ("fragment", 2, 2.2),
    ("fragment", 2, 3.015),
    ("fragment", 3, 2.2),
    ("fragment", 3, 3.015),
]


@pytest.mark.parametrize(("path", "order", "horizon"), FLIGHTS)
def test_halves_fly_apart_as_they_are(path: str, order: int, horizon: float) -> None:
    """D8a: each half moves rigidly, the gap is 2 v t, whatever horizon and kernel are: fragments share no node."""
    sim = cut_bar(horizon, order, crack_surface=path)
    right = throw(sim, [SPEED, 0, 0])
    gap = float(np.ptp(sim.particles["x"][:, 0]))
    for steps in (10, 90):
        sim.step(steps)
        relative, apart = halves(sim, right)
        print(f"\n{path}, order {order}, {steps} steps: relative velocity {relative / (2 * SPEED) - 1:.1e}, apart {apart / SPEED:.1e}")
        assert abs(relative / (2 * SPEED) - 1) <= 1e-6
        assert apart <= 1e-6 * SPEED
    opened = float(np.ptp(sim.particles["x"][:, 0])) - gap
    assert opened == pytest.approx(2 * SPEED * sim.time, rel=1e-6)


def test_on_the_grid_halves_stick() -> None:
    """What the two paths are for: on one grid the halves take most of their relative velocity away from each other."""
    sim = cut_bar(crack_surface="grid")
    right = throw(sim, [SPEED, 0, 0])
    sim.step(10)
    relative, _ = halves(sim, right)
    print(f"\non the grid: relative velocity {relative / (2 * SPEED):.3f} of what it was")
    assert relative < 0.9 * 2 * SPEED


@pytest.mark.parametrize(("path", "sticks_to"), [("particle", 0), ("fragment", 0), ("grid", 4)])
def test_sticking_distance(path: str, sticks_to: int) -> None:
    """How far halves must have opened before they no longer take velocity from each other: on the grid until no two particles
    share a node, which are then three cells (6 spacings, a gap of 5) apart."""
    reach = 0
    for gap in range(7):
        sim = cut_bar(crack_surface=path)
        sim.particles["x"][sim.particles["x"][:, 0] > MIDDLE, 0] += gap * SPACING
        sim.step(1)
        right = throw(sim, [SPEED, 0, 0])
        sim.step(10)
        relative, _ = halves(sim, right)
        print(f"\n{path}, gap {gap} h: relative velocity {relative / (2 * SPEED):.6f}", end="")
        if abs(relative / (2 * SPEED) - 1) > 1e-6:
            reach = gap
    assert reach == sticks_to


@pytest.mark.parametrize("path", ["particle", "fragment"])
def test_halves_that_meet_rebound(path: str) -> None:
    """Thrown at each other: they never overlap by more than half a spacing, and part again with their momentum."""
    sim = cut_bar(crack_surface=path)
    right = throw(sim, [-5 * SPEED, 0, 0])
    scale = momentum_scale(sim)
    before = np.sum(sim.particles["mass"][:, None] * sim.particles["v"], axis=0)
    deepest, speed = 0.0, 0.0
    for _ in range(60):
        sim.step(5)
        x = sim.particles["x"][:, 0]
        deepest = max(deepest, SPACING - float(np.min(x[right]) - np.max(x[~right])))
        speed, _ = halves(sim, right)
    after = np.sum(sim.particles["mass"][:, None] * sim.particles["v"], axis=0)
    print(f"\n{path}: deepest {deepest / SPACING:.2f} h, relative velocity after {speed / (10 * SPEED):.2f} of before")
    assert 0 < deepest <= 0.5 * SPACING
    assert speed > 0.5 * 10 * SPEED
    assert len(sim.fragments) == 2  # D8e: they do not bond again
    assert np.max(np.abs(after - before)) <= 1e-12 * scale


@pytest.mark.parametrize("path", ["particle", "fragment"])
def test_halves_slide_past_each_other(path: str) -> None:
    """D8b: tangential velocities, pressed together: no overlap beyond half a spacing. There is no friction, but faces of
    particles are as rough as a lattice: meeting, they turn a tenth of the motion along them into vibration."""
    sim = cut_bar(width=8, crack_surface=path)
    right = throw(sim, [-0.2 * SPEED, SPEED, 0])
    sim.step(200)
    v, x = sim.particles["v"], sim.particles["x"][:, 0]
    sliding = float(np.mean(v[right][:, 1]) - np.mean(v[~right][:, 1])) / (2 * SPEED)
    print(f"\n{path}: sliding {sliding:.3f} of what it was after {2 * SPEED * sim.time / SPACING:.2f} h")
    assert 0.85 < sliding < 1
    assert SPACING - float(np.min(x[right]) - np.max(x[~right])) <= 0.5 * SPACING


@pytest.mark.parametrize("path", ["particle", "fragment"])
@pytest.mark.parametrize("law", ["pd_bond", "pd_elastic", "pd_lps"])
@pytest.mark.parametrize(("safety", "swing"), [(0.8, 0.024), (0.5, 0.012), (0.25, 0.006)])
def test_breaking_up_keeps_momentum(law: str, path: str, safety: float, swing: float) -> None:
    """D8c: a stretching, flying bar breaks by itself; D8d: nothing is lost on the way. The energy's swing is that of an explicit
    step: of first order in it where steps are fine."""
    tree = scene({"type": law, "youngs_modulus": YOUNG}, box([0, 0, 0], [1.6, 0.4, 0.4]), SPACING)
    tree["material"]["m"] |= {"fracture": {"type": "critical_stretch", "critical_stretch": 0.05}, "crack_surface": path}
    tree["simulation"]["safety"] = safety
    sim = perimpm.Simulation(tree, threads=1)
    x = sim.particles["x"]
    sim.particles["v"][:, 0] = 0.25 * WAVE * np.sign(x[:, 0] - 0.8) * (np.abs(x[:, 0] - 0.8) > 0.2)
    sim.particles["v"][:, 1] = 0.05 * WAVE
    scale, before = momentum_scale(sim), np.array(sim.ledger.momentum)
    mass = float(np.sum(sim.particles["mass"]))
    totals = []
    for _ in range(300):
        sim.step(1)
        totals.append(sim.ledger.kinetic + sim.ledger.elastic)
    drift = float(np.max(np.abs(np.array(sim.ledger.momentum) - before))) / scale
    growth = float(np.max(np.array(totals) - np.minimum.accumulate(totals))) / totals[0]
    print(f"\n{law}, {path}: {len(sim.fragments)} pieces, momentum {drift:.1e}, energy grows by {growth:.1e}, ends at {totals[-1] / totals[0]:.3f}")
    assert len(sim.fragments) > 1
    assert drift <= 1e-10
    assert growth <= swing
    assert totals[-1] < totals[0]
    assert sum(f.mass for f in sim.fragments) == pytest.approx(mass, rel=1e-12)


@pytest.mark.parametrize("path", ["particle", "fragment"])
@pytest.mark.parametrize("law", ["pd_bond", "pd_elastic", "pd_lps"])
def test_breaking_up_keeps_angular_momentum(law: str, path: str) -> None:
    """D8c: a spinning bar tears; what the affine velocities of particles carry that leave the grid goes to their families."""
    tree = scene({"type": law, "youngs_modulus": YOUNG}, box([0, 0, 0], [1.6, 0.4, 0.4]), SPACING)
    tree["material"]["m"] |= {"fracture": {"type": "critical_stretch", "critical_stretch": 0.05}, "crack_surface": path}
    sim = perimpm.Simulation(tree, threads=1)
    x, v = sim.particles["x"] - [0.8, 0.2, 0.2], sim.particles["v"]
    v[:] = np.cross([0.0, 0.0, 0.2 * WAVE], x)
    v[:, 0] += 0.25 * WAVE * np.sign(x[:, 0]) * (np.abs(x[:, 0]) > 0.2)
    scale = float(np.sum(sim.particles["mass"] * np.linalg.norm(np.cross(x, v), axis=1)))
    before, drift = np.array(sim.ledger.angular_momentum), 0.0
    for _ in range(60):
        sim.step(5)
        drift = max(drift, float(np.max(np.abs(np.array(sim.ledger.angular_momentum) - before))) / scale)
    print(f"\n{law}, {path}: {len(sim.fragments)} pieces, angular momentum {drift:.1e}")
    assert len(sim.fragments) > 1
    assert drift <= 1e-11
