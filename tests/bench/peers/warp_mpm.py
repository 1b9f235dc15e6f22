"""The workload mpm-block of `perimpm bench throughput` in Warp on its CPU backend, which runs on one thread.

MLS-MPM, APIC, quadratic B-splines, fixed corotated through Warp's SVD. Grid work is limited to the nodes around the
particles, as on a sparse grid. For the protocol see perimpm.bench.turns.
"""

import argparse

import numpy as np
import warp as wp

from perimpm.bench.turns import serve

parser = argparse.ArgumentParser()
parser.add_argument("--side", type=int, default=23)
parser.add_argument("--threads", type=int, default=1, choices=(1,))
parser.add_argument("--precision", choices=("float", "double"), default="float")
args = parser.parse_args()

wp.config.quiet = True
wp.config.enable_backward = False
wp.init()
real, vec3, vec4, mat33, dtype = (
    (wp.float32, wp.vec3f, wp.vec4f, wp.mat33f, np.float32)
    if args.precision == "float"
    else (wp.float64, wp.vec3d, wp.vec4d, wp.mat33d, np.float64)
)

CELLS, STEP, DENSITY, LAST = 128, 1e-4, 1000.0, 125
SPACING = 1.0 / CELLS
YOUNG, POISSON = 1e5, 0.3
FASTEST = 4.0  # m/s, above every particle's speed
count = 8 * args.side**3


def constant(value):
    return wp.constant(real(value))


DX, INVERSE_DX, DT, GRAVITY = constant(SPACING), constant(CELLS), constant(STEP), constant(9.81)
TWO_MU, LAMBDA = constant(YOUNG / (1 + POISSON)), constant(YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON)))
MASS = constant(DENSITY * (SPACING / 2) ** 3)
STRESS = constant(-STEP * (SPACING / 2) ** 3 * 4 * CELLS**2)  # of the affine momentum by Kirchhoff stress
ZERO, HALF, ONE, THREE_QUARTERS, ONE_AND_A_HALF = (constant(c) for c in (0.0, 0.5, 1.0, 0.75, 1.5))
TWO, FOUR = constant(2.0), constant(4.0)
WALL_LOW, WALL_HIGH = wp.constant(3), wp.constant(LAST)


@wp.func
def spline(d: real):
    a = ONE_AND_A_HALF - d
    b = d - ONE
    c = d - HALF
    return vec3(HALF * a * a, THREE_QUARTERS - b * b, HALF * c * c)


@wp.func
def first_node(s: vec3):
    return wp.vec3i(wp.int32(s[0] - HALF), wp.int32(s[1] - HALF), wp.int32(s[2] - HALF))


@wp.func
def from_node(s: vec3, node: wp.vec3i):
    return vec3(s[0] - real(node[0]), s[1] - real(node[1]), s[2] - real(node[2]))


@wp.func
def kirchhoff(F: mat33):
    u, s, w = wp.svd3(F)
    j = s[0] * s[1] * s[2]
    return TWO_MU * (F - u * wp.transpose(w)) * wp.transpose(F) + LAMBDA * j * (j - ONE) * wp.identity(n=3, dtype=real)


@wp.kernel
def scatter(x: wp.array(dtype=vec3), v: wp.array(dtype=vec3), C: wp.array(dtype=mat33), F: wp.array(dtype=mat33),
            grid: wp.array3d(dtype=vec4)):
    p = wp.tid()
    node = first_node(x[p] * INVERSE_DX)
    d = from_node(x[p] * INVERSE_DX, node)
    wx, wy, wz = spline(d[0]), spline(d[1]), spline(d[2])
    F[p] = F[p] + DT * (C[p] * F[p])
    flow = STRESS * kirchhoff(F[p]) + MASS * C[p]
    start = MASS * v[p] - flow * (d * DX)
    offset = vec3(ZERO, ONE, TWO)
    for i in range(3):
        for j in range(3):
            for k in range(3):
                momentum = start + flow * (vec3(offset[i], offset[j], offset[k]) * DX)
                weight = wx[i] * wy[j] * wz[k]
                share = weight * vec4(momentum[0], momentum[1], momentum[2], MASS)
                wp.atomic_add(grid, node[0] + i, node[1] + j, node[2] + k, share)


