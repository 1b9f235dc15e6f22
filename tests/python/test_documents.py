"""The documents as files: nothing in them waits to be written, nothing leans on symbols that only a paper defines."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import perimpm

ROOT = Path(__file__).parents[2]
PAGES = [*ROOT.glob("*.md"), *(p for d in ("core", "plugins", "bindings", "scenes", "tests") for p in (ROOT / d).rglob("*.md"))]
MARKERS = re.compile(r"@@|\b(?:TODO|FIXME|TBD|XXX|PLACEHOLDER|lorem ipsum)\b", re.IGNORECASE)
SYMBOLS = re.compile(r"\(\d+\)|w\^|\bs0\b|\bdelta\b|\bb in\b|\bmicromodulus\b")  # equation numbers and letters


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_no_page_waits_to_be_written(page: Path) -> None:
    assert not MARKERS.search(page.read_text())


def test_pages_are_found() -> None:
    assert ROOT / "README.md" in PAGES and len(PAGES) >= 4


@pytest.mark.parametrize("name", [name for names in perimpm.plugins().values() for name in names])
def test_parameters_explain_themselves(name: str) -> None:
    for _, _, keys in perimpm.describe(name).sections:
        for key in keys:
            assert not SYMBOLS.search(key.doc), f"{name}.{key.key}: {key.doc}"
