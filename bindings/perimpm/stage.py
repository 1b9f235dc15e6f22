"""The stage of a picture: particles as spheres, a floor that fades into the background, a camera."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .shading import Lighting, tone

os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

import pyvista as pv  # noqa: E402  (the render window is chosen above)
from vtkmodules.vtkRenderingCore import vtkActor  # noqa: E402
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLSphereMapper  # noqa: E402

if TYPE_CHECKING:
    from .scenery import Obstacle

Array = npt.NDArray[Any]

VIEW_ANGLE = 28.0  #: vertical [degrees]
VIEW_FROM = np.array([0.30, 0.34, 1.0]) / np.linalg.norm([0.30, 0.34, 1.0])
BACKDROP = np.array([0.80, 0.83, 0.86])  #: linear light
FLOOR = np.array([0.62, 0.64, 0.66])  #: how much the floor throws back
FLOOR_PIXELS = 640
OBSTACLE = (0.74, 0.76, 0.78)  #: display colour of colliders
NEAR = 3.0  #: colliders up to so many times the size of the bodies' region are kept in the picture and cast shadows


class Stage:
    """Draws frames of particles with spacing `h` [m] that stay inside `points` (a sample over all frames)."""

    def __init__(
        self,
        points: Array,
        h: float,
        ground: float,
        size: tuple[int, int],
        scenery: Sequence[Obstacle] = (),
        smooth: int = 2,
    ) -> None:
        self._h, self._ground, self._size, self._smooth = h, ground, size, smooth
        self._plotter = pv.Plotter(off_screen=True, window_size=[smooth * size[0], smooth * size[1]], lighting="none")
        window: Any = self._plotter.render_window
        window.SetMultiSamples(0)  # the picture is drawn larger and averaged down instead
        self._plotter.set_background((tone(BACKDROP) / 255.0).tolist())
        self._spheres = self._add_spheres()
        self._obstacles = [(obstacle, self._add_obstacle(obstacle)) for obstacle in scenery]
        self._near = [o for o in scenery if o.bounded and _extent(o.surface.points) < NEAR * _extent(points)]
        for obstacle in self._near:
            obstacle.cover(h)
        self._lay_floor(np.concatenate([points, *(o.points(0.0) for o in self._near)]))
        self.aim(points)

    def _add_spheres(self) -> Any:
        mapper = vtkOpenGLSphereMapper()
        mapper.SetRadius(0.62 * self._h)
        mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectColorArray("rgb")
        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetAmbient(0.72)
        actor.GetProperty().SetDiffuse(0.34)
        self._plotter.renderer.AddActor(actor)
        self._plotter.add_light(pv.Light(position=(-0.45, 0.9, 0.9), light_type="scene light"))
        return mapper

    def _add_obstacle(self, obstacle: Obstacle) -> Any:
        return self._plotter.add_mesh(
            obstacle.surface,
            color=OBSTACLE,
            ambient=0.58,
            diffuse=0.46,
            specular=0.08,
            specular_power=10,
            smooth_shading=True,
            split_sharp_edges=True,
            feature_angle=50,
            culling="back",  # a wall seen from behind hides nothing
        )

    def _lay_floor(self, points: Array) -> None:
        low, high = points.min(axis=0), points.max(axis=0)
        self._center = (0.5 * (low + high))[[0, 2]]
        self._half = 2.2 * float((high - low).max()) + 10 * self._h
        side = 2 * self._half
        center = (self._center[0], self._ground, self._center[1])
        self._floor = pv.Plane(center=center, direction=(0, 1, 0), i_size=side, j_size=side)
        corner = self._floor.points[:, [0, 2]] - self._center + self._half
        self._floor.active_texture_coordinates = (corner / side).astype(np.float32)
        actor = self._plotter.add_mesh(self._floor, texture=_texture(self._floor_image(None)), lighting=False)
        self._floor_actor = actor
        grid = (np.arange(FLOOR_PIXELS) + 0.5) / FLOOR_PIXELS * 2 - 1
        radius = np.hypot(grid[:, None], grid[None, :])
        fade = np.clip((radius - 0.30) / 0.65, 0.0, 1.0)
        self._fade = (fade * fade * (3 - 2 * fade))[..., None]
        self._grain = np.random.default_rng(1).uniform(0.99, 1.01, (FLOOR_PIXELS, FLOOR_PIXELS, 1))  # hides bands

    def _floor_image(self, light: Array | None) -> Array:
        if light is None:
            return np.zeros((2, 2, 3), np.uint8)
        shown = tone((light * FLOOR * (1 - self._fade) + BACKDROP * self._fade) * self._grain)
        return np.ascontiguousarray(np.swapaxes(shown, 0, 1)[::-1])  # rows of a texture run down z

    def aim(self, points: Array, time: float = 0.0) -> None:
        """Moves the camera back until every point, the colliders near them and the floor below are inside the picture
        with a margin."""
        points = np.concatenate([points, *(o.points(time) for o in self._near)])
        points = np.concatenate([points, points * [1, 0, 1] + [0, self._ground, 0]])
        right = np.cross([0.0, 1.0, 0.0], VIEW_FROM)
        right /= np.linalg.norm(right)
        up = np.cross(VIEW_FROM, right)
        tangent = np.tan(np.radians(VIEW_ANGLE / 2)) * 0.86
        aspect = self._size[0] / self._size[1]
        focus = 0.5 * (points.min(axis=0) + points.max(axis=0))
        distance = 1.0
        for _ in range(4):
            across, along, toward = ((points - focus) @ axis for axis in (right, up, VIEW_FROM))
            distance = float(max((np.abs(across) / (aspect * tangent) + toward).max(), (np.abs(along) / tangent + toward).max()))
            depth = np.maximum(distance - toward, 1e-9)
            for offset, axis in ((across, right), (along, up)):
                seen = offset / depth
                focus = focus + axis * (0.5 * (seen.max() + seen.min()) * distance)
        distance += 4 * self._h
        camera = self._plotter.camera
        camera.position, camera.focal_point, camera.up = focus + distance * VIEW_FROM, focus, (0, 1, 0)
        camera.view_angle = VIEW_ANGLE
        camera.clipping_range = (0.02 * distance, 50 * distance)

    def draw(self, x: Array, albedo: Array, time: float = 0.0) -> Array:
        """The picture, height x width x 3 bytes, of particles at `x` with colours `albedo` (linear, 0 to 1)."""
        for obstacle, actor in self._obstacles:
            actor.user_matrix = obstacle.placement(time)
        lighting = Lighting(x, self._h, self._ground)
        cloud = pv.PolyData(np.ascontiguousarray(x[lighting.seen], np.float32))
        cloud["rgb"] = tone(albedo[lighting.seen] * lighting.particle_light())
        self._spheres.SetInputData(cloud)
        shades = np.concatenate([x, *(o.points(time) for o in self._near)]) if self._near else x
        floor = Lighting(shades, self._h, self._ground).floor_light(self._center, self._half, FLOOR_PIXELS)
        self._floor_actor.texture = _texture(self._floor_image(floor))
        self._plotter.render()
        image = np.asarray(self._plotter.screenshot(return_img=True))[..., :3]
        return self._shrink(image)

    def _shrink(self, image: Array) -> Array:
        from PIL import Image

        if self._smooth == 1:
            return image
        return np.asarray(Image.fromarray(image).reduce(self._smooth))

    def close(self) -> None:
        """Frees the render window."""
        self._plotter.close()


def _extent(points: Array) -> float:
    return float(np.ptp(points, axis=0).max())


def _texture(image: Array) -> pv.Texture:
    texture = pv.Texture(image)  # type: ignore[no-untyped-call,unused-ignore]
    texture.interpolate = True
    return texture
