"""Pictures and an animation from the frames of a run."""

from __future__ import annotations

import ctypes.util
import importlib.util
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._core import InputError
from .frames import FrameFolder
from .shading import spacing_of
from .tables import console

if TYPE_CHECKING:
    from .stage import Stage

Array = npt.NDArray[Any]

#: Display colour of particles that lack the field shown.
WITHOUT = (0.72, 0.72, 0.72)
#: Linear colours that tell bodies apart, in the order of the bodies.
TINTS = np.array(
    [
        [0.68, 0.12, 0.06],
        [0.05, 0.26, 0.60],
        [0.80, 0.42, 0.05],
        [0.08, 0.40, 0.20],
        [0.36, 0.12, 0.50],
        [0.55, 0.50, 0.44],
    ]
)
POINTS_FOR_CAMERA = 4000  #: per frame


def missing_parts() -> str:
    """What rendering needs and this machine lacks, as a message; "" when nothing is missing."""
    modules = [m for m in ("pyvista", "imageio", "imageio_ffmpeg", "PIL", "h5py") if importlib.util.find_spec(m) is None]
    if modules:
        return f"rendering needs the Python packages {', '.join(modules)}: pip install 'perimpm[render]'"
    if ctypes.util.find_library("EGL") is None:
        return "rendering needs OpenGL without a display: apt-get install libegl1 libgl1-mesa-dri (Debian, Ubuntu)"
    return ""


def render(
    folder: str | Path,
    *,
    color: str | None = None,
    frames: tuple[int, int] | None = None,
    size: tuple[int, int] = (1280, 720),
    every: int = 1,
    output: str | Path | None = None,
    progress: bool = False,
) -> list[Path]:
    """Draws the frames in `folder`; returns the folder of the PNGs, poster.png and animation.mp4.

    Particles are spheres, coloured by body or by the field `color` (the magnitude of vectors, over a range that holds
    for all frames). One camera for all frames sees everything but what has flown far from its body (`in_sight`).
    Raises InputError when a package, OpenGL, the frames or the field are missing.
    """
    if missing := missing_parts():
        raise InputError(missing)
    source = FrameFolder(folder)
    numbers = source.select(frames, every)
    target = Path(output) if output is not None else source.folder / "pictures"
    target.mkdir(parents=True, exist_ok=True)
    bodies = _bodies(source, numbers[0])
    painter = _FieldColors(source, numbers, color) if color else _BodyColors(source, bodies)
    stage = _stage(source, numbers, size, bodies)
    poster = _poster_frame(source, numbers)
    video = target / "animation.mp4"
    with _Video(video, source.frame_rate / every) as film:
        for number, image in _draw(source, numbers, stage, painter, progress):
            _save(image, target / f"frame.{number:04d}.png")
            film.add(image)
    x = source.read(poster, "x").astype(float)
    seen = in_sight(x, source.read(min(source.files), "x"), bodies)
    stage.aim(x[seen], source.time(poster))  # closer: the others share a camera
    _, image = next(_draw(source, [poster], stage, painter, progress=False))
    _save(image, target / "poster.png")
    stage.close()
    return [target, target / "poster.png", video]


def _draw(
    source: FrameFolder, numbers: list[int], stage: Stage, painter: _BodyColors | _FieldColors, progress: bool
) -> Iterator[tuple[int, Array]]:
    start = time.perf_counter()
    for done, number in enumerate(numbers, 1):
        x = source.read(number, "x")
        yield number, painter.label(stage.draw(x, painter.albedo(number), source.time(number)))
        if progress:
            pace = (time.perf_counter() - start) / done
            console(stderr=True).print(f"picture {done}/{len(numbers)}  {pace:.2f} s each")


def _bodies(source: FrameFolder, first: int) -> Array | None:
    """Each particle's body: by the field `body`, else by `material`, if frames have one of them."""
    named = [name for name in ("body", "material") if source.has(first, name)]
    return source.read(first, named[0]).astype(int) if named else None


