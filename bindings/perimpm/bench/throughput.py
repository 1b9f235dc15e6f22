"""`perimpm bench throughput`: ns per particle-step and per bond, beside peers in the same run and beside the machine."""

from __future__ import annotations

import argparse
import json
import os
import statistics
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import Any

from perimpm import InputError

from ..progress import times_table
from ..tables import console, table
from .limits import block_bound, bond_bound, measure_limits
from .peers import Run, peer_commands
from .turns import Engine, Turn
from .workloads import Workload, mpm_block, pd_cube

Result = dict[str, Any]

LEAST_REPS = 5
AGREEMENT = {"y": 1e-3, "kinetic": 0.02}  #: relative; larger differences between engines' mean height and energy are reported


def throughput(args: argparse.Namespace) -> None:
    """Runs the benchmark as the command line asks for it and prints or writes the result."""
    if args.reps < LEAST_REPS:
        raise InputError(f"--reps {args.reps}: expected {LEAST_REPS} or more timed blocks, whose median counts")
    run, folder = _complete(args), Path(os.environ.get("PERIMPM_BENCH", "tests/bench"))
    workload = _workload(run)
    steps = args.steps or workload.steps
    limits = measure_limits(folder, run.threads, run.side if run.workload == "pd-cube" else 46) if args.limits else None
    peers, missing = peer_commands(run, folder) if args.peers else ([], [])
    results = take_turns([(workload, run.threads)], peers, steps, args.reps)
    report = _report(run, steps, results, missing)
    _add_bound(report, run, limits)
    if args.json:
        _write_json(args.json, report)
    if args.json != "-":
        _print(report, results)


def _complete(args: argparse.Namespace) -> Run:
    """What was left open is filled in."""
    block = args.workload == "mpm-block"
    most = len(os.sched_getaffinity(0))
    if args.threads < 0 or args.threads > most:
        raise InputError(f"--threads {args.threads}: expected 1 to {most}, a processor for each, or 0 for all")
    if args.side is not None and args.side < (1 if block else 2):
        raise InputError(f"--side {args.side}: expected 1 cell or more along an edge, of pd-cube 2 particles, which have a bond")
    if args.order and not block:
        raise InputError(f"--order {args.order}: is for mpm-block; pd-cube has no splines of its own")
    return Run(
        workload=args.workload,
        law=args.law or ("fixed_corotated" if block else "pd_bond"),
        transfer=args.transfer or ("apic" if block else "particle"),
        order=(args.order or 2) if block else None,
        precision=args.precision,
        threads=args.threads or most,
        side=args.side or (23 if block else 46),
    )


def _workload(run: Run) -> Workload:
    if run.order is not None:
        return mpm_block(run.side, run.law, run.transfer, run.order, run.precision)
    return pd_cube(run.side, run.law, run.transfer, run.precision)


def take_turns(
    ours: Sequence[tuple[Workload, int]], peers: Sequence[Sequence[str]], steps: int, reps: int
) -> list[Result]:
    """Runs `reps` blocks of `steps` steps of every engine, in turns: workloads with their threads, then command lines."""
    threads = max(count for _, count in ours)
    with ExitStack() as stack:
        engines = [_keep(stack, _ours(workload, count)) for workload, count in ours]
        engines += [_keep(stack, Engine(command, threads)) for command in peers]
        for engine in engines:
            engine.warm_up(ours[0][0].warm_up)
        rounds = [[engine.turn(steps) for engine in engines] for _ in range(reps)]
        return [summary(engine.greeting, turns, engine.finish()) for engine, turns in zip(engines, zip(*rounds))]


def _keep(stack: ExitStack, engine: Engine) -> Engine:
    stack.callback(engine.stop)
    return engine


def _ours(workload: Workload, threads: int) -> Engine:
    command = [sys.executable, "-m", "perimpm.bench.worker", "--threads", str(threads)]
    return Engine(command, threads, json.dumps({"scene": workload.scene, "velocity_gradient": workload.velocity_gradient}))


def summary(greeting: Result, turns: Sequence[Turn], check: Result) -> Result:
    """Wall times per step as rates; spread: (slowest - fastest) / median block."""
    seconds = [turn.seconds_per_step for turn in turns]
    median = statistics.median(seconds)
    bonds = greeting["bonds"]
    return {
        **greeting,
        "seconds_per_step": seconds,
        "ns_per_particle_step": 1e9 * median / greeting["particles"],
        "ns_per_bond": 1e9 * median / bonds if bonds else None,
        "spread": (max(seconds) - min(seconds)) / median,
        "foreign": [round(turn.foreign, 3) for turn in turns],
        "quiet": [turn.quiet for turn in turns],
        "check": check["check"],
    }


