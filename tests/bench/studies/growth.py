"""Cost and memory per particle as the elastic block grows, and a small body in a small and in a vast domain.

Writes growth.csv and growth.png beside this file. The blocks take turns, so that all see the same machine.
"""

from __future__ import annotations

import argparse

from study import add_machine, plot, write_csv

from perimpm.bench.throughput import Result, take_turns
from perimpm.bench.workloads import Workload, mpm_block

SIDES = (23, 33, 50, 72)  # cells: 1e5, 3e5, 1e6 and 3e6 particles
SMALL = 5  # cells: 1000 particles
COLUMNS = ("case", "particles", "ns_per_particle_step", "ns_per_particle_step_over_first", "spread", "quiet_blocks",
           "bytes_per_particle")  # fmt: skip


def small_body(cells: int, precision: str) -> Workload:
    """1000 particles that drop by a cell onto the floor of a domain of so many cells an edge."""
    work = mpm_block(SMALL, "fixed_corotated", "apic", 2, precision)
    dx = work.scene["grid"]["spacing"]
    low, high = [64 - cells // 2, 2, 64 - cells // 2], [64 - cells // 2 + cells, 2 + cells, 64 - cells // 2 + cells]
    work.scene["grid"]["domain"] |= {"min": [c * dx for c in low], "max": [c * dx for c in high]}
    work.scene["body"][0]["initial_velocity"] = [0.0, 0.0, 0.0]
    return work


def rows(cases: list[str], results: list[Result]) -> list[tuple[object, ...]]:
    first = results[0]["ns_per_particle_step"]
    return [
        (
            case,
            r["particles"],
            round(r["ns_per_particle_step"], 2),
            round(r["ns_per_particle_step"] / first, 3),
            round(r["spread"], 3),
            sum(r["quiet"]),
            round(r["check"]["bytes"] / r["particles"], 1),
        )
        for case, r in zip(cases, results)
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_machine(parser)
    parser.add_argument("--sides", type=int, nargs="+", default=SIDES, help="cells along the edges of the blocks")
    parser.add_argument("--steps", type=int, default=20, help="of a timed block; the small body takes 100 times as many")
    args = parser.parse_args()

    blocks = [(mpm_block(side, "fixed_corotated", "apic", 2, args.precision), args.threads) for side in args.sides]
    table = rows([f"block of {side} cells" for side in args.sides], take_turns(blocks, [], args.steps, args.reps))
    domains = (16, 1000)
    small = [(small_body(cells, args.precision), args.threads) for cells in domains]
    table += rows([f"domain of {c} cells" for c in domains], take_turns(small, [], 100 * args.steps, args.reps))

    write_csv("growth", COLUMNS, table)
    grown = [row for row in table if str(row[0]).startswith("block")]
    plot(
        "growth",
        [float(str(row[1])) for row in grown],
        {"ns per particle-step": [row[2] for row in grown], "bytes per particle": [row[6] for row in grown]},
        "particles",
    )


if __name__ == "__main__":
    main()
