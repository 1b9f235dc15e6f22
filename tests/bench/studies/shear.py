"""Simple shear of a perfectly plastic block to gamma = 5 (C6): shear stress over Y/sqrt(3), where finite-strain J2
(`von_mises`) stays, and what the additive small-strain plasticity of bonds makes of it.

Runs the hidden case "simple shear: table" of the test program (tests/verification/test_simple_shear.cpp says what is measured;
set PERIMPM_TESTS if the program is not build/release/tests/perimpm_tests) and writes shear.csv and shear.png beside this
file."""

from __future__ import annotations

import argparse
import os
import subprocess

from study import curves, write_csv

SHOWN = (0.01, 0.1, 0.2, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0)


def measure() -> dict[str, dict[float, float]]:
    """Stress by law and gamma."""
    program = os.environ.get("PERIMPM_TESTS", "build/release/tests/perimpm_tests")
    wish = os.environ | {"PERIMPM_TABLE": "1"}
    done = subprocess.run([program, "[shear]"], capture_output=True, text=True, check=True, env=wish)
    table: dict[str, dict[float, float]] = {}
    for line in done.stdout.splitlines():
        if line.startswith("row,") and not line.startswith("row,law"):
            _, law, gamma, stress = line.split(",")
            table.setdefault(law, {})[float(gamma)] = float(stress)
    return table


def main() -> None:
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    table = measure()
    write_csv("shear", ("law", *SHOWN), ((law, *(f"{row[gamma]:.3f}" for gamma in SHOWN)) for law, row in table.items()))
    lines = {law: (list(row), list(row.values())) for law, row in table.items()}
    start = {law: ([g for g in x if g <= 0.2], [s for g, s in zip(x, y) if g <= 0.2]) for law, (x, y) in lines.items()}
    curves("shear", {"shear stress over Y/sqrt 3": lines, "the beginning": start}, ["gamma", "gamma"], ["linear", "linear"])


if __name__ == "__main__":
    main()