def _rate(run_workload: str) -> str:
    return "ns_per_particle_step" if run_workload == "mpm-block" else "ns_per_bond"


def _report(run: Run, steps: int, results: Sequence[Result], missing: Sequence[str]) -> Result:
    ours, rate = results[0], _rate(run.workload)
    keep = ("ns_per_particle_step", "ns_per_bond", "spread", "seconds_per_step", "foreign", "quiet", "check")
    peers = []
    for peer in results[1:]:
        rounds = [theirs / mine for theirs, mine in zip(peer["seconds_per_step"], ours["seconds_per_step"])]
        more = {"ratio_rounds": [round(r, 3) for r in rounds], **{k: peer[k] for k in keep[2:]}}
        ratio = peer[rate] / ours[rate]
        peers.append({"name": peer["name"], "version": peer["version"], "ns": peer[rate], "ratio": ratio, **more})
    return {
        **asdict(run),
        "steps": steps,
        "particles": ours["particles"],
        "bonds": ours["bonds"],
        **{key: ours[key] for key in keep},
        "bytes_per_particle": ours["check"]["bytes"] / ours["particles"],
        "lower_bound_ns": None,
        "peers": peers,
        "missing_peers": list(missing),
        "differences": _differences(results),
    }


def _differences(results: Sequence[Result]) -> list[str]:
    """Peers whose state after the same steps is not ours."""
    ours, found = results[0]["check"], []
    for peer in results[1:]:
        for key, value in peer["check"].items():
            if abs(value - ours[key]) > AGREEMENT.get(key, float("inf")) * abs(ours[key]):
                found.append(f"{peer['name']}: {key} = {value:.6g}, perimpm {ours[key]:.6g} after the same steps")
    return found


def _add_bound(report: Result, run: Run, limits: dict[str, float] | None) -> None:
    if limits is None:
        return
    if run.order is None:
        bound: Result | None = bond_bound(limits, run.precision)
    else:
        local = report["bonds"] == 0
        bound = block_bound(limits, run.transfer, run.order, run.precision) if local else None
    report["limits"] = limits
    if bound:
        report |= {"lower_bound_ns": bound["ns"], "lower_bound": bound}


def _print(report: Result, results: Sequence[Result]) -> None:
    rate = _rate(report["workload"])
    rows = [
        (
            r["name"],
            r["version"],
            f"{r['ns_per_particle_step']:.1f}",
            f"{r['ns_per_bond']:.3f}" if r["ns_per_bond"] else "-",
            f"{r['spread']:.0%}",
            f"{sum(r['quiet'])} of {len(r['quiet'])}",
            f"{r[rate] / results[0][rate]:.2f}",
        )
        for r in results
    ]
    columns = ("engine", "version", "ns per particle-step", "ns per bond", "spread", "quiet blocks", "time / perimpm")
    threads = f"{report['threads']} thread" + "s" * (report["threads"] > 1)
    order = f" of order {report['order']}" if report["order"] else ""
    title = (
        f"{report['workload']}, {report['law']}, {report['transfer']}{order}, side {report['side']}, {report['precision']}, {threads}: "
        f"{report['particles']} particles, {report['bonds']} bonds, {report['bytes_per_particle']:.0f} bytes a particle"
    )
    out = console()
    out.print(table(title, columns, rows, numbers=columns[2:]))
    for line in report["missing_peers"]:
        out.print(f"peer missing: {line}")
    for line in report["differences"]:
        out.print(f"not the same physics: {line}")
    out.print(_bound_line(report, report[rate]))
    check = report["check"]
    out.print(times_table(check["passes"], report["particles"], check["steps"]))


def _bound_line(report: Result, ns: float | None) -> str:
    if "limits" not in report:
        return "lower bound: not measured (--limits measures it)"
    if report["lower_bound_ns"] is None or ns is None:
        return "lower bound: not known for this law and transfer"
    bound = report["lower_bound"]
    parts = ", ".join(f"{key[:-3]} {value:.3g} ns" for key, value in bound.items() if key.endswith("_ns"))
    return f"lower bound {bound['ns']:.3g} ns by {bound['by']} ({parts}): {bound['ns'] / ns:.0%} of the {ns:.3g} ns taken"


def _write_json(path: str, content: Result) -> None:
    text = json.dumps(content, indent=2) + "\n"
    if path == "-":
        print(text, end="")
        return
    try:
        Path(path).write_text(text)
    except OSError as error:
        raise InputError(f"{path}: cannot write the result: {error.strerror}") from None
