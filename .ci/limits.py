#!/usr/bin/env python3
"""Limits of `romgen info` against runs: a reduced model and the nonlinear structure at the amplitudes and rates of the limits.

usage: limits.py ROMGEN [--quick] [MODEL ...]

Amplitudes: a mode is started from the undeformed shape with the rate that carries it to the limit, omega times it, which stretches no
member as a displacement along its straight line would, and runs for one of its periods. Rates: the body spins about the axis at the
limit, and the mode that its stiffening changes first is started likewise to a tenth of its amplitude at 1 %. Asked is the share of what is
left out in what is kept; found is the largest error over the largest displacement of the point that moves farthest in the mode. What the run estimates is of
the worst of the points that move at least a tenth as far as the farthest. The middle of
every member is a named point besides those of the structure: the front wing of the joined wing bows where it has none. A table in Markdown.
"""

import json
import math
import re
import subprocess
import sys
import tempfile
from pathlib import Path

GEOMETRIC = ["--inertia", "consistent", "--elastic", "geometric"]
# name, structure, options of the build
MODELS = [
    ("FMB", "models/fmb.toml", []),
    ("FMB, consistent", "models/fmb.toml", ["--inertia", "consistent"]),
    ("FMB, geometric", "models/fmb.toml", GEOMETRIC),
    ("FFB", "models/ffb.toml", []),
    ("FFB, geometric", "models/ffb.toml", GEOMETRIC),
    ("aircraft", "models/hale.toml", []),
    ("aircraft, geometric", "models/hale.toml", GEOMETRIC),
    ("joined wing, geometric", "models/joined_wing.toml", GEOMETRIC),
]
MODES = 2
# Of the period of the mode.
STEPS = 400


def call(*command):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False, text=True)


def with_middles(text):
    """A structure with the middle of every member as a named point."""
    members = re.findall(r'\[\[members\]\]\s*name = "([^"]+)"', text)
    points = "".join(f'"middle of {member}" = {{ member = "{member}", fraction = 0.5 }}\n' for member in members)
    return re.sub(r"^\[points\].*\n", lambda header: header[0] + points, text, count=1, flags=re.M)


def case(name, omega, mode, amplitude, spin=None):
    """A load case that starts with the rate of a mode, and perhaps with an angular velocity."""
    rates = [0.0] * (mode - 1) + [omega * amplitude]
    start = f"rates = {rates}" + (f", angular_velocity = {spin}" if spin else "")
    period = 2 * math.pi / omega
    return f"\n[load_cases.{name}]\nt_end = {period}\ndt = {period / STEPS}\ninitial = {{ {start} }}\n"


def cases(info, quick):
    """Load cases of the limits, with what they are of: what reaches its limit, the level asked for, the limit, the point to look at."""
    limits = info["limits"]
    omega = {mode["number"]: mode["omega"] for mode in info["modes"]}
    first = {limit["mode"]: limit["amplitude"][0] for limit in limits["amplitudes"]}
    point = {limit["mode"]: limit["point"] for limit in limits["amplitudes"]}
    found = {}
    # Those that move a named point: torsion of a straight beam does not.
    moving = [limit for limit in limits["amplitudes"] if limit["point"]]
    for limit in moving[: 1 if quick else MODES]:
        mode = limit["mode"]
        for k, level in enumerate(limits["levels"]):
            name = f"amplitude_{mode}_{k}"
            moves = f"{limit['point']} by {limit['displacement'][k]:.2g} m" if limit["displacement"] else ""
            about = (f"mode {mode}, {limit['by']}", level, moves, limit["point"])
            found[name] = (about, case(name, omega[mode], mode, limit["amplitude"][k]))
    for axis, limit in enumerate(limits["rates"]):
        # A body that is loaded in equilibrium loses its balance as it turns: its stiffening is not what is seen.
        if not limit or quick or info["equilibrium"]:
            continue
        mode = limit["mode"]
        for k, level in enumerate(limits["levels"]):
            name = f"rate_{axis}_{k}"
            spin = [limit["rate"][k] if a == axis else 0.0 for a in range(3)]
            about = (f"spin about {'xyz'[axis]}, mode {mode}", level, f"{limit['rate'][k]:.2g} rad/s", point[mode])
            found[name] = (about, case(name, omega[mode], mode, 0.1 * first[mode], spin))
    return found


def main():
    romgen, quick = sys.argv[1], "--quick" in sys.argv[2:]
    only = [a for a in sys.argv[2:] if not a.startswith("-")]
    print("| model | limit of | asked | at | found | worst point | estimated while it runs |\n| --- | --- | --- | --- | --- | --- | --- |", flush=True)
    for name, structure, options in MODELS:
        if only and name not in only:
            continue
        with tempfile.TemporaryDirectory() as folder:
            folder = Path(folder)
            model, file = folder / "model.rom", folder / Path(structure).name
            text = with_middles(Path(structure).read_text())
            file.write_text(text)
            subprocess.run([romgen, "build", str(file), *options, "--quiet", "-o", str(model)], check=True)
            found = cases(json.loads(call(romgen, "info", str(model), "--json").stdout), quick)
            file.write_text(text + "".join(case for _, case in found.values()))
            run = call(romgen, "validate", str(file), "--loads", ",".join(found), "--method", "nonlinear,rom", *options, "--json", "-", "--quiet")
            for row in json.loads(run.stdout):
                (what, level, limit, point), _ = found[row["loads"]]
                real = "fails" if row.get("failure") else percent(row["errors"].get(f"{point}.dR_A"))
                worst, told = percent(row.get("worst_dR_A")), percent((row.get("predicted") or {}).get("dR_A"))
                print(f"| {name} | {what} | {100 * level:g} % | {limit} | {real} | {worst} | {told} |", flush=True)


def percent(x):
    return "-" if x is None else f"{100 * x:.2g} %"


if __name__ == "__main__":
    main()
