"""Fragments of the broken wall (scenes/wall.toml, the first half of it) by criterion, with and without p_inactive, by crack_surface; what
breaking costs.

python tests/bench/studies/wall.py: writes wall.csv beside this file; four to ten minutes on 2 cores. `dust`: share of the
wall's mass in pieces of fewer than 10 particles. `fracture`, `contact`, `fields` (sorting included): shares of the run's time.
"""

from __future__ import annotations

from pathlib import Path

from study import write_csv

import perimpm

SCENE = Path(__file__).resolve().parents[3] / "scenes/wall.toml"
STRETCH = 'material.plaster.fracture={ type = "critical_stretch", critical_stretch = 0.08, interval = 8 }'
CASES = {
    "plane_cut": [],
    "plane_cut without p_inactive": ["material.plaster.fracture.p_inactive=false"],
    "plane_cut, horizon 3.015": ["material.plaster.constitutive.horizon=3.015"],
    "plane_cut, fragment": ['material.plaster.crack_surface="fragment"'],
    "plane_cut, grid": ['material.plaster.crack_surface="grid"'],
    "critical_stretch": [STRETCH],
    "critical_stretch in 60 pieces": [STRETCH, "material.plaster.pieces=60"],
    "critical_stretch, fragment": [STRETCH, 'material.plaster.crack_surface="fragment"'],
    "critical_stretch, grid": [STRETCH, 'material.plaster.crack_surface="grid"'],
}
COLUMNS = ("case", "pieces", "pieces_of_10", "largest", "second", "dust", "fracture", "contact", "fields", "steps",
           "seconds")  # fmt: skip


def measure(overrides: list[str]) -> tuple[object, ...]:
    simulation = perimpm.Simulation(SCENE, ["simulation.end_time=0.75", *overrides])
    wall = simulation.particles.of("plaster")["id"].max()
    simulation.run()
    pieces = [f for f in simulation.fragments if f.id <= wall]
    mass = sum(f.mass for f in pieces)
    sizes = sorted((f.particles for f in pieces), reverse=True)
    dust = sum(f.mass for f in pieces if f.particles < 10) / mass
    seconds = {p.name: p.seconds for p in simulation.pass_times}
    whole = sum(seconds.values())
    parts = (("fracture",), ("contact of crack surfaces",), ("contact of velocity fields", "sort"))
    shares = (sum(seconds.get(name, 0.0) for name in names) / whole for names in parts)
    return (len(pieces), sum(n >= 10 for n in sizes), sizes[0], sizes[1] if len(sizes) > 1 else 0, round(dust, 4),
            *(round(share, 3) for share in shares), simulation.steps, round(whole, 1))  # fmt: skip


rows = []
for case, overrides in CASES.items():
    rows.append((case, *measure(overrides)))
    print(dict(zip(COLUMNS, rows[-1])), flush=True)
write_csv("wall", COLUMNS, rows)
