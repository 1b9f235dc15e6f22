"""The scene of bunnies.toml, assembled in Python: the same tree as a dict, then a look at the particles.

python scenes/bunnies.py [pd_elastic | fixed_corotated]
"""

import sys
from pathlib import Path

import numpy as np

import perimpm

LAWS = {
    "pd_elastic": {"type": "pd_elastic", "youngs_modulus": 1.5e5},
    "fixed_corotated": {"type": "fixed_corotated", "youngs_modulus": 1.5e5, "poisson_ratio": 0.25},
}


def bunny(name, x, velocity, **more):
    shape = {"type": "mesh", "file": "assets/bunny.obj", "scale": 4, "translation": x} | more.pop("shape", {})
    return {"name": name, "material": "rubber", "shape": shape, "initial_velocity": velocity} | more


def scene(law):
    return {
        "format": 1,
        "title": "Two bunnies collide",
        "simulation": {"end_time": 1.5, "frame_rate": 24, "gravity": [0, -9.81, 0]},
        "grid": {"spacing": 0.022},
        "transfer": {"type": "apic", "order": 2},
        "material": {"rubber": {"density": 1000, "constitutive": LAWS[law]}},
        "body": [
            bunny("left", [-0.55, 0.45, 0], [3, 1, 0], initial_angular_velocity=[0, 0, 1]),
            bunny("right", [0.55, 0.5, 0], [-3, 1, 0], shape={"rotation": [0, 180, 0]}),
        ],
        "collider": [
            {"name": "floor", "shape": {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0]}, "friction": 0.4}
        ],
        "output": {"fields": ["x", "v", "id", "body"]},
    }


def main():
    law = sys.argv[1] if len(sys.argv) > 1 else "pd_elastic"
    if law not in LAWS:
        sys.exit(f"unknown law '{law}': expected one of {', '.join(LAWS)}")
    simulation = perimpm.Simulation(scene(law), folder=Path(__file__).parent)
    simulation.run(output=f"out/bunnies_{law}", progress=True)
    speed = np.linalg.norm(simulation.particles["v"], axis=1)
    ledger = simulation.ledger
    print(f"fastest particle {speed.max():.2f} m/s, kinetic energy {ledger.kinetic:.1f} J, elastic {ledger.elastic:.1f} J")


if __name__ == "__main__":
    main()