def in_sight(x: Array, start: Array, bodies: Array | None) -> Array:
    """Whether the camera keeps each particle in the picture: all but those, at most one in twenty of a body, that are more
    than half of the body's radius farther from its middle than at the start and well outside the others. Without bodies
    all particles are one."""
    body_of = np.zeros(len(x), int) if bodies is None else bodies
    kept = np.ones(len(x), bool)
    for body in np.unique(body_of):
        own = body_of == body
        before, now = (np.linalg.norm(at[own] - np.median(at[own], axis=0), axis=1) for at in (start, x))
        outward = now - before
        most, radius = (np.quantile(values, 0.95, method="higher") for values in (outward, now))
        kept[own] = (outward <= max(0.5 * before.max(), most)) | (now <= 1.5 * radius)
    return kept


def _stage(source: FrameFolder, numbers: list[int], size: tuple[int, int], bodies: Array | None) -> Stage:
    from .scenery import obstacles
    from .stage import Stage

    first, start = source.read(numbers[0], "x"), source.read(min(source.files), "x")
    h = spacing_of(first)
    clouds = [source.read(n, "x") for n in numbers]
    for number, x in zip(numbers, clouds):
        if len(x) != len(start):
            raise InputError(f"frame {number} has {len(x)} particles, the first one {len(start)}")
    seen = [x[in_sight(x, start, bodies)] for x in clouds]
    sample = np.concatenate([x[:: max(1, len(x) // POINTS_FOR_CAMERA)] for x in seen]).astype(float)
    bottom = float(min(x[:, 1].min() for x in seen))
    floor = source.ground()
    ground = bottom - 0.5 * h if floor is None else min(floor, bottom)
    scenery = obstacles(source.record.get("scene", {}), sample.min(axis=0), sample.max(axis=0))
    return Stage(sample, h, ground, size, scenery)


def _poster_frame(source: FrameFolder, numbers: list[int]) -> int:
    """Where bodies break, the first frame with a third of the pieces that fragments.csv ends with; else the first impact that
    energy.csv shows; else the middle frame."""
    table = source.folder / "fragments.csv"
    if table.exists():
        times = np.loadtxt(table, delimiter=",", skiprows=1, usecols=0, ndmin=1)
        moments, count = np.unique(times, return_counts=True)
        if len(count) and count[-1] > count[0]:
            broken = moments[first_share(count - count[0], 1 / 3)]
            return min(numbers, key=lambda n: abs(source.time(n) - float(broken)))
    table = source.folder / "energy.csv"
    if table.exists():
        elastic = np.genfromtxt(table, delimiter=",", names=True, ndmin=1)["elastic"]
        shown = [n for n in numbers if n <= len(elastic)]
        if shown and np.isfinite(elastic).all() and elastic.max() > 0:
            return shown[first_peak(elastic[np.array(shown) - 1])]
    return numbers[len(numbers) // 2]


def first_share(values: Array, share: float) -> int:
    """Index of the first value that reaches a share of the last one."""
    return int(np.argmax(values >= share * values[-1]))


def first_peak(values: Array) -> int:
    """Index of the first local maximum that reaches half of the largest value."""
    padded = np.concatenate([[-np.inf], values, [-np.inf]])
    peak = (values >= padded[:-2]) & (values >= padded[2:]) & (values >= 0.5 * values.max())
    return int(np.argmax(peak))


class _BodyColors:
    """One tint per body; where frames do not name bodies, per piece of the first frame."""

    def __init__(self, source: FrameFolder, bodies: Array | None) -> None:
        apart = pieces(source.read(min(source.files), "x")) if bodies is None else bodies
        self._albedo: Array = TINTS[apart % len(TINTS)]

    def albedo(self, number: int) -> Array:
        return self._albedo

    def label(self, image: Array) -> Array:
        return image


class _FieldColors:
    """Colours by a field over one range for all frames, with a scale in the picture's corner."""

    def __init__(self, source: FrameFolder, numbers: list[int], name: str) -> None:
        import matplotlib

        self._source, self._name = source, name
        self._map = matplotlib.colormaps["viridis"].with_extremes(bad=WITHOUT)
        lows, highs, leasts, mosts, lacks = zip(*(self._range(n) for n in numbers))
        self._low, self._high = float(np.nanmin(lows)), float(np.nanmax(highs))
        beyond = np.nanmin(leasts) < self._low or np.nanmax(mosts) > self._high
        unit = source.unit(numbers[0], name)
        self._scale = f"{name}: {self._low:.3g} to {self._high:.3g} {unit}".rstrip()
        self._scale += (", some beyond" if beyond else "") + ("; grey: lacks it" if any(lacks) else "")

    def _range(self, number: int) -> tuple[float, float, float, float, bool]:
        """Where most values of a frame are, its least and largest, and whether particles lack the field."""
        values = self._values(number)
        low, high = np.nanpercentile(values, (0.5, 99.5))
        return low, high, np.nanmin(values), np.nanmax(values), bool(np.isnan(values).any())

    def _values(self, number: int) -> Array:
        values = self._source.read(number, self._name).astype(float)
        return values if values.ndim == 1 else np.asarray(np.linalg.norm(values.reshape(len(values), -1), axis=1))

    def albedo(self, number: int) -> Array:
        share = (self._values(number) - self._low) / max(self._high - self._low, 1e-300)
        return np.asarray(self._map(np.clip(share, 0, 1)))[:, :3] ** 2.2

    def label(self, image: Array) -> Array:
        from PIL import Image, ImageDraw, ImageFont

        height, width = image.shape[:2]
        length, thick, edge = width // 5, max(4, height // 60), height // 24
        picture = Image.fromarray(image)
        strip = np.tile(self._map(np.linspace(0, 1, length))[None, :, :3] * 255, (thick, 1, 1)).astype(np.uint8)
        picture.paste(Image.fromarray(strip), (edge, height - edge - thick))
        font, at = ImageFont.load_default(size=height // 36), (edge, height - edge - thick - height // 22)
        ImageDraw.Draw(picture).text(at, self._scale, fill=(60, 64, 70), font=font)
        return np.asarray(picture)


def pieces(x: Array) -> Array:
    """Number of the connected piece each particle belongs to; particles in touching cells of 2 spacings connect."""
    cell = np.floor((x - x.min(axis=0)) / (2.0 * spacing_of(x))).astype(int) + 1
    shape = tuple(cell.max(axis=0) + 2)
    full = np.zeros(shape, bool)
    full[tuple(cell.T)] = True
    label = np.where(full, np.arange(full.size).reshape(shape) + 1, 0)
    while True:
        grown = label
        for axis in range(3):
            for shift in (-1, 1):
                grown = np.maximum(grown, np.roll(grown, shift, axis))
        grown = np.where(full, grown, 0)
        if np.array_equal(grown, label):
            break
        label = grown
    return np.unique(label[tuple(cell.T)], return_inverse=True)[1]


def _save(image: Array, path: Path) -> None:
    from PIL import Image

    aside = path.with_name(path.name + ".part")
    Image.fromarray(image).save(aside, format="PNG", compress_level=3)
    os.replace(aside, path)


class _Video:
    """An MP4 that any player shows; complete or absent."""

    def __init__(self, path: Path, fps: float) -> None:
        import imageio.v2 as imageio

        self._path, self._aside = path, path.with_name("animation.part.mp4")
        self._writer = imageio.get_writer(
            self._aside, fps=fps, codec="libx264", quality=8, macro_block_size=2, ffmpeg_log_level="error"
        )

    def __enter__(self) -> _Video:
        return self

    def add(self, image: Array) -> None:
        height, width = (n // 2 * 2 for n in image.shape[:2])  # the codec wants even sizes
        self._writer.append_data(image[:height, :width])

    def __exit__(self, kind: object, *_: object) -> None:
        self._writer.close()
        if kind is None:
            os.replace(self._aside, self._path)
        else:
            self._aside.unlink(missing_ok=True)
