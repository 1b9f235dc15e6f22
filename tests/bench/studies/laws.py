"""What a step costs with each constitutive law: the falling block on a grid with all of them, the peridynamic cube with those of
bonds, in turns. Default families (2.2 spacings) in the block, the workload's (3.015) in the cube.

Writes laws.csv beside this file: one row for each law in each workload and precision.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from study import ratios, write_csv

from perimpm.bench.throughput import take_turns
from perimpm.bench.workloads import Workload, mpm_block, pd_cube

COLUMNS = ("workload", "law", "precision", "threads", "particles", "bonds", "ns_per_particle_step", "ns_per_bond",
           "ratio", "ratio_min", "ratio_max", "spread")  # fmt: skip

SOFT = {"youngs_modulus": 1.0e5}
LOCAL = SOFT | {"poisson_ratio": 0.3}
NEO_HOOKEAN = {"type": "neo_hookean"} | LOCAL
BLOCK_LAWS: dict[str, dict[str, Any]] = {
    "fixed_corotated": {"type": "fixed_corotated"} | LOCAL,
    "neo_hookean": NEO_HOOKEAN,
    "von_mises": {"type": "von_mises", "yield_stress": 1.0e3} | LOCAL,
    "tensile_damage of neo_hookean": {
        "type": "tensile_damage",
        "law": NEO_HOOKEAN,
        "tensile_strength": 1.0e4,
        "fracture_energy": 100.0,
    },
    "pd_bond": {"type": "pd_bond"} | SOFT,
    "pd_elastic": {"type": "pd_elastic"} | SOFT,
    "pd_elastic, as printed": {"type": "pd_elastic", "formulation": "paper"} | SOFT,
    "pd_lps": {"type": "pd_lps"} | LOCAL,
    "pd_lps, yielding families": {"type": "pd_lps", "yield_stress": 1.0e3, "yield": "family"} | LOCAL,
    "deviatoric_plastic": {"type": "deviatoric_plastic", "yield_stress": 1.0e3} | SOFT,
    "pd_correspondence of neo_hookean": {"type": "pd_correspondence", "law": NEO_HOOKEAN},
    "the same, grid divergence": {"type": "pd_correspondence", "law": NEO_HOOKEAN, "divergence": "grid"},
}
CUBE_LAWS = {
    "pd_bond": {},
    "pd_elastic": {},
    "pd_elastic, as printed": {"formulation": "paper"},
    "pd_lps": {"poisson_ratio": 0.25},
    "deviatoric_plastic": {"yield_stress": 1.0e9},
}


def block(name: str, side: int, precision: str) -> Workload:
    workload = mpm_block(side, "fixed_corotated", "apic", 2, precision)
    workload.scene["material"]["jelly"]["constitutive"] = BLOCK_LAWS[name]
    return workload


def cube(name: str, side: int, precision: str) -> Workload:
    workload = pd_cube(side, name.split(",")[0], "particle", precision)
    glass = workload.scene["material"]["glass"]
    glass["constitutive"] |= CUBE_LAWS[name]
    return replace(workload, warm_up=5)


def rows(workload: str, workloads: dict[str, Workload], precision: str, steps: int, args: argparse.Namespace) -> Iterator[Any]:
    results = take_turns([(one, args.threads) for one in workloads.values()], [], steps, args.reps)
    for law, result in zip(workloads, results):
        per_bond = result["ns_per_bond"]
        yield (workload, law, precision, args.threads, result["particles"], result["bonds"],
               round(result["ns_per_particle_step"], 1), "" if per_bond is None else round(per_bond, 2),
               *(round(r, 2) for r in ratios(result, results[0])), round(result["spread"], 2))  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--precisions", nargs="+", default=("float", "double"))
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--block-side", type=int, default=16, help="cells along an edge")
    parser.add_argument("--cube-side", type=int, default=30, help="particles along an edge")
    parser.add_argument("--reps", type=int, default=5, help="rounds")
    args = parser.parse_args()
    table: list[Any] = []
    for precision in args.precisions:
        blocks = {name: block(name, args.block_side, precision) for name in BLOCK_LAWS}
        table += rows("mpm-block", blocks, precision, 20, args)
        cubes = {name: cube(name, args.cube_side, precision) for name in CUBE_LAWS}
        table += rows("pd-cube", cubes, precision, 5, args)
        write_csv("laws", COLUMNS, table)


if __name__ == "__main__":
    main()
