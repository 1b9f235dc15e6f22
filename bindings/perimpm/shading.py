"""Light on particles, computed with NumPy: soft sun shadows, ambient occlusion and smooth normals from a density grid.

Software OpenGL has no time for shadow maps and screen-space occlusion at video size; on a grid of a few cells per
particle they cost some 0.1 s for 100 000 particles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

SUN = np.array([-0.45, 0.80, 0.42]) / np.linalg.norm([-0.45, 0.80, 0.42])
SUN_COLOR = np.array([1.0, 0.95, 0.86]) * 0.95
SKY_COLOR = np.array([0.80, 0.89, 1.0]) * 0.52
BOUNCE_COLOR = np.array([1.0, 0.93, 0.85]) * 0.16  #: light thrown back by the floor


def spacing_of(x: Array, samples: int = 256) -> float:
    """Median distance to the nearest neighbour [m]."""
    if len(x) < 2:
        return 0.01
    chosen = x[:: max(1, len(x) // samples)][:samples].astype(np.float64)
    squared = np.empty(len(chosen))
    for k, point in enumerate(chosen):
        d = ((x - point) ** 2).sum(axis=1)
        d[d == 0.0] = np.inf
        squared[k] = d.min()
    return float(np.sqrt(np.median(squared)))


def blur(grid: Array, radius: int, axes: tuple[int, ...]) -> Array:
    """Two box filters of the given radius in cells: nearly a Gaussian. Beyond the border is nothing."""
    if radius < 1:
        return grid
    for axis in axes:
        for _ in range(2):
            padding = [(0, 0)] * grid.ndim
            padding[axis] = (radius + 1, radius)
            total = np.cumsum(np.pad(grid, padding), axis=axis, dtype=np.float32)
            count = grid.shape[axis]
            high = np.take(total, np.arange(2 * radius + 1, 2 * radius + 1 + count), axis=axis)
            low = np.take(total, np.arange(0, count), axis=axis)
            grid = (high - low) / np.float32(2 * radius + 1)
    return grid


def _sample(grid: Array, position: Array) -> Array:
    """Linear interpolation; `position` in cells, cell centres at whole numbers."""
    top = np.array(grid.shape) - 1.001
    p = np.clip(position, 0.0, top)
    base = p.astype(np.int32)
    part = (p - base).astype(np.float32)
    result = np.zeros(len(p), np.float32)
    for corner in np.ndindex(*(2,) * grid.ndim):
        weight = np.prod(np.where(np.array(corner) == 1, part, 1 - part), axis=1)
        result += weight * grid[tuple((base + corner).T)]
    return result


def _histogram(cell: Array, shape: tuple[int, ...]) -> Array:
    flat = np.ravel_multi_index(tuple(cell.T), shape)
    return np.bincount(flat, minlength=int(np.prod(shape))).reshape(shape).astype(np.float32)


@dataclass
class Lighting:
    """Light on particles `x` of spacing `h` [m] above a floor at height `ground`."""

    x: Array
    h: float
    ground: float

    def __post_init__(self) -> None:
        self._margin = 10
        self._cell = 2.0 * self.h
        # The odd shift keeps the particles of a lattice off the borders of the cells.
        self._low = self.x.min(axis=0) - (self._margin + 0.27) * self._cell
        self._position = (self.x - self._low) / self._cell - 0.5
        cells = np.ceil((self.x.max(axis=0) - self._low) / self._cell).astype(int) + self._margin
        self._shape = (int(cells[0]), int(cells[1]), int(cells[2]))
        cell = np.clip(np.rint(self._position).astype(int), 0, cells - 1)
        self._density = np.minimum(_histogram(cell, self._shape) / 8.0, 1.0)

        self.seen = self._near_surface()  #: indices of the particles that can be seen; the rest is buried

    def _near_surface(self) -> Array:
        return np.flatnonzero(_sample(blur(self._density, 1, (0, 1, 2)), self._position) < 0.93)

    def particle_light(self) -> Array:
        """RGB of the light that each particle of `seen` throws back, for a white surface."""
        position = self._position[self.seen]
        normal = self._normals(position)
        open_sky = self._open_sky(position)
        sun = np.clip(normal @ SUN, 0.0, 1.0) * self._sunlit()[self.seen]
        up = 0.5 + 0.5 * normal[:, 1]
        light: Array = (
            sun[:, None] * SUN_COLOR
            + (open_sky * (0.35 + 0.65 * up))[:, None] * SKY_COLOR
            + (open_sky * (1 - up))[:, None] * BOUNCE_COLOR
        )
        return light

    def _normals(self, position: Array) -> Array:
        smooth = blur(self._density, 1, (0, 1, 2))
        slope = np.stack([_sample(g, position) for g in np.gradient(smooth)], axis=1)
        normal: Array = -slope / np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-6)
        return normal

    def _open_sky(self, position: Array) -> Array:
        """Share of the surroundings that is empty, 1 for a lone flat surface; the floor counts as full."""
        solid = self._density.copy()
        heights = self._low[1] + (np.arange(self._shape[1]) + 0.5) * self._cell
        solid[:, heights < self.ground, :] = 1.0
        near = _sample(blur(solid, 2, (0, 1, 2)), position)
        far = _sample(blur(solid, 5, (0, 1, 2)), position)
        return np.clip(1.0 - 1.1 * np.maximum(near - 0.45, 0) - 1.3 * np.maximum(far - 0.35, 0), 0.15, 1.0)

    def _sunlit(self) -> Array:
        """0 in the shadow of other particles, 1 in the sun; soft over a few spacings."""
        right, up = _sun_axes()
        plane = np.stack([self.x @ right, self.x @ up], axis=1)
        low = plane.min(axis=0) - 2 * self._cell
        position = (plane - low) / self._cell
        shape = tuple(int(n) for n in position.max(axis=0) + 4)
        cell = np.rint(position).astype(int)
        flat = np.ravel_multi_index((cell[:, 0], cell[:, 1]), (shape[0], shape[1]))
        depth = (self.x @ SUN).astype(np.float32)
        nearest = np.full(shape[0] * shape[1], -np.inf, np.float32)
        np.maximum.at(nearest, flat, depth)
        nearest = nearest.reshape(shape)
        lit = np.zeros(len(self.x), np.float32)
        offsets = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
        for i, j in offsets:
            c = np.clip(cell + (i, j), 0, np.array(shape) - 1)
            lit += np.clip(1.0 - (nearest[c[:, 0], c[:, 1]] - depth - 4 * self._cell) / (3 * self._cell), 0.0, 1.0)
        return lit / len(offsets)

    def floor_light(self, center: Array, half: float, pixels: int) -> Array:
        """RGB light on the floor: pixels x pixels over the square of half size `half` [m] around `center` (x, z)."""
        pixel = 2 * half / pixels
        shade = np.zeros((pixels, pixels), np.float32)
        height = np.maximum(self.x[:, 1] - self.ground, 0.0)
        size = float(np.ptp(self.x, axis=0).max()) + self.h
        layers = (0.0, 0.06, 0.2, 0.5, np.inf)
        for low, high in zip(layers[:-1], layers[1:]):
            inside = (height >= low * size) & (height < high * size)
            if inside.any():
                soft = self.h + 0.06 * float(height[inside].mean())
                shade = np.maximum(shade, self._cast(inside, height, SUN, center, half, pixels, soft / pixel))
        near = self._cast(height < 0.25 * size, height, np.array([0.0, 1.0, 0.0]), center, half, pixels, 0.05 * size / pixel)
        sun = (1.0 - shade)[..., None] * (SUN_COLOR * SUN[1])
        light: Array = sun + (1.0 - 0.65 * near)[..., None] * SKY_COLOR
        return light

    def _cast(self, chosen: Array, height: Array, light: Array, center: Array, half: float, pixels: int, soft: float) -> Array:
        """Shadow of some particles along `light` onto the floor, 0 to 1, blurred by `soft` pixels."""
        pixel = 2 * half / pixels
        points = self.x[chosen][:, [0, 2]] - height[chosen, None] * light[[0, 2]] / light[1]
        cell = np.floor((points - center + half) / pixel).astype(int)
        cell = cell[((cell >= 0) & (cell < pixels)).all(axis=1)]
        hits = _histogram(cell, (pixels, pixels)) if len(cell) else np.zeros((pixels, pixels), np.float32)
        grown = np.minimum(blur(hits, max(1, round(0.6 * self.h / pixel)), (0, 1)) * 4.0, 1.0)
        return blur(grown, max(1, round(soft)), (0, 1))


def _sun_axes() -> tuple[Array, Array]:
    right = np.cross([0.0, 1.0, 0.0], SUN)
    right /= np.linalg.norm(right)
    return right, np.cross(SUN, right)


def _tone_curve() -> Array:
    """Display value of linear light 0 to 4 in 4096 parts: soft shoulder above 0.6, then sRGB's power."""
    light = np.linspace(0.0, 4.0, 4097)
    bright = np.where(light > 0.6, 0.6 + 0.4 * (1 - np.exp(-(light - 0.6) / 0.4)), light)
    return np.rint(255 * bright ** (1 / 2.2)).astype(np.uint8)


_CURVE = _tone_curve()


def tone(light: Array) -> Array:
    """Linear light to display values 0 to 255."""
    shown: Array = _CURVE[np.clip(light * 1024, 0, 4096).astype(np.int32)]
    return shown
