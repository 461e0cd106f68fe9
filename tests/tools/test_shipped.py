"""The wheel is complete: it can begin and plan a study far from any checkout."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from conftest import EXAMPLE

CHECKOUT = EXAMPLE.parent.parent
FOLDERS = ("vsb", "workflow", "profiles", "config")


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The package as a wheel holds it."""
    source, place = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("installed")
    for name in FOLDERS:
        shutil.copytree(CHECKOUT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(CHECKOUT / name, source)
    code = f"from setuptools.build_meta import build_wheel; build_wheel({str(place)!r})"
    subprocess.run([sys.executable, "-c", code], cwd=source, check=True, capture_output=True)
    (wheel,) = place.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(place)
    return place


def test_wheel_holds_every_file(installed):
    shipped = [path for name in FOLDERS for path in (CHECKOUT / name).rglob("*") if path.is_file()]
    names = [path.relative_to(CHECKOUT) for path in shipped if "__pycache__" not in path.parts]
    inside = [name if name.parts[0] == "vsb" else "vsb" / name for name in names]
    assert len(inside) > 120
    assert {Path("vsb/py.typed"), Path("vsb/__init__.pyi")} <= set(inside)
    assert [name for name in inside if not (installed / name).is_file()] == []
    assert {path.name for path in installed.iterdir() if path.is_dir() and "dist-info" not in path.name} == {"vsb"}


def test_default_workflow_is_linted_where_only_snakemake_is_installed():
    """As the workflow catalog does; of the libraries only numpy, which its image brings."""
    code = """
import sys
sys.modules.update(dict.fromkeys(["scipy", "numba", "xarray", "pandas", "capytaine"]))
from snakemake.cli import main
main(["--lint"])
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=CHECKOUT, capture_output=True, text=True, check=False)
    assert "your workflow is in a good condition" in done.stdout + done.stderr


@pytest.mark.slow
def test_installed_package_begins_and_plans_a_study(installed, tmp_path):
    paths = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PYTHONPATH": str(installed), "PATH": paths, "PYTHONSAFEPATH": "1"}

    def vsb(*arguments):
        command = [sys.executable, "-m", "vsb.cli", *arguments]
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
        return done.stdout + done.stderr

    vsb("init", "my_buoy.yaml", "--radius", "4")
    output = vsb("run", "my_buoy.yaml", "-n")
    assert f"Using profile {installed}/vsb/profiles/default" in output
    assert all(name in output for name in ("spectral", "simulate", "results"))
    assert sorted(path.name for path in tmp_path.iterdir()) == [".snakemake", "my_buoy.yaml"]
