"""What is installed, and what each model and scene table accepts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rich.table import Table

from . import _core
from .tables import table, to_text


@dataclass(frozen=True)
class Description:
    """A model or the scene's tables: `sections` hold the declared keys. As text it is a reference page."""

    name: str
    family: str  #: "transfer", "constitutive", "fracture", or "" for the scene
    summary: str
    path: str  #: the plugin's file
    sections: tuple[tuple[str, str, tuple[_core.Param, ...]], ...]  #: title, meaning, keys

    def __str__(self) -> str:
        parts: list[Table | str] = [f"{self.name}: {self.summary}"]
        if self.path:
            parts.append(f"{self.family} model, from {self.path}")
        for title, doc, keys in self.sections:
            if doc:
                parts += ["", f"{title}: {doc}"]
            parts.append(_key_table("" if doc else title, keys))
        return to_text(*parts)


def _value(param: _core.Param) -> str:
    if param.default is None:
        return "required" if param.required else "-"
    if isinstance(param.default, bool):
        return "true" if param.default else "false"
    return f"{param.default:g}" if isinstance(param.default, float) else str(param.default)


def _key_table(title: str, keys: Sequence[_core.Param]) -> Table:
    rows = [
        (
            key.key,
            " | ".join(key.choices) or key.kind,
            "" if key.unit == "1" else key.unit,
            key.range,
            _value(key),
            key.doc + (" (may vary per particle)" if key.per_particle else ""),
        )
        for key in keys
    ]
    return table(title, ("key", "kind", "unit", "range", "default", "meaning"), rows)


def plugins() -> dict[str, list[str]]:
    """Names of the installed models by family; opens none of them."""
    families: dict[str, list[str]] = {"transfer": [], "constitutive": [], "fracture": []}
    for family, name, _ in _core.installed():
        families.setdefault(family, []).append(name)
    return families


def topics() -> dict[str, list[str]]:
    """Everything that `describe` knows: the scene and its tables, then the models by family."""
    tables = [s.topic for s in _core.scene_reference()][1:]  # the first one is the scene itself
    return {"scene": ["scene", *tables]} | {family: [family, *names] for family, names in plugins().items()}


def describe(name: str) -> Description:
    """Parameters of a model with unit, range, default and meaning.

    ``describe("scene")`` gives all tables of a scene, ``describe("body")`` one of them, ``describe("transfer")`` every
    model of a family.
    """
    sections = {s.topic: (s.name, s.doc, tuple(s.keys)) for s in _core.scene_reference()}
    if name == "scene":
        return Description("scene", "", "tables of a scene file or dict; SI units, Y up", "", tuple(sections.values()))
    if name in sections:
        title, doc, keys = sections[name]
        return Description(title, "", doc, "", (("", "", keys),))
    if name in plugins():
        models = [describe(model) for model in plugins()[name]]
        return Description(name, "", "every model of this family", "", tuple((m.name, m.summary, m.sections[0][2]) for m in models))
    model = _core.open_model(name, [word for words in topics().values() for word in words])
    return Description(model.name, model.family, model.summary, model.path, (("", "", tuple(model.params)),))
