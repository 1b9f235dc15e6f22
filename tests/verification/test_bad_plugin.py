"""Plugins that do not fit are refused like any bad input."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from bad_scenes import good, put, require_refused


def compile_plugin(folder: Path, source: str) -> None:
    compiler = shutil.which("g++") or shutil.which("c++")
    if not compiler:
        pytest.skip("no compiler")
    (folder / "constitutive").mkdir()
    file = folder / "stranger.cpp"
    file.write_text(source)
    subprocess.run(
        [compiler, "-shared", "-fPIC", str(file), "-o", str(folder / "constitutive" / "stranger.so")], check=True
    )


STAMP = 'extern "C" __attribute__((visibility("default"))) const struct { char magic[8]; unsigned rest[64]; } '
PLUGINS = {
    "no stamp": ("int nothing;", ["stranger.so", "perimpm_abi_stamp"]),
    "wrong stamp": (STAMP + 'perimpm_abi_stamp = {"perimpm", {999}};', ["stranger.so", "rebuild"]),
    "foreign stamp": (STAMP + 'perimpm_abi_stamp = {"another", {1}};', ["stranger.so"]),
}


@pytest.mark.parametrize("name", list(PLUGINS))
def test_plugin_that_does_not_fit(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    source, words = PLUGINS[name]
    plugins = tmp_path / "plugins"
    plugins.mkdir()
    compile_plugin(plugins, source)
    monkeypatch.setenv("PERIMPM_PLUGIN_PATH", str(plugins))
    tree = put(good(), "material.m.constitutive", {"type": "stranger"})
    require_refused(tree, ["material.m.constitutive", *words], tmp_path, capsys)


def test_plugin_that_is_no_library(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "constitutive").mkdir()
    (tmp_path / "constitutive" / "stranger.so").write_text("not a library")
    monkeypatch.setenv("PERIMPM_PLUGIN_PATH", str(tmp_path))
    tree = put(good(), "material.m.constitutive", {"type": "stranger"})
    require_refused(tree, ["material.m.constitutive", "stranger.so"], tmp_path, capsys)
