"""What features cost that the elastic block declares but does not use. Writes skip.csv and skip.png beside this file.

In each round the block runs without and with the feature; the ratio of a round compares times of the same minute.
"""

from __future__ import annotations

import argparse
import copy
import statistics
from typing import Any

from study import add_machine, bars, write_csv

from perimpm.bench.throughput import take_turns
from perimpm.bench.workloads import Workload, mpm_block

COLUMNS = ("feature", "law", "ratio", "ratio_min", "ratio_max", "quiet_rounds")

FRACTURE = {"type": "critical_stretch", "critical_stretch": 0.9}  # never reached
FAR = {"shape": {"type": "plane", "point": [0.0, -1.0, 0.0], "normal": [0.0, 1.0, 0.0]}}  # a metre below
ABSENT = {"density": 2000.0, "constitutive": {"type": "pd_bond", "youngs_modulus": 1.0e5}}


def features() -> list[tuple[str, str, dict[str, Any]]]:
    """Name, law, and what is merged into the scene; the first shows the noise."""
    return [
        ("nothing", "fixed_corotated", {}),
        ("a material without bodies", "fixed_corotated", {"material": {"absent": ABSENT}}),
        ("a collider out of reach", "fixed_corotated", {"collider": [FAR]}),
        ("a critical stretch", "pd_elastic", {"material": {"jelly": {"fracture": FRACTURE}}}),
    ]


def merged(tree: dict[str, Any], more: dict[str, Any]) -> dict[str, Any]:
    result = copy.deepcopy(tree)
    for key, value in more.items():
        result[key] = merged(result[key], value) if isinstance(result.get(key), dict) else value
    return result


def ratios(law: str, more: dict[str, Any], args: argparse.Namespace) -> tuple[list[float], int]:
    """Time with over time without the feature in each round, and how many rounds were quiet."""
    plain = mpm_block(args.side, law, "apic", 2, args.precision)
    changed = Workload(merged(plain.scene, more), None, plain.warm_up, plain.steps)
    without, with_it = take_turns([(plain, args.threads), (changed, args.threads)], [], args.steps, args.reps)
    rounds = [b / a for a, b in zip(without["seconds_per_step"], with_it["seconds_per_step"])]
    return rounds, sum(a and b for a, b in zip(without["quiet"], with_it["quiet"]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_machine(parser)
    parser.add_argument("--side", type=int, default=23, help="cells along an edge of the block")
    parser.add_argument("--steps", type=int, default=50, help="of a timed block")
    args = parser.parse_args()
    rows = []
    for name, law, more in features():
        rounds, quiet = ratios(law, more, args)
        numbers = (statistics.median(rounds), min(rounds), max(rounds))
        rows.append((name, law, *(round(n, 4) for n in numbers), quiet))
    write_csv("skip", COLUMNS, rows)
    bars("skip", [f"{row[0]}\n({row[1]})" for row in rows], [[row[i] for row in rows] for i in (2, 3, 4)])


if __name__ == "__main__":
    main()
