"""The least time a step can take on this machine: measured limits (tests/bench/limits.cpp) and counts of what a step needs."""

from __future__ import annotations

import json
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from perimpm import InputError

FLAGS = ("-std=c++20", "-O3", "-march=native", "-ffp-contract=fast", "-pthread")

#: Numbers read and written by particle and step when a step streams the state once, gather and the next scatter in one: x and F
#: are read and written, mass and volume read: 26. FLIP reads and writes v, too; others need v and C only in between.
STATE_NUMBERS = {"pic": 26, "flip": 32, "apic": 26}
FLOPS_PER_NODE = 30  #: of the stencil, scatter and gather together
FLOPS_PER_PARTICLE = 690  #: spline weights, stress and an iterative polar decomposition


def measure_limits(folder: Path, threads: int, side: int) -> dict[str, float]:
    """Compiles and runs `folder`/limits.cpp; `side`: of the lattice whose neighbours are loaded.

    Raises
    ------
    InputError : no compiler, or the program does not compile or run.
    """
    source = folder / "limits.cpp"
    if not source.exists():
        raise InputError(f"--limits: no {source}; run from the repository or set PERIMPM_BENCH to its folder tests/bench")
    compiler = shutil.which("c++")
    if compiler is None:
        raise InputError("--limits: no C++ compiler 'c++' in PATH; on Debian: apt install g++")
    with tempfile.TemporaryDirectory() as build:
        program = str(Path(build) / "limits")
        _run([compiler, *FLAGS, str(source), "-o", program])
        limits: dict[str, float] = json.loads(_run([program, str(threads), str(side)]))
    return limits


def _run(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise InputError(f"--limits: '{' '.join(command)}' failed:\n{done.stderr.strip()[-2000:]}")
    return done.stdout


def block_bound(limits: dict[str, float], transfer: str, order: int, precision: str) -> dict[str, Any] | None:
    """Nanoseconds per particle-step of mpm-block; None for a transfer whose traffic is not known here."""
    if transfer not in STATE_NUMBERS:
        return None
    size = 4 if precision == "float" else 8
    memory = size * STATE_NUMBERS[transfer] / limits["update_GBs"]
    flops = FLOPS_PER_NODE * (order + 1) ** 3 + FLOPS_PER_PARTICLE
    return _larger(memory, flops / limits[f"{precision}_GFlops"], "arithmetic")


def bond_bound(limits: dict[str, float], precision: str) -> dict[str, Any]:
    """Nanoseconds per bond of a list: a neighbour (4 bytes) and a length, or the load of the neighbour's position.

    Families of a lattice share both, so that less than this is possible.
    """
    memory = (4 + (4 if precision == "float" else 8)) / limits["read_GBs"]
    return _larger(memory, limits[f"{precision}_quad_ns"], "neighbour load")


def _larger(memory: float, other: float, name: str) -> dict[str, Any]:
    return {"ns": max(memory, other), "by": "memory" if memory > other else name, "memory_ns": memory, f"{name}_ns": other}
