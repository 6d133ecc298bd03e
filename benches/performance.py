#!/usr/bin/env python3
"""Measures what a step costs on this machine and writes the tables of docs/performance.md.

    benches/performance.py            everything, on a quiet machine: some ten minutes with the builds
    benches/performance.py --print    the same to the terminal, the page stays as it is
    benches/performance.py --steps N  steps of which the latency is taken (1,000,000)

Needs Rust and python3; valgrind (apt), NumPy and MuJoCo (pip, into target/performance) are installed where they are missing. A peer that
does not install is left out, and the page says so.
"""

import argparse
import datetime
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "performance.md"
START = "<!-- written by benches/performance.py -->\n"
MODES = [0, 10, 20, 40]
METHODS = {"rom": "reduced", "mean-axes": "mean axes", "rigid": "rigid"}
CONSISTENT = ["--inertia", "consistent", "--elastic", "geometric"]
BENCH = ["cargo", "bench", "--workspace", "--locked", "--quiet", "--bench"]


def run(*command, **options):
    return subprocess.run([str(part) for part in command], check=True, text=True, cwd=ROOT, stdout=subprocess.PIPE, **options).stdout


def figures(*command):
    """Lines `KEY<tab>VALUE` that a program prints."""
    return dict(line.split("\t") for line in run(*command).splitlines() if "\t" in line)


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]) + "\n"


def machine():
    processor = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return f"{processor[1] if processor else 'unknown processor'}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} at the start"


def stepping(folder, command):
    """Tables of ns per step, and the model with ten modes."""
    rows, ten = [], None
    for modes in MODES:
        for name, options in (("", []), ("consistent, geometric", CONSISTENT)):
            if options and modes != 10:
                continue
            model = folder / f"{modes}{'c' if options else ''}.rom"
            chosen = ["--modes", str(modes)] if modes else ["--modes", "1"]
            run(*command, "build", "models/fmb.toml", *chosen, *options, "-o", model, "--quiet")
            found = figures(*BENCH, "stepping", "--", model, "lc2")
            for method, label in METHODS.items():
                # Without elastic modes all methods are the rigid body.
                if (modes == 0) != (method == "rigid") or (options and method != "rom"):
                    continue
                for integrator in ("rk4", "newmark"):
                    alone, batch, pool = (float(found.get(f"{method} {integrator}{kind}", "nan")) for kind in ("", " batch", " pool"))
                    row = [name or label, modes, integrator, f"{alone:.0f}", f"{batch:.0f}", f"{alone / batch:.1f}", f"{pool:.0f}", f"{1e-6 * 1e9 / batch:.2f}"]
                    rows.append(row)
            if modes == 10 and not options:
                ten = model
    head = ["method", "modes", "integrator", "alone, ns", "batch of 8, ns", "times faster", "pool, ns", "million steps/s, one core"]
    return table(head, rows), ten


def latency(model, steps):
    pin = ["taskset", "-c", str(os.cpu_count() - 1)]
    found = figures(*pin, *BENCH, "stepping", "--", model, "lc2", str(steps))
    rows = [[key.removeprefix("latency "), *value.split()] for key, value in found.items()]
    return table(["integrator", "least, ns", "median, ns", "99.9 %, ns", "most, ns (information)"], rows)


def bare(model):
    """The evaluation beside the bare contraction of the tensors, by criterion."""
    run(*BENCH, "step", "--", "--quick", "--noplot", "contraction|evaluation", env=os.environ | {"ROM_BENCH_MODEL": str(model)})
    return criterion(lambda group, name: str(model.name) in group)


def through_c():
    run(*BENCH, "overhead", "--", "--noplot")
    return criterion(lambda group, name: "in Rust" in group or "through C" in group)


def criterion(wanted):
    rows = []
    for file in sorted((ROOT / "target" / "criterion").glob("**/new/estimates.json")):
        parts = file.relative_to(ROOT / "target" / "criterion").parts
        if wanted(parts[0].replace("_", "/") if parts[0].startswith("_") else parts[0], parts[-3]):
            rows.append([parts[-3], f"{json.loads(file.read_text())['median']['point_estimate']:.0f}"])
    return table(["", "median, ns"], rows)


def instructions(binaries):
    counts = json.loads(run(ROOT / ".ci/bare/instructions/check", "--json", env=os.environ | {"ROM_BIN": str(binaries)}))
    rows = [[name, f"{count:,}"] for name, count in counts["counts"].items()]
    return table([f"baseline instructions, {counts['compiler']}", "instructions"], rows)


MUJOCO = """
import time, mujoco
def limb(n):
    return "" if n == 0 else f'<body pos="0 0 -.3"><joint type="hinge" axis="{n % 2} {(n + 1) % 2} 0" damping="1"/><geom type="capsule" size=".05" fromto="0 0 0 0 0 -.3"/>{limb(n - 1)}</body>'
xml = f'<mujoco><option timestep="0.002"><flag contact="disable"/></option><worldbody><body><freejoint/><geom type="sphere" size=".2"/>{limb(5)}{limb(5)}{limb(5)}{limb(6)}</body></worldbody></mujoco>'
model = mujoco.MjModel.from_xml_string(xml)
data = mujoco.MjData(model)
best = 1e9
for _ in range(50):
    start = time.perf_counter()
    mujoco.mj_step(model, data, 1000)
    best = min(best, (time.perf_counter() - start) / 1000)
print(f"{mujoco.__version__}\\t{model.nv}\\t{1e9 * best:.0f}")
"""


def mujoco():
    environment = ROOT / "target" / "performance"
    try:
        if not (environment / "bin/python").exists():
            run(sys.executable, "-m", "venv", environment)
        run(environment / "bin/pip", "install", "--quiet", "mujoco", "numpy")
        version, dof, ns = run(environment / "bin/python", "-c", MUJOCO).split()
    except subprocess.CalledProcessError:
        return "MuJoCo did not install here.\n"
    return f"MuJoCo {version}, a free tree of {dof} degrees of freedom without contacts (no flexible body, its semi-implicit Euler): {ns} ns per step.\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--print", action="store_true")
    parser.add_argument("--steps", type=int, default=1_000_000)
    options = parser.parse_args()
    head = f"## Figures\n\n{datetime.date.today()}, {machine()}, {run('rustc', '--version').split(' (')[0]}. All by `benches/performance.py`.\n\n"
    run("cargo", "build", "--release", "--locked", "--quiet", "--bin", "romgen")
    romgen = ROOT / "target" / "release" / "romgen"
    with tempfile.TemporaryDirectory() as name:
        steps, model = stepping(pathlib.Path(name), [romgen])
        text = head + "The frame of `models/fmb.toml` under load case 2, least of many stretches of 200 steps, per step and instance; "
        text += "`cargo bench -p rom-runtime --features parallel --bench stepping -- FILE lc2` gives the rows of a model file.\n\n" + steps
        text += "\n### Latency\n\nTen modes, every step timed on one core (`taskset`), the clock's own time included.\n\n"
        text += latency(model, options.steps)
        text += "\n### Against the bare contraction\n\nThe limit: every stored tensor entry read once (`runtime/benches/step.rs`).\n\n" + bare(model)
    text += "\n### Through C\n\nSetting a load, a step and reading a point, ten modes (`capi/benches/overhead.rs`).\n\n" + through_c()
    text += "\n### Counted\n\n" + instructions(romgen.parent)
    text += "\n### A peer\n\n" + mujoco()
    if options.print:
        print(text)
        return
    page = PAGE.read_text().split(START)[0]
    PAGE.write_text(page.rstrip() + "\n\n" + START + text)


if __name__ == "__main__":
    main()
