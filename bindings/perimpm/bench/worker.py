"""perimpm as an engine that takes turns: reads a scene as a line of JSON, then numbers of steps."""

from __future__ import annotations

import argparse
import json
import sys

import numpy as np

from perimpm import InputError, Simulation, __version__

from .turns import Tree, serve


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--threads", type=int, default=1)
    args = parser.parse_args()
    given = json.loads(sys.stdin.readline())
    try:
        _serve(Simulation(given["scene"], threads=args.threads), given.get("velocity_gradient"))
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


def _serve(simulation: Simulation, gradient: list[list[float]] | None) -> None:
    """`gradient` G [1/s] adds G x to the velocities."""
    if gradient:
        simulation.particles["v"][:] += simulation.particles["x"] @ np.transpose(gradient)
    plan = simulation.plan
    bonds = sum(material.bonds for material in plan.materials)
    greeting = {"name": "perimpm", "version": __version__, "particles": plan.particles, "bonds": bonds}
    serve(greeting, simulation.step, lambda: _check(simulation))


def _check(simulation: Simulation) -> Tree:
    """The state, for comparison with peers, and where time and memory went."""
    x, v = simulation.particles["x"], simulation.particles["v"]
    return {
        "y": float(np.mean(x[:, 1], dtype=np.float64)),
        "vy": float(np.mean(v[:, 1], dtype=np.float64)),
        "kinetic": simulation.ledger.kinetic,
        "bytes": sum(array.bytes for array in simulation.plan.arrays),
        "steps": simulation.steps,
        "passes": [(p.name, p.calls, p.seconds) for p in simulation.pass_times],
    }


if __name__ == "__main__":
    sys.exit(main())
