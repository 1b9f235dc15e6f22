"""Both workloads beside every installed peer and beside our dearer forms (cubic splines, averaged bonds), in turns.

Writes throughput_block.csv, throughput_cube.csv and pictures of both beside this file: one row for each engine in each
setting.
"""

from __future__ import annotations

import argparse
import itertools
from collections.abc import Iterator
from pathlib import Path

from study import grouped_bars, ratios, write_csv

from perimpm.bench.peers import Run, peer_commands
from perimpm.bench.throughput import Result, take_turns
from perimpm.bench.workloads import Workload, mpm_block, pd_cube

BENCH = Path(__file__).parent.parent
COLUMNS = ("workload", "side", "precision", "threads", "engine", "version", "ns", "ratio", "ratio_min", "ratio_max",
           "spread", "quiet_blocks")  # fmt: skip


def block(run: Run, args: argparse.Namespace) -> tuple[dict[str, Workload], int]:
    """The workload as defined, then its dearer form; and the steps of a timed block, fewer for larger bodies."""
    forms = {f"perimpm, order {order}": mpm_block(run.side, run.law, run.transfer, order, run.precision) for order in (2, 3)}
    return forms, max(5, round(args.block_steps * (23 / run.side) ** 3))


def cube(run: Run, args: argparse.Namespace) -> tuple[dict[str, Workload], int]:
    forms = {f"perimpm, {law}": pd_cube(run.side, law, run.transfer, run.precision) for law in ("pd_bond", "pd_elastic")}
    return forms, max(2, round(args.cube_steps * (46 / run.side) ** 3))


def rows(run: Run, args: argparse.Namespace) -> Iterator[tuple[object, ...]]:
    forms, steps = (block if run.workload == "mpm-block" else cube)(run, args)
    peers, _ = peer_commands(run, BENCH)
    results = take_turns([(workload, run.threads) for workload in forms.values()], peers, steps, args.reps)
    for name, result in itertools.zip_longest(forms, results):
        yield (run.workload, run.side, run.precision, run.threads, name or result["name"], result["version"],
               *measured(run, result, results[0]))  # fmt: skip


def measured(run: Run, result: Result, ours: Result) -> tuple[object, ...]:
    """Time, its ratio to ours (median, least and most of the rounds), spread, quiet blocks."""
    bonds = run.workload == "pd-cube"
    units = result["bonds"] if bonds else result["particles"]
    ours_units = ours["bonds"] if bonds else ours["particles"]
    ns = result["ns_per_bond"] if bonds else result["ns_per_particle_step"]
    return (round(ns, 3), *(round(r * ours_units / units, 3) for r in ratios(result, ours)), round(result["spread"], 3), sum(result["quiet"]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workloads", nargs="+", default=("mpm-block", "pd-cube"))
    parser.add_argument("--block-sides", type=int, nargs="+", default=(23, 50), help="cells along an edge")
    parser.add_argument("--cube-sides", type=int, nargs="+", default=(46, 100), help="particles along an edge")
    parser.add_argument("--precisions", nargs="+", default=("float", "double"))
    parser.add_argument("--threads", type=int, nargs="+", default=(1, 2))
    parser.add_argument("--block-steps", type=int, default=50, help="of a timed block of the smallest body")
    parser.add_argument("--cube-steps", type=int, default=20, help="of a timed block of the smallest body")
    parser.add_argument("--reps", type=int, default=5, help="rounds")
    args = parser.parse_args()
    models = {"mpm-block": ("fixed_corotated", "apic", 2), "pd-cube": ("pd_bond", "particle", None)}
    for workload in args.workloads:
        table: list[tuple[object, ...]] = []
        name = "throughput_" + workload.split("-")[1]
        law, transfer, order = models[workload]
        sides = args.block_sides if workload == "mpm-block" else args.cube_sides
        for side, precision, threads in itertools.product(sides, args.precisions, args.threads):
            table += rows(Run(workload, law, transfer, order, precision, threads, side), args)
            write_csv(name, COLUMNS, table)
        draw(name, table)


def draw(name: str, table: list[tuple[object, ...]]) -> None:
    settings: dict[str, list[tuple[str, float]]] = {}
    for workload, side, precision, threads, engine, _, _, ratio, *_ in table:
        settings.setdefault(f"{workload} {side}\n{precision}, {threads}", []).append((str(engine), float(str(ratio))))
    grouped_bars(name, settings, "time / perimpm, medians of the rounds")


if __name__ == "__main__":
    main()
