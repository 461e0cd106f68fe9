"""Verification: the package by its public face against references computed apart from it (docs/verification.md)."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

import vsb

SEED = {
    "study": "seed",
    "device": {
        "radius": 2.0,
        "thickness": 0.01,
        "young_modulus": 1.0e7,
        "poisson_ratio": 0.3,
        "density": 2700.0,
        "mass": 17170.0,
        "damping": {"beta": 1.0e-3},
    },
    "modes": {"basis": "full", "degree": 6},
    "designs": {"FSB": {"flexible": False}, "VSWEC": {}, "VSWEC90": {"clamp": 90}},
    "water": {"density": 1025.0, "depth": float("inf"), "gravity": 9.81},
    "hydro": {"tolerance": 1.0e-3, "omega_max": 12.0, "witness": "none"},
}
"""The study of the manual; a test replaces sections."""


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """Results of all studies, which share their hydrodynamics."""
    return tmp_path_factory.mktemp("results")


@pytest.fixture(scope="session")
def run(folder):
    """Run the seed's study with other sections, as a user would from a file: its `vsb.Results`."""

    def runner(name: str, **sections) -> vsb.Results:
        path = Path(folder, f"{name}.yaml")
        path.write_text(yaml.safe_dump({**SEED, "study": name, **sections}, sort_keys=False), encoding="utf-8")
        return vsb.run(vsb.load(str(path)), str(folder / "results"))

    return runner


@pytest.fixture(scope="session")
def command():
    """Run the command line of the package: its standard output, and its exit status."""

    def runner(*words) -> tuple[str, int]:
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        environment = {**os.environ, "PATH": path}
        done = subprocess.run(["vsb", *map(str, words)], capture_output=True, text=True, env=environment, check=False)
        assert done.returncode in (0, 1), done.stderr
        return done.stdout, done.returncode

    return runner


@pytest.fixture
def agree(record_property):
    """Compare a quantity with its reference to a stated tolerance, and put it into the table of agreement."""

    def judge(capability: str, quantity: str, value, reference, tolerance: float, *, absolute: bool = False) -> None:
        value, reference = np.asarray(value), np.asarray(reference)
        assert value.shape == reference.shape
        scale = 1.0 if absolute else np.abs(reference).max()
        error = float(np.abs(value - reference).max() / scale)
        row = {"capability": capability, "quantity": quantity, "error": error, "tolerance": tolerance}
        record_property("agreement", json.dumps({**row, "absolute": absolute}))
        assert error <= tolerance, f"{quantity}: {value} against {reference}"

    return judge


def pytest_terminal_summary(terminalreporter) -> None:
    """Print the table of agreement."""
    reports = [r for kind in ("passed", "failed") for r in terminalreporter.stats.get(kind, []) if r.when == "call"]
    rows = [json.loads(value) for r in reports for key, value in r.user_properties if key == "agreement"]
    if not rows:
        return
    terminalreporter.section("agreement with independent references")
    for row in sorted(rows, key=lambda row: row["capability"]):
        unit = "absolute" if row["absolute"] else "of the largest"
        verdict = "" if row["error"] <= row["tolerance"] else "   FAILS"
        terminalreporter.write_line(
            f"{row['capability']:24s} {row['quantity']:62s} {row['error']:8.1e} (at most {row['tolerance']:.0e} {unit}){verdict}"
        )
