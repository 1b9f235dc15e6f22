"""Thick-walled sphere under inner pressure, perfect plasticity (C5; Hill 1950): radii a = 1 m and b = 2 m.

The pressure is a radial body force p / w in the layer a < r < a + w. While that layer flows, integrating
d(sigma_r)/dr = 2 Y / r - f gives Hill's relation unchanged for p = int f dr: with the plastic radius c > a + w,
  (1) p = 2 Y ln(c/a) + (2 Y/3)(1 - c^3/b^3)
  (2) u(r) = (Y c^3/3E) (2 (1 - 2 nu) r/b^3 + (1 + nu)/r^2)   outside c; (1 - nu) Y c^3/(E b^2) at b
c comes from (2) as a mean over the outer tenth of the wall, which stays elastic. The sphere is whole, so that nothing but
the law and the grid is tested. The pressure grows so slowly (ten periods of the breathing sphere) that inertia is small.
Particles of local laws lie on shells with the exact volumes; bond laws, whose families are made with the body, have
the lattice points of a mesh."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from support import Array
from trees import Tree, box, scene

import perimpm

INNER, OUTER = 1.0, 2.0  # m
YOUNG, POISSON, DENSITY, YIELD_STRESS = 1e6, 0.3, 1000.0, 1e3  # Pa, 1, kg/m^3, Pa
DURATION = 3.0  # s; the breathing period is about 0.3 s
LAW: Tree = {"type": "von_mises", "youngs_modulus": YOUNG, "poisson_ratio": POISSON, "yield_stress": YIELD_STRESS}


@dataclass
class Cloud:
    x: Array  # m, (n, 3)
    volume: Array  # m^3


def shells(h: float) -> Cloud:
    """Shells h apart; on each, points of Fibonacci's lattice about h apart, turned at random."""
    random = np.random.default_rng(1)
    points, volumes = [], []
    edges = np.linspace(INNER, OUTER, round((OUTER - INNER) / h) + 1)
    for low, high in zip(edges[:-1], edges[1:]):
        r = 0.5 * (low + high)
        count = round(4 * np.pi * r**2 / h**2)
        k = np.arange(count) + 0.5
        z, angle = 1 - 2 * k / count, np.pi * (1 + np.sqrt(5)) * k
        s = np.sqrt(1 - z**2)
        turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
        points.append(r * np.column_stack([s * np.cos(angle), s * np.sin(angle), z]) @ turn)
        volumes.append(np.full(count, 4 * np.pi / 3 * (high**3 - low**3) / count))
    return Cloud(np.concatenate(points), np.concatenate(volumes))


def simulation(cloud: Cloud, h: float) -> perimpm.Simulation:
    """Any body of as many particles, which are then put where the cloud has them."""
    tree = scene(LAW, box([0, 0, 0], [len(cloud.x) * h, h, h]), h, density=DENSITY)
    sim = perimpm.Simulation(tree)
    assert len(sim.particles["id"]) == len(cloud.x)
    own = sim.particles["id"]
    sim.particles["x"][:] = cloud.x[own]
    sim.particles["volume"][:] = cloud.volume[own]
    sim.particles["mass"][:] = DENSITY * cloud.volume[own]
    return sim


def write_sphere(file: Path, chimney: float, rings: int = 48) -> None:
    """The sphere as a surface of revolution about z. Meshes of solids have no cavities: a hole of radius `chimney`
    through the wall at one pole joins the inside to the outside."""
    polar = [np.linspace(np.arcsin(chimney / radius), np.pi, rings)[:-1] for radius in (OUTER, INNER)]
    rim = [np.column_stack([radius * np.sin(t), radius * np.cos(t)]) for radius, t in zip((OUTER, INNER), polar)]
    angles = np.pi * np.arange(2 * rings) / rings
    profile = np.concatenate([rim[1][::-1], rim[0]])  # from the inner south pole through the hole to the outer one
    points = [(rho * np.cos(a), rho * np.sin(a), z) for rho, z in profile for a in angles] + [(0, 0, -INNER), (0, 0, -OUTER)]
    count, last = len(angles), len(profile) - 1
    at = [[1 + i * count + k % count for k in range(count + 1)] for i in range(len(profile))]
    faces: list[tuple[int, ...]] = []
    for k in range(count):
        faces += [(one[k], two[k], two[k + 1], one[k + 1]) for one, two in zip(at, at[1:])]
        faces += [(len(points) - 1, at[0][k], at[0][k + 1]), (len(points), at[last][k + 1], at[last][k])]
    lines = ["v {:.9g} {:.9g} {:.9g}".format(*p) for p in points] + ["f " + " ".join(map(str, face)) for face in faces]
    file.write_text("\n".join(lines) + "\n")


def lattice_simulation(law: Tree, h: float, folder: Path) -> perimpm.Simulation:
    write_sphere(folder / "sphere.obj", chimney=1.2 * h)
    return perimpm.Simulation(scene(law, {"type": "mesh", "file": str(folder / "sphere.obj")}, h, density=DENSITY))


