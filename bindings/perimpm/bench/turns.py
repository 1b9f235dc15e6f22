"""Engines that take turns on the same processors: one process each, idle while another runs.

An engine prints JSON lines: first a greeting with name, version, particles and bonds; then, for every line with a number
of steps that it reads, a reply with their wall time; in the end, a check of its state. By hand:
``printf '20\\n50\\n' | python taichi_mpm.py --side 23``.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from perimpm import InputError

Tree = dict[str, Any]

QUIET = 0.05  #: of one processor: a turn with more foreign work than that is not quiet


def serve(
    greeting: Mapping[str, Any],
    run: Callable[[int], object],
    check: Callable[[], Mapping[str, Any]],
    prepare: Callable[[int], object] = lambda steps: None,
    processes: int = 1,
) -> None:
    """The engine's side. `prepare` is not timed; `run` returns when its steps are done. `processes`: that work alike."""
    print(json.dumps(greeting), flush=True)
    for line in sys.stdin:
        steps, used = int(line), time.process_time()
        prepare(steps)
        start = time.perf_counter()
        run(steps)
        seconds = time.perf_counter() - start
        cpu = processes * (time.process_time() - used)
        print(json.dumps({"steps": steps, "seconds": seconds, "cpu": cpu}), flush=True)
    print(json.dumps({"check": check()}), flush=True)


@dataclass(frozen=True)
class Turn:
    """One timed block."""

    seconds_per_step: float
    foreign: float  #: work of others in units of one processor, from /proc/stat

    @property
    def quiet(self) -> bool:
        return self.foreign <= QUIET


class Engine:
    """The parent's side: starts the process on `threads` processors; `turn` and `finish` talk to it.

    Parameters
    ----------
    first_line : what the engine wants to read before it greets.
    """

    def __init__(self, command: Sequence[str], threads: int, first_line: str = "") -> None:
        self._what = " ".join(command[:3])
        self._cpus = sorted(os.sched_getaffinity(0))[:threads]
        self._errors = tempfile.TemporaryFile("w+")
        self._process = self._start(command)
        if first_line:
            self._send(first_line)
        self.greeting = self._receive()

    def _start(self, command: Sequence[str]) -> subprocess.Popen[str]:
        """A process is born with its parent's processors."""
        before = os.sched_getaffinity(0)
        bound = {"OMP_NUM_THREADS": str(len(self._cpus)), "OMP_PROC_BIND": "true", "OMP_PLACES": "threads"}
        os.sched_setaffinity(0, self._cpus)
        try:
            return subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                text=True,
                env=os.environ | bound,
            )
        finally:
            os.sched_setaffinity(0, before)

    def warm_up(self, steps: int) -> None:
        """The first step compiles and allocates; the threads that are busy after it each get a processor of their own."""
        self.turn(1)
        before = _thread_times(self._process.pid)
        self.turn(steps - 1)
        after = _thread_times(self._process.pid)
        busiest = sorted(after, key=lambda thread: before.get(thread, 0) - after[thread])
        for thread, cpu in zip(busiest, self._cpus):
            os.sched_setaffinity(thread, {cpu})

    def turn(self, steps: int) -> Turn:
        """Runs `steps` whole steps."""
        busy, start = _busy_seconds(), time.perf_counter()
        self._send(str(steps))
        reply = self._receive()
        passed, work = time.perf_counter() - start, _busy_seconds() - busy
        return Turn(reply["seconds"] / steps, max(0.0, work - reply["cpu"]) / passed)

    def finish(self) -> Tree:
        """Ends the process; returns its check."""
        assert self._process.stdin
        self._process.stdin.close()
        check: Tree = self._receive()
        self._process.wait()
        return check

    def stop(self) -> None:
        """Ends the process in any state."""
        if self._process.poll() is None:
            self._process.terminate()  # mpiexec ends its ranks
            self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout, self._errors):
            assert pipe
            try:
                pipe.close()
            except BrokenPipeError:  # unread input of an engine that has failed
                pass

    def _send(self, line: str) -> None:
        assert self._process.stdin
        try:
            self._process.stdin.write(line + "\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            self._fail()

    def _receive(self) -> Tree:
        assert self._process.stdout
        for line in self._process.stdout:
            if line.startswith("{"):  # libraries print banners
                answer: Tree = json.loads(line)
                return answer
        self._fail()

    def _fail(self) -> NoReturn:
        self._process.wait()
        self._errors.seek(0)
        text = self._errors.read().strip()
        refusal = text.rpartition("error: ")[2] if self._process.returncode == 2 else ""
        raise InputError(refusal or f"the engine '{self._what}' failed:\n{text[-2000:]}")


def _busy_seconds() -> float:
    """Of all processors since boot, what the host took away (steal) included."""
    user, nice, system, _, _, irq, softirq, steal = map(int, Path("/proc/stat").read_text().split()[1:9])
    return (user + nice + system + irq + softirq + steal) / float(os.sysconf("SC_CLK_TCK"))


def _thread_times(pid: int) -> dict[int, int]:
    """Nanoseconds on a processor by thread."""
    tasks = Path(f"/proc/{pid}/task").iterdir()
    return {int(task.name): int((task / "schedstat").read_text().split()[0]) for task in tasks}
