import os
import pathlib
import shutil
import subprocess

import fmpy
import pytest
from slave import Slave

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Where romgen and romrun are; both as the tests of the workspace build them.
PROGRAMS = pathlib.Path(os.environ.get("ROM_BIN", ROOT / "target" / "debug"))


def tool(name, *arguments):
    subprocess.run([PROGRAMS / name, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """The frame with a sine load besides its own, as a model, as FMUs and as results of romrun."""
    folder = tmp_path_factory.mktemp("fmu")
    structure = (ROOT / "models" / "fmb.toml").read_text() + """
[sensors."nose imu"]
point = "P"

[load_cases.push]
t_end = 2
dt = 0.001
loads = [{ point = "P", frame = "body", force = [0, 40, 0], time = { shape = "sine", omega = 3 } }]
"""
    (folder / "fmb.toml").write_text(structure)
    tool("romgen", "build", folder / "fmb.toml", "-o", folder / "fmb.rom")
    tool("romgen", "export", folder / "fmb.rom", "--fmu", folder / "fmb.fmu")
    return folder


@pytest.fixture(scope="session")
def romrun(folder):
    """Results of a load case by romrun, as a dict of arrays."""
    import numpy as np

    def run(*options):
        out = folder / "-".join(options).strip("-").replace(" ", "_").replace("/", "_")
        if not out.exists():
            tool("romrun", folder / "fmb.rom", "--loads", *options, "--no-report", "--quiet", "--out", out)
        return np.load(out / "results.npz")

    yield run
    shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(scope="session")
def bent(tmp_path_factory):
    """FMUs of a structure whose only member bends at the point that carries A, with names of every kind."""
    folder = tmp_path_factory.mktemp("bent")
    (folder / "bent.toml").write_text("""
[structure]
name = "bent 1"
reference = "knee"
[materials.alloy]
E = 70e9
nu = 0.3
rho = 2700
[sections.rod]
shape = "circle"
material = "alloy"
diameter = 0.02
[points]
"2nd end" = [0, -1, 0.2]
knee = [0, 0, 0]
initial = [0, 1, 0.2]
[[members]]
name = "rod+"
path = ["2nd end", "knee", "initial"]
section = "rod"
elements = 4
local_y = [1, 0, 0]
[sensors.knee]
point = "knee"
""")
    tool("romgen", "build", folder / "bent.toml", "--modes", "2", "-o", folder / "bent.rom")
    tool("romgen", "export", folder / "bent.rom", "--fmu", folder / "bent.fmu")
    return [folder / "bent.fmu", folder / "bent-fmi2.fmu"]


@pytest.fixture(params=["3.0", "2.0"], scope="session")
def fmu(request, folder):
    """Path of the FMU of a version of FMI."""
    return folder / {"3.0": "fmb.fmu", "2.0": "fmb-fmi2.fmu"}[request.param]


@pytest.fixture(scope="session")
def unzipped(fmu, tmp_path_factory):
    return pathlib.Path(fmpy.extract(str(fmu), tmp_path_factory.mktemp("unzipped")))


@pytest.fixture
def slave(fmu, unzipped):
    return lambda **options: Slave(fmu, unzipped, **options)
