"""Irregular particles (E6): what a local law and a bond law lose when particles are moved off their lattice, and what the
local law reaches at the bond law's cost.

Runs the hidden case "irregular particles: table" of the test program (tests/verification/test_irregular.cpp says what is
measured; set PERIMPM_TESTS if the program is not build/release/tests/perimpm_tests) and writes irregular.csv and
irregular.png beside this file. Rows are means over the seeds, nan where a run broke down. `change` is the error against the
same law's period on the lattice, which leaves only what the disorder does; `local_at_equal_cost` is the error of
fixed_corotated, from its own rows at other resolutions, for the same jitter and processor time."""

from __future__ import annotations

import argparse
import csv
import os
import subprocess
from collections import defaultdict

import numpy as np
from study import curves, write_csv

LOCAL = "fixed_corotated"
COLUMNS = ("law", "cells", "jitter", "particles", "steps", "seconds", "period", "loss", "error", "error_over_lattice",
           "change", "noise", "local_at_equal_cost")  # fmt: skip
Row = dict[str, float]
Table = dict[tuple[str, int, float], Row]  # by law, cells per m, jitter in spacings


def measure() -> Table:
    program = os.environ.get("PERIMPM_TESTS", "build/release/tests/perimpm_tests")
    wish = os.environ | {"PERIMPM_TABLE": "1"}
    done = subprocess.run([program, "[irregular]"], capture_output=True, text=True, check=True, env=wish)
    lines = [line.removeprefix("row,") for line in done.stdout.splitlines() if line.startswith("row,")]
    seeds: dict[tuple[str, int, float], list[Row]] = defaultdict(list)
    for one in csv.DictReader(lines):
        law = one.pop("law")
        row = {key: float(value) for key, value in one.items()}
        seeds[law, int(row["cells"]), row["jitter"]].append(row)
    return {case: {key: float(np.mean([r[key] for r in rows])) for key in rows[0]} for case, rows in seeds.items()}


def local_error(table: Table, jitter: float, seconds: float) -> float | None:
    """Of the local law in that time; None outside of what was measured."""
    rows = sorted((r["seconds"], r["error"]) for (law, _, j), r in table.items() if law == LOCAL and j == jitter)
    cost, error = np.log(np.array(rows)).T
    if not cost[0] <= np.log(seconds) <= cost[-1]:
        return None
    return float(np.exp(np.interp(np.log(seconds), cost, error)))


def rows(table: Table) -> list[tuple[object, ...]]:
    out: list[tuple[object, ...]] = []
    for (law, cells, jitter), r in table.items():
        equal = local_error(table, jitter, r["seconds"])
        growth = r["error"] / table[law, cells, 0.0]["error"]
        numbers = (r["seconds"], r["period"], 1 - r["kept"], r["error"], growth, r["change"], r["noise"])
        rounded = [f"{value:.4g}" for value in numbers]
        out.append((law, cells, jitter, int(r["particles"]), int(r["steps"]), *rounded, equal and f"{equal:.4g}"))
    return out


def main() -> None:
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    table = measure()
    write_csv("irregular", COLUMNS, rows(table))
    laws = list(dict.fromkeys(law for law, _, _ in table))
    jitters = sorted({jitter for _, _, jitter in table})
    worst = jitters[-1]

    def over_jitter(value: str) -> dict[str, tuple[list[float], list[float]]]:
        return {law: (jitters, [table[law, 20, j][value] for j in jitters]) for law in laws}

    def over_cost(jitter: float) -> dict[str, tuple[list[float], list[float]]]:
        found = {law: [r for (name, _, j), r in table.items() if name == law and j == jitter] for law in laws}
        return {law: ([r["seconds"] for r in rs], [r["error"] for r in rs]) for law, rs in found.items()}

    panels = {
        "error / A, h = 0.05 m": over_jitter("error"),
        "change from the law's own lattice / A": over_jitter("change"),
        "amplitude after half a period": over_jitter("kept"),
        "error / A, lattice": over_cost(0.0),
        f"error / A, jitter {worst:g} h": over_cost(worst),
    }
    curves("irregular", panels, ["jitter / h"] * 3 + ["processor time [s]"] * 2, ["linear"] * 3 + ["log"] * 2)


if __name__ == "__main__":
    main()
