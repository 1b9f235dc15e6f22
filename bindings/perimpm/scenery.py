"""The colliders of a scene as surfaces, and where they are at a given time."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import numpy.typing as npt
import pyvista as pv

Array = npt.NDArray[Any]

MOST_POINTS = 60_000  #: that cover one obstacle


class Obstacle:
    """One collider. `surface` stands as at t = 0; `placement` moves it."""

    def __init__(self, collider: dict[str, Any], surface: pv.PolyData) -> None:
        self.surface = surface
        self.bounded: bool = collider["shape"]["type"] != "plane"
        self._velocity, self._spin, self._pivot = (
            np.asarray(collider.get(key, (0.0, 0.0, 0.0)), float) for key in ("velocity", "angular_velocity", "pivot")
        )

    def placement(self, time: float) -> Array:
        """4 x 4 matrix: rotation about the pivot, which moves with the collider's velocity."""
        rate = float(np.linalg.norm(self._spin))
        matrix = np.eye(4)
        matrix[:3, :3] = _turn(self._spin / rate, rate * time) if rate > 0 else np.eye(3)
        matrix[:3, 3] = self._pivot + time * self._velocity - matrix[:3, :3] @ self._pivot
        return matrix

    def cover(self, h: float) -> None:
        """Spreads points over the surface, about one per square of side `h`, to cast the obstacle's shadow."""
        sheet = self.surface.triangulate()
        corners = sheet.points[sheet.faces.reshape(-1, 4)[:, 1:]].astype(float)
        edges = corners[:, 1:] - corners[:, :1]
        area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
        random = np.random.default_rng(1)
        count = int(np.clip(2 * area.sum() / h**2, 100, MOST_POINTS))
        chosen = random.choice(len(area), count, p=area / area.sum())
        a, b = np.sqrt(random.random(count)), random.random(count)
        weights = np.stack([1 - a, a * (1 - b), a * b], axis=1)
        self._points = np.einsum("ij,ijk->ik", weights, corners[chosen])

    def points(self, time: float) -> Array:
        """The points that `cover` made, at `time`."""
        matrix = self.placement(time)
        return np.asarray(self._points @ matrix[:3, :3].T + matrix[:3, 3])


def obstacles(scene: dict[str, Any], low: Array, high: Array) -> list[Obstacle]:
    """Colliders of the resolved scene of a run.json; tilted planes are squares around the box from `low` to `high`.
    Level planes are the floor and not among them."""
    found = []
    for collider in scene.get("collider", []):
        shape = collider["shape"]
        if shape["type"] == "plane" and is_level(shape):
            continue
        surface = _surface(shape, 0.5 * (low + high), float((high - low).max()))
        if surface is not None:
            found.append(Obstacle(collider, surface))
    return found


def is_level(shape: dict[str, Any]) -> bool:
    """Whether a plane faces straight up."""
    normal = np.asarray(shape["normal"], float)
    return bool(normal[1] > 0.999 * np.linalg.norm(normal))


def _surface(shape: dict[str, Any], center: Array, size: float) -> pv.PolyData | None:
    kind = shape["type"]
    if kind == "box":
        bounds = np.column_stack([shape["min"], shape["max"]]).ravel()
        return pv.Box(bounds.tolist())
    if kind == "sphere":
        return pv.Sphere(radius=shape["radius"], center=shape["center"], theta_resolution=64, phi_resolution=64)
    if kind == "cylinder":
        start, end = np.asarray(shape["start"], float), np.asarray(shape["end"], float)
        length = float(np.linalg.norm(end - start))
        middle, along = 0.5 * (start + end), (end - start) / length
        return pv.Cylinder(center=middle, direction=along, radius=shape["radius"], height=length, resolution=64)
    if kind == "plane":
        normal = np.asarray(shape["normal"], float) / np.linalg.norm(shape["normal"])
        foot = center - np.dot(center - np.asarray(shape["point"], float), normal) * normal
        return pv.Plane(center=foot, direction=normal, i_size=2 * size, j_size=2 * size)
    return _mesh(shape)


def _mesh(shape: dict[str, Any]) -> pv.PolyData | None:
    try:
        mesh = pv.read(shape["file"])
    except (OSError, ValueError) as error:
        warnings.warn(f"a collider is not drawn: {error}", stacklevel=2)
        return None
    surface: pv.PolyData = (mesh if isinstance(mesh, pv.PolyData) else mesh.extract_geometry()).triangulate()
    x, y, z = np.radians(shape["rotation"])
    turn = _turn(np.eye(3)[2], z) @ _turn(np.eye(3)[1], y) @ _turn(np.eye(3)[0], x)
    surface.points = shape["scale"] * (surface.points @ turn.T) + np.asarray(shape["translation"], float)
    return surface


def _turn(axis: Array, angle: float) -> Array:
    """Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)
