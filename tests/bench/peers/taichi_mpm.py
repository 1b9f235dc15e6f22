"""The workload mpm-block of `perimpm bench throughput` in Taichi: MLS-MPM, APIC, quadratic B-splines, fixed corotated.

Prints one JSON line with the wall time per step of each timed block. Grid work is limited to the block's surroundings,
as on a sparse grid.
"""

import argparse
import json
import time

import numpy as np
import taichi as ti

parser = argparse.ArgumentParser()
parser.add_argument("--side", type=int, default=23)
parser.add_argument("--threads", type=int, default=1)
parser.add_argument("--precision", choices=("float", "double"), default="float")
parser.add_argument("--steps", type=int, default=50)
parser.add_argument("--reps", type=int, default=3)
args = parser.parse_args()

real = ti.f32 if args.precision == "float" else ti.f64
dtype = np.float32 if args.precision == "float" else np.float64
ti.init(arch=ti.cpu, default_fp=real, cpu_max_num_threads=args.threads, fast_math=True, log_level=ti.ERROR)

CELLS, DT, DENSITY, GRAVITY, WALL = 128, 1e-4, 1000.0, 9.81, 3
DX = 1.0 / CELLS
YOUNG, POISSON = 1e5, 0.3
MU, LAMBDA = YOUNG / (2 * (1 + POISSON)), YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
VOLUME = (DX / 2) ** 3
MASS = DENSITY * VOLUME
count = 8 * args.side**3

x = ti.Vector.field(3, real, count)
v = ti.Vector.field(3, real, count)
affine = ti.Matrix.field(3, 3, real, count)
F = ti.Matrix.field(3, 3, real, count)
grid = ti.Vector.field(4, real, (CELLS, CELLS, CELLS))  # momentum or velocity, mass

side0 = 64 - args.side // 2
low, high = (side0 - 6, 0, side0 - 6), (side0 + args.side + 7, args.side + 10, side0 + args.side + 7)


@ti.func
def spline(d):
    return ti.Matrix.rows([0.5 * (1.5 - d) ** 2, 0.75 - (d - 1.0) ** 2, 0.5 * (d - 0.5) ** 2])


@ti.func
def kirchhoff(deformation):
    u, s, w = ti.svd(deformation)
    j = s[0, 0] * s[1, 1] * s[2, 2]
    rotation = u @ w.transpose()
    return 2 * MU * (deformation - rotation) @ deformation.transpose() + ti.Matrix.identity(real, 3) * LAMBDA * j * (j - 1)


@ti.kernel
def clear():
    for i, j, k in ti.ndrange((low[0], high[0]), (low[1], high[1]), (low[2], high[2])):
        grid[i, j, k] = ti.Vector.zero(real, 4)


@ti.kernel
def scatter():
    ti.loop_config(serialize=args.threads == 1)  # one thread needs no atomics
    for p in range(count):
        base = ti.floor(x[p] / DX - 0.5, ti.i32)
        d = x[p] / DX - base.cast(real)
        w = spline(d)
        F[p] += DT * affine[p] @ F[p]
        flow = MASS * affine[p] - DT * VOLUME * 4 / DX**2 * kirchhoff(F[p])
        for i, j, k in ti.static(ti.ndrange(3, 3, 3)):
            arm = (ti.Vector([i, j, k], dt=real) - d) * DX
            momentum = MASS * v[p] + flow @ arm
            weight = w[i, 0] * w[j, 1] * w[k, 2]
            grid[base + ti.Vector([i, j, k])] += weight * ti.Vector([momentum.x, momentum.y, momentum.z, MASS])


@ti.kernel
def update():
    for i, j, k in ti.ndrange((low[0], high[0]), (low[1], high[1]), (low[2], high[2])):
        node = grid[i, j, k]
        if node.w > 0:
            velocity = ti.Vector([node.x, node.y, node.z]) / node.w
            velocity.y -= DT * GRAVITY
            index = ti.Vector([i, j, k])
            for axis in ti.static(range(3)):
                if index[axis] < WALL:
                    velocity[axis] = ti.max(velocity[axis], 0)
                if index[axis] > CELLS - WALL:
                    velocity[axis] = ti.min(velocity[axis], 0)
            grid[i, j, k] = ti.Vector([velocity.x, velocity.y, velocity.z, node.w])


@ti.kernel
def gather():
    for p in range(count):
        base = ti.floor(x[p] / DX - 0.5, ti.i32)
        d = x[p] / DX - base.cast(real)
        w = spline(d)
        velocity = ti.Vector.zero(real, 3)
        moment = ti.Matrix.zero(real, 3, 3)
        for i, j, k in ti.static(ti.ndrange(3, 3, 3)):
            node = grid[base + ti.Vector([i, j, k])]
            share = w[i, 0] * w[j, 1] * w[k, 2] * ti.Vector([node.x, node.y, node.z])
            velocity += share
            moment += share.outer_product(ti.Vector([i, j, k], dt=real) - d)
        v[p] = velocity
        affine[p] = moment * 4 / DX
        x[p] += DT * velocity


def start():
    cells = np.arange(args.side)
    corner = np.array([side0, 4, side0])
    within = np.stack(np.meshgrid(*[[0.25, 0.75]] * 3, indexing="ij"), -1).reshape(-1, 3)
    cell = np.stack(np.meshgrid(cells, cells, cells, indexing="ij"), -1).reshape(-1, 1, 3)
    x.from_numpy(((corner + cell + within).reshape(-1, 3) * DX).astype(dtype))
    v.from_numpy(np.tile(np.array([0.0, -2.0, 0.0], dtype), (count, 1)))
    F.from_numpy(np.tile(np.eye(3, dtype=dtype), (count, 1, 1)))


def run(steps):
    for _ in range(steps):
        clear()
        scatter()
        update()
        gather()
    ti.sync()


start()
run(20)
seconds = []
for _ in range(args.reps):
    begin = time.perf_counter()
    run(args.steps)
    seconds.append((time.perf_counter() - begin) / args.steps)
name = "taichi " + ".".join(map(str, ti.__version__)) + " (SVD)"
check = {"y": float(x.to_numpy()[:, 1].mean(dtype=np.float64)), "vy": float(v.to_numpy()[:, 1].mean(dtype=np.float64))}
print(json.dumps({"name": name, "particles": count, "bonds": 0, "seconds_per_step": seconds, "check": check}))