def pressure(c: Array | float) -> Array | float:
    """(1) over Y."""
    return 2 * np.log(c / INNER) + 2 / 3 * (1 - c**3 / OUTER**3)


@dataclass
class Curve:
    """By sample: applied pressure, and (1) with c from the measured displacement, over Y."""

    applied: Array
    expected: Array
    c: Array

    def error(self, depth: float) -> Array:
        """Of the applied pressure, where more than this depth flows: at least the loaded layer."""
        flowing = (self.c > INNER + depth) & (self.c < 1.7)
        return np.asarray(self.applied[flowing] / self.expected[flowing] - 1)


def inflate(sim: perimpm.Simulation, width: float, highest: float, poisson: float = POISSON) -> Curve:
    """Up to the pressure `highest` Y on the layer of that width: two shells."""
    X, volume = sim.particles.by_id("x"), sim.particles.by_id("volume")
    r = np.linalg.norm(X, axis=1)
    loaded, outer = r < INNER + width, r > OUTER - 0.1 * (OUTER - INNER)
    depth = np.sum(volume[loaded] / (4 * np.pi * r[loaded] ** 2))  # int dr
    shape = YIELD_STRESS / (3 * YOUNG) * (2 * (1 - 2 * poisson) * r / OUTER**3 + (1 + poisson) / r**2)  # (2) over c^3
    samples, last = [], 0.0
    rows = np.flatnonzero(loaded[sim.particles["id"]])
    generation = sim.particles.generation
    while sim.time < DURATION:
        if sim.particles.generation != generation:
            rows, generation = np.flatnonzero(loaded[sim.particles["id"]]), sim.particles.generation
        p = highest * YIELD_STRESS * np.sin(np.pi / 2 * min(1.0, sim.time / DURATION)) ** 2
        x = sim.particles["x"][rows]
        kick = (sim.time - last) * p / (depth * DENSITY)
        sim.particles["v"][rows] += kick * x / np.linalg.norm(x, axis=1)[:, None]
        last = sim.time
        sim.step()
        if sim.steps % 20 == 0:
            u = np.sum(sim.particles.by_id("x")[outer] * X[outer], axis=1) / r[outer] - r[outer]
            c = np.cbrt(np.sum(u * shape[outer]) / np.sum(shape[outer] ** 2))
            samples.append((p / YIELD_STRESS, pressure(c), c))
    return Curve(*np.array(samples).T)


def report(title: str, curve: Curve, width: float) -> Array:
    error = curve.error(width)
    print(f"\n{title}: c/a, p/Y applied, p/Y of the measured c")
    for c in (1.2, 1.3, 1.4, 1.5, 1.6):
        at = int(np.argmin(np.abs(curve.c - c)))
        print(f"{curve.c[at]:.3f} {curve.applied[at]:.4f} {curve.expected[at]:.4f}")
    if len(error):
        print(f"largest difference {np.abs(error).max():.2%}, mean {np.mean(error):+.2%}")
    return error


def check(cells: int, tolerance: float) -> None:
    """With so many grid cells across the wall."""
    width = (OUTER - INNER) / cells
    cloud = shells(width / 2)
    curve = inflate(simulation(cloud, width / 2), width, highest=float(pressure(1.65)))
    error = report(f"{cells} cells across the wall", curve, width)
    assert curve.c.max() > 1.55
    assert np.abs(error).max() < tolerance


def test_coarse_sphere() -> None:
    check(5, tolerance=0.03)


@pytest.mark.slow
def test_sphere() -> None:
    check(10, tolerance=0.03)


# Yielding families.
BOND_LAWS: dict[str, Tree] = {
    "pd_lps": {"type": "pd_lps", "poisson_ratio": POISSON, "surface": "family"},
    "deviatoric_plastic": {"type": "deviatoric_plastic", "yield": "family", "surface": "moment"},
}


@pytest.mark.slow
@pytest.mark.parametrize(("name", "cells"), [("pd_lps", 5), ("deviatoric_plastic", 10)])
def test_bond_laws(name: str, cells: int, tmp_path: Path) -> None:
    """From the reference's first plastic radius on, 1.2 a, which at 5 cells is also where the loaded layer ends; its gate is
    for 10 cells across the wall. At 5 cells `deviatoric_plastic` is 5.4 % low at 1.2 a and 2.6 % at 1.6 a; at 10 cells it
    is 4.4 % low where the plastic zone leaves the loaded layer, at 1.1 a."""
    width = (OUTER - INNER) / cells
    law = {**BOND_LAWS[name], "youngs_modulus": YOUNG, "yield_stress": YIELD_STRESS, "horizon": 2.01}
    sim = lattice_simulation(law, width / 2, tmp_path)
    curve = inflate(sim, width, float(pressure(1.65)), law.get("poisson_ratio", 0.25))
    report(name, curve, width)
    assert curve.c.max() > 1.55
    assert np.abs(curve.error(0.2)).max() < 0.03
