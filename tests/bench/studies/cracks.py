"""Damage of the Kalthoff-Winkler plate and of branching glass (REFERENCES D4, D5), as in tests/verification/test_fracture.py.

python tests/bench/studies/cracks.py: writes cracks.png beside this file; half a minute on 2 cores.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

TESTS = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(TESTS), str(TESTS / "verification")]

from test_fracture import BOND, LPS, damage, glass_plate, kalthoff_winkler  # noqa: E402

PANELS = {
    "Kalthoff-Winkler, pd_bond": (kalthoff_winkler(BOND, 0.5e-3), 85e-6),
    "pd_lps, Poisson's ratio 0.3": (kalthoff_winkler(LPS | {"poisson_ratio": 0.3}, 0.5e-3), 85e-6),
    "glass under 2 MPa, pd_bond": (glass_plate(BOND, 0.25e-3, 2e6), 43e-6),
    "glass under 2 MPa, pd_lps": (glass_plate(LPS, 0.25e-3, 2e6), 43e-6),
}

figure = plt.figure(figsize=(11, 5.2), layout="constrained")
places = figure.add_gridspec(2, 4, width_ratios=[1, 1, 1.6, 1.6])
axes = [figure.add_subplot(place) for place in (places[:, 0], places[:, 1], places[0, 2:], places[1, 2:])]
for panel, (title, (simulation, end)) in zip(axes, PANELS.items(), strict=True):
    X = 1e3 * np.array(simulation.particles["x"])
    while simulation.time < end:
        simulation.step(50)
    points = panel.scatter(X[:, 0], X[:, 1], c=damage(simulation), s=0.5, vmin=0, vmax=0.6, cmap="inferno_r", linewidths=0)
    panel.set(title=title, xlabel="mm", aspect="equal")
figure.colorbar(points, ax=axes, label="damage", shrink=0.6)
figure.text(0.01, 0.01, "python tests/bench/studies/cracks.py", fontsize=7)
figure.savefig(Path(__file__).with_suffix(".png"), dpi=110)
