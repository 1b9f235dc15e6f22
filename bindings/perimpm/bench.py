"""`perimpm bench throughput`: ns per particle-step and per bond, beside peers in the same run."""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ._core import InputError
from .progress import pass_table
from .simulation import Simulation
from .tables import console, table
from .workloads import Workload, mpm_block, pd_cube

Result = dict[str, Any]


def measure(workload: Workload, threads: int, steps: int, reps: int) -> tuple[Result, Simulation]:
    """Median over `reps` consecutive blocks of `steps` whole steps, after the warm-up."""
    simulation = Simulation(workload.scene, threads=threads)
    workload.start(simulation)
    simulation.step(workload.warm_up)
    seconds = []
    for _ in range(reps):
        start = time.perf_counter()
        simulation.step(steps)
        seconds.append((time.perf_counter() - start) / steps)
    plan = simulation.plan
    return result("perimpm", plan.particles, sum(m.bonds for m in plan.materials), seconds), simulation


def result(name: str, particles: int, bonds: int, seconds: Sequence[float]) -> Result:
    """Wall times per step as rates; spread: (slowest - fastest) / median block."""
    median = statistics.median(seconds)
    return {
        "name": name,
        "particles": particles,
        "bonds": bonds,
        "seconds_per_step": list(seconds),
        "ns_per_particle_step": 1e9 * median / particles,
        "ns_per_bond": 1e9 * median / bonds if bonds else None,
        "spread": (max(seconds) - min(seconds)) / median,
    }


def _workload(args: argparse.Namespace) -> Workload:
    """The workload asked for; what was left open in `args` is filled in."""
    block = args.workload == "mpm-block"
    args.side = args.side or (23 if block else 46)
    args.law = args.law or ("fixed_corotated" if block else "pd_bond")
    args.transfer = args.transfer or ("apic" if block else "particle")
    if block:
        return mpm_block(args.side, args.law, args.transfer, args.order, args.precision)
    return pd_cube(args.side, args.law, args.transfer, args.precision)


def throughput(args: argparse.Namespace) -> None:
    """Runs the benchmark as the command line asks for it and prints the table."""
    threads = args.threads or len(os.sched_getaffinity(0))
    workload = _workload(args)
    peers, missing = _peer_commands(args, threads) if args.peers else ([], [])
    rounds: list[list[Result]] = []
    simulation = None
    for _ in range(args.reps if peers else 1):  # interleaved, so that all see the same machine
        ours, simulation = measure(workload, threads, args.steps, 1 if peers else args.reps)
        rounds.append([ours, *(_run_peer(command) for command in peers)])
    results = [_merge(column) for column in zip(*rounds)]
    _print(results, missing, simulation)
    if args.json:
        settings = {k: getattr(args, k) for k in ("workload", "law", "transfer", "order", "precision", "side", "steps")}
        _write_json(args.json, {**settings, "threads": threads, "results": results, "missing_peers": missing})


def _merge(rounds: Sequence[Result]) -> Result:
    first = rounds[0]
    seconds = [s for r in rounds for s in r["seconds_per_step"]]
    return result(first["name"], first["particles"], first["bonds"], seconds)


def _peer_commands(args: argparse.Namespace, threads: int) -> tuple[list[list[str]], list[str]]:
    """Commands of the peers that can run here, and why the others cannot."""
    folder = Path(os.environ.get("PERIMPM_BENCH_PEERS", "tests/bench/peers"))
    script = folder / ("taichi_mpm.py" if args.workload == "mpm-block" else "taichi_pd.py")
    if importlib.util.find_spec("taichi") is None:
        return [], ["taichi: not installed (pip install taichi)"]
    if not script.exists():
        return [], [f"taichi: no {script}; run from the repository or set PERIMPM_BENCH_PEERS to its tests/bench/peers"]
    command = [sys.executable, str(script), "--side", str(args.side), "--threads", str(threads)]
    return [command + ["--precision", args.precision, "--steps", str(args.steps), "--reps", "1"]], []


def _run_peer(command: Sequence[str]) -> Result:
    """A peer prints one JSON line: name, particles, bonds, seconds_per_step."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise InputError(f"the peer '{command[1]}' failed:\n{done.stderr.strip()[-2000:]}")
    line = json.loads(done.stdout.strip().splitlines()[-1])
    return result(line["name"], line["particles"], line["bonds"], line["seconds_per_step"])


def _print(results: Sequence[Result], missing: Sequence[str], simulation: Simulation | None) -> None:
    ours = results[0]
    rate = "ns_per_bond" if ours["ns_per_bond"] else "ns_per_particle_step"
    rows = [
        (
            r["name"],
            str(r["particles"]),
            str(r["bonds"]),
            f"{r['ns_per_particle_step']:.1f}",
            f"{r['ns_per_bond']:.3f}" if r["ns_per_bond"] else "-",
            f"{r['spread']:.0%}",
            f"{r[rate] / ours[rate]:.2f}",
        )
        for r in results
    ]
    columns = ("engine", "particles", "bonds", "ns per particle-step", "ns per bond", "spread", "time / perimpm")
    out = console()
    out.print(table("throughput, wall time of whole steps", columns, rows, numbers=columns[1:]))
    for reason in missing:
        out.print(f"peer missing: {reason}")
    if simulation is not None:
        out.print(pass_table(simulation))


def _write_json(path: str, content: Result) -> None:
    try:
        Path(path).write_text(json.dumps(content, indent=2) + "\n")
    except OSError as error:
        raise InputError(f"{path}: cannot write the result: {error.strerror}") from None
