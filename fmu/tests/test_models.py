"""FMUs of models of every kind, against romrun: clamped, moved, about a loaded equilibrium, of large deflections, with starts of their own."""

import fmpy
import numpy as np
import pytest
from conftest import ROOT, tool
from fmpy.validation import validate_fmu
from slave import values

MAST = """
[structure]
name = "mast"
reference = "foot"
SUPPORT
[gravity]
acceleration = [0, 0, -9.81]
[sections.tube]
shape = "constants"
EA = 1e6
GAy = 1e6
GAz = 1e6
GJ = 40
EIy = 10
EIz = 40
rhoA = 2
rhoJ = [2e-5, 1e-5, 1e-5]
[points]
foot = [0, 0, 0]
top = [2, 0, 0]
[[members]]
name = "mast"
path = ["foot", "top"]
section = "tube"
elements = 12
local_y = [0, 1, 0]
[internal_loads.root]
member = "mast"
fractions = [0, 0.5]
[sensors.imu]
point = "top"
[load_cases.quake]
t_end = 0.2
dt = 0.002
motion = { acceleration = { z = { shape = "sine", omega = 20 } } }
loads = [{ point = "top", frame = "follower", force = [0, 2, 0], time = { shape = "sine", omega = 9 } }]
[load_cases.release]
t_end = 0.2
dt = 0.002
initial = { amplitudes = [0.02], shape_loads = [{ point = "top", frame = "dead", force = [0, 0, 3] }] }
"""


def structures(folder):
    """Of every kind: file, options of romgen build, load cases."""
    for name, support in [("clamped", 'support = "clamped"'), ("free", "")]:
        (folder / f"{name}.toml").write_text(MAST.replace("SUPPORT", support))
    soft = ["--set", "sigma=3", "--set", "elements=30", "--modes", "6", "--inertia", "consistent", "--elastic", "geometric"]
    hale = ["--set", "wing_elements=8", "--modes", "6"]
    return {
        "clamped": (folder / "clamped.toml", ["--modes", "4"], ["quake", "release"]),
        "free": (folder / "free.toml", ["--modes", "4"], ["quake", "release"]),
        "soft": (ROOT / "models" / "fmb.toml", soft, ["lc2"]),
        "hale": (ROOT / "models" / "hale.toml", hale, ["gust"]),
    }


@pytest.mark.parametrize("kind", ["clamped", "free", "soft", "hale"])
def test_every_kind_of_model_does_what_romrun_does(kind, tmp_path):
    structure, options, cases = structures(tmp_path)[kind]
    model = tmp_path / f"{kind}.rom"
    tool("romgen", "build", structure, *options, "-o", model)
    tool("romgen", "export", model, "--fmu", tmp_path / "a.fmu")
    end = ["--t-end", "1"] if kind in ("soft", "hale") else []
    # In turn by FMI 3.0 and 2.0, which do the same.
    for case, path in zip(cases, [tmp_path / "a.fmu", tmp_path / "a-fmi2.fmu"]):
        out = tmp_path / case
        tool("romrun", model, "--loads", case, *end, "--point-motion", "--no-report", "--quiet", "--out", out)
        expected = np.load(out / "results.npz")
        assert kind != "clamped" or validate_fmu(str(path)) == []
        description = fmpy.read_model_description(path)
        load_case = next(t for t in description.typeDefinitions if t.name == "LoadCase")
        number = [item.name for item in load_case.items].index(case)
        channels = {}
        for name in expected.files:
            variables = values(description, name) if name != "q" else [
                v for v in description.modelVariables if v.name.startswith("q[")
            ]
            if variables:
                channels[name] = variables
        missing = set(expected.files) - set(channels)
        kept = {"metadata", "t", "error_indicator", "predicted_error"}
        kept |= {f"reaction_{part}_A" for part in ("inertia", "loads", "increment")}
        assert all(n in kept or n.endswith("_modes") for n in missing), missing
        assert kind != "hale" or "left wing 1.M" in channels
        assert kind not in ("clamped", "free") or {"root 1.F", "imu.a_S"} <= set(channels)
        assert (kind, case) not in [("clamped", "quake"), ("free", "quake")] or "reaction_A" in channels
        names = [v.name for variables in channels.values() for v in variables]
        dt, stop = expected["t"][1], expected["t"][-1]
        found = fmpy.simulate_fmu(
            str(path), start_values={"load_case": number}, stop_time=stop, output_interval=dt, step_size=dt, output=names
        )
        assert len(found) == len(expected["t"])
        for name, variables in channels.items():
            rows = np.atleast_2d(expected[name].T)
            assert len(variables) == len(rows) > 0, name
            scale = max(1.0, np.abs(expected[name]).max())
            for variable, row in zip(variables, rows):
                assert np.abs(found[variable.name] - row).max() <= 1e-9 * scale, (case, variable.name)
