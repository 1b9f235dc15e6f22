"""What the studies share: options, and files that name the command that made them."""

from __future__ import annotations

import argparse
import csv
import os
import shlex
import statistics
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402  (needs no display)
from matplotlib.figure import Figure  # noqa: E402

FOLDER = Path(os.environ.get("PERIMPM_STUDIES", Path(__file__).parent))


def command() -> str:
    return shlex.join(["python", f"tests/bench/studies/{Path(sys.argv[0]).name}", *sys.argv[1:]])


def add_machine(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--precision", choices=("float", "double"), default="float")
    parser.add_argument("--reps", type=int, default=7, help="rounds")


def write_csv(name: str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """The first line names the command."""
    with open(FOLDER / f"{name}.csv", "w", newline="") as file:
        file.write(f"# {command()}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(rows)
    print((FOLDER / f"{name}.csv").read_text(), end="")


def ratios(result: Mapping[str, Any], first: Mapping[str, Any]) -> tuple[float, float, float]:
    """Median, least and most of the rounds' ratios of two engines' times for a step."""
    rounds = [a / b for a, b in zip(result["seconds_per_step"], first["seconds_per_step"])]
    return statistics.median(rounds), min(rounds), max(rounds)


def plot(name: str, x: Sequence[float], series: Mapping[str, Sequence[object]], label: str) -> None:
    """One panel for each series over a logarithmic axis."""
    figure, axes = plt.subplots(1, len(series), figsize=(4.2 * len(series), 3.4), squeeze=False)
    for panel, (title, values) in zip(axes[0], series.items()):
        panel.semilogx(x, values, "o-")
        panel.set(xlabel=label, ylabel=title, ylim=(0, 1.1 * max(float(str(v)) for v in values)))
        panel.grid(alpha=0.3)
    _save(figure, name)


def bars(name: str, labels: Sequence[str], numbers: Sequence[Sequence[float]]) -> None:
    """Medians with the range of the rounds; 1 is no cost."""
    middle, low, high = numbers
    figure, panel = plt.subplots(figsize=(6.4, 3.4))
    ends = [[m - a for m, a in zip(middle, low)], [b - m for m, b in zip(middle, high)]]
    panel.errorbar(middle, range(len(labels)), xerr=ends, fmt="o", capsize=4)
    panel.axvline(1.0, color="gray", linewidth=1)
    panel.set(xlabel="time with / without, median and range of the rounds", yticks=range(len(labels)), yticklabels=labels)
    panel.invert_yaxis()
    _save(figure, name)


def grouped_bars(name: str, groups: Mapping[str, Sequence[tuple[str, float]]], label: str) -> None:
    """A row of bars for each group, on a logarithmic axis."""
    figure, axes = plt.subplots(len(groups), 1, figsize=(8, 1.3 * len(groups)), sharex=True, squeeze=False)
    for panel, (title, entries) in zip(axes[:, 0], groups.items()):
        names, values = zip(*entries)
        panel.barh(names, values, log=True)
        panel.axvline(1.0, color="gray", linewidth=1)
        panel.set_ylabel(title, fontsize=7)
        panel.tick_params(labelsize=6)
        panel.invert_yaxis()
    axes[-1, 0].set_xlabel(label)
    _save(figure, name)


def curves(name: str, panels: Mapping[str, Mapping[str, tuple[Sequence[float], Sequence[float]]]], labels: Sequence[str],
           scales: Sequence[str]) -> None:  # fmt: skip
    """One panel for each title with a line for each (x, y); labels and scales ("log", "linear") are those of the x axes."""
    figure, axes = plt.subplots(1, len(panels), figsize=(4.2 * len(panels), 3.8), squeeze=False)
    for panel, (title, lines), label, scale in zip(axes[0], panels.items(), labels, scales):
        for line, (x, y) in lines.items():
            panel.plot(x, y, "o-", label=line)
        panel.set(xlabel=label, title=title, xscale=scale, yscale=scale)
        panel.grid(alpha=0.3)
    axes[0][0].legend(fontsize=7)
    _save(figure, name)


def _save(figure: Figure, name: str) -> None:
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    figure.text(0.01, 0.01, command(), fontsize=6, family="monospace")
    figure.savefig(FOLDER / f"{name}.png", dpi=110)
