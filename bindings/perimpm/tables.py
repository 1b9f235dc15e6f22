"""Text tables: wide enough to keep words whole where there is no terminal to fit into."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from io import StringIO

from rich import box
from rich.console import Console
from rich.table import Table

PLAIN_WIDTH = 150


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]], numbers: Sequence[str] = ()) -> Table:
    """A table whose columns named in `numbers` stand to the right."""
    result = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    for column in columns:
        result.add_column(column, justify="right" if column in numbers else "left", overflow="fold")
    for row in rows:
        result.add_row(*row)
    return result


def console(stderr: bool = False) -> Console:
    """A console that folds lines at the terminal's width, or at PLAIN_WIDTH without one."""
    result = Console(stderr=stderr, highlight=False, markup=False, emoji=False)
    if not result.is_terminal:
        result.width = PLAIN_WIDTH
    return result


def to_text(*parts: Table | str) -> str:
    """The parts as plain text."""
    out = Console(file=StringIO(), width=PLAIN_WIDTH, highlight=False, markup=False, emoji=False, color_system=None)
    for part in parts:
        out.print(part)
    file = out.file
    assert isinstance(file, StringIO)
    return "\n".join(line.rstrip() for line in file.getvalue().splitlines()).strip() + "\n"
