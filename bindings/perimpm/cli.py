"""The command `perimpm`. Exit codes: 0 done, 2 bad input, 3 the simulation failed, 130 interrupted."""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path

from . import InputError, SimulationError, __version__
from .describe import describe, plugins, topics
from .explain import explain
from .frames import remove_pictures
from .progress import pass_table
from .simulation import Simulation
from .tables import console, table


def _scene_arguments(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("scene", metavar="SCENE", help="scene file (TOML), or the run.json of a run, to run it again")
    verb.add_argument(
        "--set",
        dest="overrides",
        metavar="a.b=VALUE",
        action="append",
        default=[],
        help="change one value of the scene, in TOML; a table replaces the whole table; may be repeated",
    )
    verb.add_argument("--threads", type=int, default=0, metavar="N", help="worker threads; 0, the default: every core")


def _run(args: argparse.Namespace) -> None:
    output = Path(args.output) if args.output else Path("out") / Path(args.scene).stem
    simulation = Simulation(args.scene, args.overrides, args.threads)
    if replaced := remove_pictures(output):
        print(f"replacing the {replaced} frames of an earlier run in {output}, and its pictures", file=sys.stderr)
    simulation.run(args.frames, output, progress=True)
    console().print(pass_table(simulation))
    print(f"frames and run.xdmf for ParaView: {output}")


def _explain(args: argparse.Namespace) -> None:
    print(explain(Simulation(args.scene, args.overrides, args.threads)), end="")


def _summary(model: str) -> str:
    try:
        return describe(model).summary
    except InputError as error:
        return f"cannot be opened: {error}"


def _plugins(_: argparse.Namespace) -> None:
    rows = [(family, model, _summary(model)) for family, models in plugins().items() for model in models]
    console().print(table("perimpm describe MODEL shows its parameters", ("family", "model", "what it is"), rows))


def _describe(args: argparse.Namespace) -> None:
    if args.name:
        print(describe(args.name), end="")
        return
    rows = [(family, " ".join(names)) for family, names in topics().items()]
    console().print(table("perimpm describe NAME, where NAME is one of", ("about", "names"), rows))


def _render(args: argparse.Namespace) -> None:
    from .render import render

    written = render(
        args.folder,
        color=args.color,
        frames=args.frames,
        size=args.size,
        every=args.every,
        output=args.output,
        progress=True,
    )
    for path in written:
        print(path)


def _surface(args: argparse.Namespace) -> None:
    from .surfaces import surfaces

    for path in surfaces(args.folder, by=args.by, frames=args.frames, every=args.every, output=args.output):
        print(path)


def _bench(args: argparse.Namespace) -> None:
    from .bench.throughput import throughput

    throughput(args)


def _range(text: str) -> tuple[int, int]:
    first, dash, last = text.partition("-")
    try:
        numbers = (int(first), int(last) if dash else int(first))
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}': expected a frame number or a range such as 1-24") from None
    if not 1 <= numbers[0] <= numbers[1]:
        raise argparse.ArgumentTypeError(f"'{text}': frames count from 1 and the first is not after the last")
    return numbers


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    if not (width.isdigit() and height.isdigit() and int(width) > 0 and int(height) > 0):
        raise argparse.ArgumentTypeError(f"'{text}': expected WIDTHxHEIGHT in pixels, such as 1280x720")
    return int(width), int(height)


def _positive(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}': expected a whole number of 1 or more")
    return int(text)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("perimpm", description="MPM and peridynamics, from a scene file to a picture.")
    parser.add_argument("--version", action="version", version=f"perimpm {__version__}")
    verbs = parser.add_subparsers(required=True, metavar="VERB")

    run = verbs.add_parser("run", help="simulate a scene and write frames")
    _scene_arguments(run)
    run.add_argument("-o", "--output", metavar="DIR", help="output folder; default: out/<scene name>")
    run.add_argument("--frames", type=_positive, metavar="N", help="stop at frame N (frame 1 is t = 0)")
    run.set_defaults(action=_run)

    verb = verbs.add_parser("explain", help="print what the scene compiles to, and what is skipped")
    _scene_arguments(verb)
    verb.set_defaults(action=_explain)

    verb = verbs.add_parser("plugins", help="list the installed models")
    verb.set_defaults(action=_plugins)

    verb = verbs.add_parser("describe", help="parameters of a model, or of the scene's tables")
    verb.add_argument("name", metavar="NAME", nargs="?", help='a model, "scene" or one of its tables; without: the list')
    verb.set_defaults(action=_describe)

    _add_render(verbs.add_parser("render", help="make pictures and an animation from frames"))
    _add_surface(verbs.add_parser("surface", help="write the surface of every body or fragment as OBJ, frame by frame"))
    _add_bench(verbs.add_parser("bench", help="measure speed"))
    return parser


