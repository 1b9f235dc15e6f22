"""Plugins that do not fit are refused like any bad input."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from bad_scenes import good, put, require_refused
from trees import write

import perimpm
from perimpm.cli import main


def compile_plugin(folder: Path, source: str) -> None:
    compiler = shutil.which("g++") or shutil.which("c++")
    assert compiler, "plugins are built with g++ or c++"
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


def test_plugin_path_that_does_not_exist(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """No fault of the scene: no line of it is blamed."""
    monkeypatch.setenv("PERIMPM_PLUGIN_PATH", f"{tmp_path}:{tmp_path / 'nowhere'}")
    assert main(["explain", str(write(good(), tmp_path / "scene.toml"))]) == 2
    shown = capsys.readouterr().err
    assert shown.startswith(f"PERIMPM_PLUGIN_PATH: error: the folder '{tmp_path / 'nowhere'}' does not exist\n")
    assert "scene.toml" not in shown


def configure(folder: Path, lists: str, *options: str) -> subprocess.CompletedProcess[str]:
    """A project of an author's own."""
    cmake = shutil.which("cmake")
    if not cmake or not shutil.which("c++"):
        pytest.skip("no cmake or no compiler")
    (folder / "CMakeLists.txt").write_text(
        f"cmake_minimum_required(VERSION 3.25)\nproject(mine LANGUAGES CXX)\nfind_package(perimpm REQUIRED)\n{lists}\n"
    )
    package = Path(perimpm.__file__).parent / "lib" / "cmake" / "perimpm"
    words = [cmake, "-S", str(folder), "-B", str(folder / "build"), f"-Dperimpm_DIR={package}", *options]
    return subprocess.run(words, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("sources", ["", " SOURCES other.cpp"])
def test_plugin_without_its_source(sources: str, tmp_path: Path) -> None:
    seen = configure(tmp_path, f"perimpm_add_plugin(constitutive my_law{sources})")
    file = tmp_path / ("other.cpp" if sources else "my_law.cpp")
    assert seen.returncode != 0
    assert f"perimpm_add_plugin(constitutive my_law): there is no file {file}" in " ".join(seen.stderr.split())
    assert "add_library" not in seen.stderr


def test_authors_see_the_warnings_of_their_compiler(tmp_path: Path) -> None:
    """And none of a file that gives no reason, for every instruction set."""
    law = Path(__file__).parents[1] / "out_of_tree" / "saint_venant_kirchhoff.cpp"
    shutil.copy(law, tmp_path / "careful.cpp")
    (tmp_path / "careless.cpp").write_text("int careless() { int n; return n; }\n")
    lists = "perimpm_add_plugin(constitutive careful)\nperimpm_add_plugin(constitutive careless)"
    seen = configure(tmp_path, lists, "-DCMAKE_CXX_FLAGS=-Wall -Wextra", "-DCMAKE_BUILD_TYPE=Release")
    assert seen.returncode == 0, seen.stderr
    words = ["cmake", "--build", str(tmp_path / "build")]
    seen = subprocess.run(words, capture_output=True, text=True, check=False)
    shown = seen.stdout + seen.stderr
    assert seen.returncode == 0, shown
    warned = [line for line in shown.splitlines() if "warning:" in line]
    assert warned and all("careless.cpp" in line and "uninitialized" in line for line in warned)
