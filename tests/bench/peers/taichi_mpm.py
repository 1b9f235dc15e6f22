"""The workload mpm-block of `perimpm bench throughput` in Taichi: MLS-MPM, APIC, quadratic B-splines, fixed corotated.

Forms: --polar svd, as published Taichi codes have it, or newton, Higham's iteration; --scatter atomic over all threads, or
serial on one, which needs no atomic additions (the default with one thread). Grid work is limited to the nodes around the
particles, as on a sparse grid. For the protocol see perimpm.bench.turns.
"""

import argparse

import numpy as np
import taichi as ti

from perimpm.bench.turns import serve

parser = argparse.ArgumentParser()
parser.add_argument("--side", type=int, default=23)
parser.add_argument("--threads", type=int, default=1)
parser.add_argument("--precision", choices=("float", "double"), default="float")
parser.add_argument("--polar", choices=("svd", "newton"), default="svd")
parser.add_argument("--scatter", choices=("atomic", "serial"))
args = parser.parse_args()
args.scatter = args.scatter or ("serial" if args.threads == 1 else "atomic")

real = ti.f32 if args.precision == "float" else ti.f64
dtype = np.float32 if args.precision == "float" else np.float64
ti.init(arch=ti.cpu, default_fp=real, cpu_max_num_threads=args.threads, fast_math=True, log_level=ti.ERROR)

CELLS, DT, DENSITY, GRAVITY, WALL = 128, 1e-4, 1000.0, 9.81, 3
DX = 1.0 / CELLS
YOUNG, POISSON = 1e5, 0.3
MU, LAMBDA = YOUNG / (2 * (1 + POISSON)), YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
VOLUME = (DX / 2) ** 3
MASS = DENSITY * VOLUME
NEWTON = 5  # iterations: double precision for the stretches of this workload
FASTEST = 4.0  # m/s, above every particle's speed
count = 8 * args.side**3

x = ti.Vector.field(3, real, count)
v = ti.Vector.field(3, real, count)
affine = ti.Matrix.field(3, 3, real, count)
F = ti.Matrix.field(3, 3, real, count)
grid = ti.Vector.field(4, real, (CELLS, CELLS, CELLS))  # momentum or velocity, mass


@ti.func
def spline(d):
    return ti.Matrix.rows([0.5 * (1.5 - d) ** 2, 0.75 - (d - 1.0) ** 2, 0.5 * (d - 0.5) ** 2])


@ti.func
def kirchhoff(deformation):
    j = deformation.determinant()
    rotation = deformation
    if ti.static(args.polar == "svd"):
        u, _, w = ti.svd(deformation)
        rotation = u @ w.transpose()
    else:
        for _ in ti.static(range(NEWTON)):
            rotation = 0.5 * (rotation + rotation.inverse().transpose())
    return 2 * MU * (deformation - rotation) @ deformation.transpose() + ti.Matrix.identity(real, 3) * LAMBDA * j * (j - 1)


@ti.kernel
def clear(a: ti.types.ndarray(ti.i32, 1), b: ti.types.ndarray(ti.i32, 1)):
    for i, j, k in ti.ndrange((a[0], b[0]), (a[1], b[1]), (a[2], b[2])):
        grid[i, j, k] = ti.Vector.zero(real, 4)


@ti.kernel
def scatter():
    ti.loop_config(serialize=args.scatter == "serial")
    for p in range(count):
        base = ti.floor(x[p] / DX - 0.5, ti.i32)
        d = x[p] / DX - base.cast(real)
        w = spline(d)
        F[p] += DT * affine[p] @ F[p]
        flow = MASS * affine[p] - DT * VOLUME * 4 / DX**2 * kirchhoff(F[p])
        start = MASS * v[p] - flow @ (d * DX)
        for i, j, k in ti.static(ti.ndrange(3, 3, 3)):
            momentum = start + flow @ (ti.Vector([i, j, k], dt=real) * DX)
            weight = w[i, 0] * w[j, 1] * w[k, 2]
            grid[base + ti.Vector([i, j, k])] += weight * ti.Vector([momentum.x, momentum.y, momentum.z, MASS])


@ti.kernel
def update(a: ti.types.ndarray(ti.i32, 1), b: ti.types.ndarray(ti.i32, 1)):
    for i, j, k in ti.ndrange((a[0], b[0]), (a[1], b[1]), (a[2], b[2])):
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
    corner = np.array([64 - args.side // 2, 4, 64 - args.side // 2])
    within = np.stack(np.meshgrid(*[[0.25, 0.75]] * 3, indexing="ij"), -1).reshape(-1, 3)
    cell = np.stack(np.meshgrid(cells, cells, cells, indexing="ij"), -1).reshape(-1, 1, 3)
    x.from_numpy(((corner + cell + within).reshape(-1, 3) * DX).astype(dtype))
    v.from_numpy(np.tile(np.array([0.0, -2.0, 0.0], dtype), (count, 1)))
    F.from_numpy(np.tile(np.eye(3, dtype=dtype), (count, 1, 1)))


low, high = np.zeros(3, np.int32), np.zeros(3, np.int32)


def surround(steps):
    """Nodes that particles can reach in that many steps; one step more for those that are left behind."""
    now, reach = x.to_numpy() / DX, 2 + int(np.ceil(FASTEST * DT * (steps + 1) / DX))
    low[:] = np.maximum(np.floor(now.min(axis=0)) - reach, 0)
    high[:] = np.minimum(np.ceil(now.max(axis=0)) + reach + 1, CELLS)


def run(steps):
    for _ in range(steps):
        clear(low, high)
        scatter()
        update(low, high)
        gather()
    ti.sync()


def check():
    return {"y": float(x.to_numpy()[:, 1].mean(dtype=np.float64)), "vy": float(v.to_numpy()[:, 1].mean(dtype=np.float64))}


start()
form = ", ".join([args.polar] + ([f"{args.scatter} scatter"] if args.threads > 1 else []))
version = ".".join(map(str, ti.__version__))
serve({"name": f"taichi ({form})", "version": version, "particles": count, "bonds": 0}, run, check, surround)
