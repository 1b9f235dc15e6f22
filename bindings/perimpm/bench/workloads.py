"""The two throughput workloads as scenes: a falling elastic block (grid) and a stretched lattice cube (bonds)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Workload:
    """A scene, the velocity gradient [1/s] to add before the first step, and how many steps to warm up and to time."""

    scene: dict[str, Any]
    velocity_gradient: list[list[float]] | None
    warm_up: int
    steps: int


def mpm_block(side: int, law: str, transfer: str, order: int, precision: str) -> Workload:
    """Cube of `side` cells in the unit cube of 128 cells, 8 particles per cell, falling at 2 m/s."""
    dx = 1.0 / 128
    low = [cell * dx for cell in (64 - side // 2, 4, 64 - side // 2)]
    constitutive: dict[str, Any] = {"type": law, "youngs_modulus": 1.0e5}
    if law.startswith("pd_"):
        constitutive["horizon"] = 2.01  # spacings
    else:
        constitutive["poisson_ratio"] = 0.3
    if law == "von_mises":
        constitutive["yield_stress"] = 1.0e3  # flows where the block lands
    scene = {
        "format": 1,
        "title": f"falling block, {side} cells an edge",
        "simulation": {
            "end_time": 1.0,
            "frame_rate": 24.0,
            "dt": 1.0e-4,
            "precision": precision,
            "gravity": [0.0, -9.81, 0.0],
        },
        # Walls act on nodes with an index below 3 or above 125.
        "grid": {"spacing": dx, "domain": {"min": [2 * dx] * 3, "max": [126 * dx] * 3, "faces": "separate"}},
        "transfer": {"type": transfer, "order": order, "stress_divergence": "mls"},
        "material": {"jelly": {"density": 1000.0, "constitutive": constitutive}},
        "body": [
            {
                "material": "jelly",
                "shape": {"type": "box", "min": low, "max": [c + side * dx for c in low]},
                "particle_spacing": dx / 2,
                "initial_velocity": [0.0, -2.0, 0.0],
            }
        ],
    }
    return Workload(scene, None, warm_up=20, steps=50)


def pd_cube(side: int, law: str, transfer: str, precision: str) -> Workload:
    """Cubic lattice of `side` particles an edge, horizon 3.015 spacings, with a linear velocity field."""
    dx = 1.0e-3
    constitutive: dict[str, Any] = {"type": law, "youngs_modulus": 72.0e9, "horizon": 3.015}
    if law == "pd_bond":
        constitutive |= {"calibration": "continuum", "volume_correction": "centred"}
    half = dx / 2
    scene = {
        "format": 1,
        "title": f"lattice cube, {side} particles an edge",
        "simulation": {
            "end_time": 1.0,
            "frame_rate": 24.0,
            "dt": 5.0e-8,
            "allow_unstable_dt": True,
            "precision": precision,
            "gravity": [0.0, 0.0, 0.0],
        },
        "grid": {"spacing": 2 * dx},
        "transfer": {"type": transfer},
        "material": {
            "glass": {
                "density": 2440.0,
                "constitutive": constitutive,
                "fracture": {"type": "critical_stretch", "critical_stretch": 0.5},
            }
        },
        "body": [
            {
                "material": "glass",
                "shape": {"type": "box", "min": [-half] * 3, "max": [side * dx - half] * 3},
                "particle_spacing": dx,
                "initial_velocity": [-5.0, 3.0, 0.0],
            }
        ],
    }
    length = side * dx
    gradient = [[10.0 / length, 0.0, 0.0], [0.0, -6.0 / length, 0.0], [0.0, 0.0, 0.0]]
    return Workload(scene, gradient, warm_up=5, steps=20)