@wp.func
def wall(index: int, velocity: real):
    if index < WALL_LOW:
        return wp.max(velocity, ZERO)
    if index > WALL_HIGH:
        return wp.min(velocity, ZERO)
    return velocity


@wp.kernel
def clear(grid: wp.array3d(dtype=vec4), low: wp.vec3i):
    a, b, c = wp.tid()
    grid[a + low[0], b + low[1], c + low[2]] = vec4(ZERO, ZERO, ZERO, ZERO)


@wp.kernel
def update(grid: wp.array3d(dtype=vec4), low: wp.vec3i):
    a, b, c = wp.tid()
    i, j, k = a + low[0], b + low[1], c + low[2]
    node = grid[i, j, k]
    if node[3] > ZERO:
        vx, vy, vz = node[0] / node[3], node[1] / node[3] - DT * GRAVITY, node[2] / node[3]
        grid[i, j, k] = vec4(wall(i, vx), wall(j, vy), wall(k, vz), node[3])


@wp.kernel
def gather(x: wp.array(dtype=vec3), v: wp.array(dtype=vec3), C: wp.array(dtype=mat33), grid: wp.array3d(dtype=vec4)):
    p = wp.tid()
    node = first_node(x[p] * INVERSE_DX)
    d = from_node(x[p] * INVERSE_DX, node)
    wx, wy, wz = spline(d[0]), spline(d[1]), spline(d[2])
    velocity = vec3(ZERO, ZERO, ZERO)
    offset = vec3(ZERO, ONE, TWO)
    moment = mat33(ZERO, ZERO, ZERO, ZERO, ZERO, ZERO, ZERO, ZERO, ZERO)
    for i in range(3):
        for j in range(3):
            for k in range(3):
                q = grid[node[0] + i, node[1] + j, node[2] + k]
                share = wx[i] * wy[j] * wz[k] * vec3(q[0], q[1], q[2])
                velocity = velocity + share
                moment = moment + wp.outer(share, vec3(offset[i], offset[j], offset[k]) - d)
    v[p] = velocity
    C[p] = FOUR * INVERSE_DX * moment
    x[p] = x[p] + DT * velocity


def start():
    cells = np.arange(args.side)
    corner = np.array([64 - args.side // 2, 4, 64 - args.side // 2])
    within = np.stack(np.meshgrid(*[[0.25, 0.75]] * 3, indexing="ij"), -1).reshape(-1, 3)
    cell = np.stack(np.meshgrid(cells, cells, cells, indexing="ij"), -1).reshape(-1, 1, 3)
    return ((corner + cell + within).reshape(-1, 3) * SPACING).astype(dtype)


x = wp.array(start(), dtype=vec3, device="cpu")
v = wp.array(np.tile(np.array([0.0, -2.0, 0.0], dtype), (count, 1)), dtype=vec3, device="cpu")
F = wp.array(np.tile(np.eye(3, dtype=dtype), (count, 1, 1)), dtype=mat33, device="cpu")
C = wp.zeros(count, dtype=mat33, device="cpu")
grid = wp.zeros((CELLS, CELLS, CELLS), dtype=vec4, device="cpu")
box = {}


def surround(steps):
    """Nodes that particles can reach in that many steps; one step more for those that are left behind."""
    now, reach = x.numpy() / SPACING, 2 + int(np.ceil(FASTEST * STEP * (steps + 1) / SPACING))
    low = np.maximum(np.floor(now.min(axis=0)) - reach, 0).astype(int)
    high = np.minimum(np.ceil(now.max(axis=0)) + reach + 1, CELLS).astype(int)
    box.update(low=wp.vec3i(*map(int, low)), size=tuple(map(int, high - low)))


def run(steps):
    for _ in range(steps):
        wp.launch(clear, dim=box["size"], inputs=[grid, box["low"]], device="cpu")
        wp.launch(scatter, dim=count, inputs=[x, v, C, F, grid], device="cpu")
        wp.launch(update, dim=box["size"], inputs=[grid, box["low"]], device="cpu")
        wp.launch(gather, dim=count, inputs=[x, v, C, grid], device="cpu")
    wp.synchronize()


def check():
    return {"y": float(x.numpy()[:, 1].mean(dtype=np.float64)), "vy": float(v.numpy()[:, 1].mean(dtype=np.float64))}


serve({"name": "warp (svd)", "version": wp.config.version, "particles": count, "bonds": 0}, run, check, surround)