def _add_render(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("folder", metavar="DIR", help="folder of a run")
    verb.add_argument("--color", metavar="FIELD", help="colour by this field (magnitude of vectors); default: by body")
    verb.add_argument("--frames", type=_range, metavar="A-B", help="only these frames")
    verb.add_argument("--size", type=_size, default=(1280, 720), metavar="WxH", help="pixels; default 1280x720")
    verb.add_argument("--every", type=_positive, default=1, metavar="N", help="every N-th frame")
    verb.add_argument("-o", "--output", metavar="DIR", help="folder for the pictures; default: DIR/pictures")
    verb.set_defaults(action=_render)


def _add_surface(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("folder", metavar="DIR", help="folder of a run")
    verb.add_argument("--by", metavar="FIELD", help="an object per value of this field; default: fragment, else body")
    verb.add_argument("--frames", type=_range, metavar="A-B", help="only these frames")
    verb.add_argument("--every", type=_positive, default=1, metavar="N", help="every N-th frame")
    verb.add_argument("-o", "--output", metavar="DIR", help="folder for the meshes; default: DIR/surfaces")
    verb.set_defaults(action=_surface)


def _add_bench(verb: argparse.ArgumentParser) -> None:
    kinds = verb.add_subparsers(required=True, metavar="WHAT")
    throughput = kinds.add_parser("throughput", help="ns per particle-step and per bond")
    throughput.add_argument("--workload", choices=("mpm-block", "pd-cube"), default="mpm-block")
    throughput.add_argument("--law", metavar="NAME", help="constitutive model; default: fixed_corotated or pd_bond")
    throughput.add_argument("--transfer", metavar="NAME", help="transfer model; default: apic or particle")
    throughput.add_argument("--order", type=int, choices=(2, 3), help="B-spline degree of mpm-block, whose stress divergence is mls; default 2")
    throughput.add_argument("--precision", choices=("float", "double"), default="float")
    throughput.add_argument("--threads", type=int, default=0, metavar="N", help="0, the default: every core")
    throughput.add_argument("--side", type=_positive, metavar="N", help="cells or particles along an edge; default 23 or 46")
    throughput.add_argument("--steps", type=_positive, metavar="N", help="steps of a timed block; default 50 or 20")
    throughput.add_argument(
        "--reps", type=_positive, default=7, metavar="N", help="timed blocks, at least 5; the median counts; default 7"
    )
    throughput.add_argument("--peers", action="store_true", help="run the installed peers, too, in turns with perimpm")
    throughput.add_argument("--limits", action="store_true", help="measure what the machine can do, too (needs c++)")
    throughput.add_argument(
        "--json", metavar="FILE", nargs="?", const="-", help="write the result there; without FILE: print it as JSON"
    )
    throughput.set_defaults(action=_bench)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    args = _parser().parse_args(arguments)
    with warnings.catch_warnings():
        warnings.simplefilter("always", UserWarning)
        warnings.showwarning = lambda message, *_: print(f"warning: {message}", file=sys.stderr)
        return _act(args)


def _act(args: argparse.Namespace) -> int:
    try:
        args.action(args)
        return 0
    except InputError as error:
        text = str(error)
        print(text if ": error: " in text.partition("\n")[0] else f"error: {text}", file=sys.stderr)
        return 2
    except MemoryError:
        print("error: the scene needs more memory than there is: use a larger grid.spacing", file=sys.stderr)
        return 2
    except SimulationError as error:
        print(f"simulation failed: {error}", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
