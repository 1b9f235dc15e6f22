"""Progress of a run on stderr, and the table of passes after it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from . import _core
from .simulation import Simulation
from .tables import console, table

Report = Callable[[_core.Progress], None]


class _Rate:
    """Steps per second over the last half second or more."""

    def __init__(self) -> None:
        self._steps, self._elapsed, self._rate = 0, 0.0, 0.0

    def __call__(self, p: _core.Progress) -> float:
        passed = p.elapsed - self._elapsed
        if passed > 0.5 or self._rate == 0.0 and passed > 0.0:
            self._rate = (p.steps - self._steps) / passed
            self._steps, self._elapsed = p.steps, p.elapsed
        return self._rate


@contextmanager
def reporter(wanted: bool) -> Iterator[Report | None]:
    """A bar on a terminal, one line per frame elsewhere, nothing when not wanted."""
    if not wanted:
        yield None
    elif console(stderr=True).is_terminal:
        with _bar() as report:
            yield report
    else:
        yield _lines()


@contextmanager
def _bar() -> Iterator[Report]:
    columns = (
        TextColumn("frame {task.fields[frame]}/{task.fields[frames]}"),
        BarColumn(),
        TextColumn("{task.fields[particles]} particles  {task.fields[rate]:.0f} substeps/s  ETA"),
        TimeRemainingColumn(),
    )
    rate = _Rate()
    with Progress(*columns, console=console(stderr=True)) as bar:
        task = bar.add_task("", total=None, frame=0, frames=0, particles=0, rate=0.0)

        def report(p: _core.Progress) -> None:
            bar.update(
                task,
                completed=p.time,
                total=p.end_time,
                frame=p.frame,
                frames=p.frames,
                particles=p.particles,
                rate=rate(p),
            )

        yield report


def _lines() -> Report:
    out = console(stderr=True)
    shown = 0
    rate = _Rate()

    def report(p: _core.Progress) -> None:
        nonlocal shown
        speed = rate(p)
        if p.frame == shown:
            return
        shown = p.frame
        left = f"{p.elapsed * (p.end_time / p.time - 1):.0f} s" if p.time > 0 else "unknown"
        out.print(
            f"frame {p.frame}/{p.frames}  t = {p.time:.4g} s  {p.particles} particles  "
            f"{speed:.0f} substeps/s  ETA {left}"
        )

    return report


def pass_table(simulation: Simulation) -> Table:
    """Calls, seconds, share and ns per particle-step of every pass."""
    times = [(p.name, p.calls, p.seconds) for p in simulation.pass_times]
    return times_table(times, simulation.plan.particles, simulation.steps)


def times_table(times: Sequence[tuple[str, int, float]], particles: int, steps: int) -> Table:
    """The same from names, calls and seconds."""
    total = sum(seconds for _, _, seconds in times) or 1.0
    per = 1e9 / max(particles * steps, 1)
    rows = [(name, str(calls), f"{s:.2f}", f"{s / total:.1%}", f"{s * per:.1f}") for name, calls, s in times]
    rows.append(("all", str(steps), f"{total:.2f}", "", f"{total * per:.1f}"))
    columns = ("pass", "calls", "total [s]", "share", "ns per particle-step")
    return table("time per pass", columns, rows, numbers=columns[1:])
