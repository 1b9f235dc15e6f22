"""The workload pd-cube of `perimpm bench throughput` in Taichi: prototype microelastic bonds in compressed rows.

A bond is a directed entry of a family. For the protocol see perimpm.bench.turns.
"""

import argparse
import math

import numpy as np
import taichi as ti

from perimpm.bench.turns import serve

parser = argparse.ArgumentParser()
parser.add_argument("--side", type=int, default=46)
parser.add_argument("--threads", type=int, default=1)
parser.add_argument("--precision", choices=("float", "double"), default="float")
args = parser.parse_args()

real = ti.f32 if args.precision == "float" else ti.f64
dtype = np.float32 if args.precision == "float" else np.float64
ti.init(arch=ti.cpu, default_fp=real, cpu_max_num_threads=args.threads, fast_math=True, log_level=ti.ERROR)

DX, DT, DENSITY, YOUNG, STRETCH = 1e-3, 5e-8, 2440.0, 72e9, 0.5
HORIZON = 3.015 * DX
BULK = YOUNG / 1.5  # nu = 1/4
SPRING = 18 * BULK / (math.pi * HORIZON**4)  # Silling and Askari 2005
side = args.side
count = side**3
lattice = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), -1).reshape(-1, 3)


def families():
    """Rows, neighbours, reference lengths and spring constants times partial volumes; layer by layer, for the memory."""
    reach = np.arange(-3, 4)
    steps = np.stack(np.meshgrid(reach, reach, reach, indexing="ij"), -1).reshape(-1, 3)
    length = DX * np.linalg.norm(steps, axis=1)
    steps, length = steps[(length > 0) & (length <= HORIZON)], length[(length > 0) & (length <= HORIZON)]
    partial = np.clip((HORIZON - length) / DX + 0.5, 0, 1) * DX**3
    parts = []
    for layer in np.split(lattice, side):
        ends = layer[:, None, :] + steps
        exists = ((ends >= 0) & (ends < side)).all(axis=2)
        neighbour = (ends @ np.array([side * side, side, 1]))[exists].astype(np.int32)
        spread = [np.broadcast_to(values.astype(dtype), exists.shape)[exists] for values in (length, SPRING * partial)]
        parts.append((exists.sum(axis=1), neighbour, *spread))
    sizes, *rest = (np.concatenate(column) for column in zip(*parts))
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32), *rest


row0, neighbour0, length0, weight0 = families()
bonds = len(neighbour0)
x, v, force = (ti.Vector.field(3, real, count) for _ in range(3))
row, neighbour = ti.field(ti.i32, count + 1), ti.field(ti.i32, bonds)
length, weight = ti.field(real, bonds), ti.field(real, bonds)
for field, values in ((row, row0), (neighbour, neighbour0), (length, length0), (weight, weight0)):
    field.from_numpy(values)
del row0, neighbour0, length0, weight0
position = lattice * DX
x.from_numpy(position.astype(dtype))
velocity = np.zeros_like(position)
velocity[:, 0] = -5 + 10 * position[:, 0] / (side * DX)
velocity[:, 1] = 3 - 6 * position[:, 1] / (side * DX)
v.from_numpy(velocity.astype(dtype))


@ti.kernel
def forces():
    for p in range(count):
        here = x[p]
        total = ti.Vector.zero(real, 3)
        for b in range(row[p], row[p + 1]):
            rest = length[b]
            if rest > 0:  # a broken bond has a negative length
                apart = x[neighbour[b]] - here
                now = apart.norm()
                stretch = (now - rest) / rest
                if stretch > STRETCH:
                    length[b] = -rest
                total += weight[b] * stretch / now * apart
        force[p] = total


@ti.kernel
def move():
    for p in range(count):
        v[p] += DT / DENSITY * force[p]
        x[p] += DT * v[p]


def run(steps):
    for _ in range(steps):
        forces()
        move()
    ti.sync()


def check():
    """Kinetic energy [J]. Positions are half a step ahead of velocities: half a kick brings them to one time."""
    forces()
    now = v.to_numpy().astype(np.float64) + 0.5 * DT / DENSITY * force.to_numpy().astype(np.float64)
    return {"kinetic": 0.5 * DENSITY * DX**3 * float((now**2).sum())}


version = ".".join(map(str, ti.__version__))
serve({"name": "taichi (CSR)", "version": version, "particles": count, "bonds": bonds}, run, check)
