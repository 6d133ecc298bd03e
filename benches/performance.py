#!/usr/bin/env python3
"""Measures what a step costs on this machine and writes the tables of docs/performance.md.

    benches/performance.py build       makes the programs that are measured
    benches/performance.py             measures what has not been measured yet, part by part, and writes the page
    benches/performance.py steps fmu   measures these parts anew and no others: steps, latency, contraction, c, python, fmu, counted, peers
    benches/performance.py --print     the same to the terminal; the page stays as it is
    benches/performance.py --quick     fewer models and shorter stretches, to see that it works: never writes the page

What is found is kept in target/performance/figures.json as soon as it is there, so that a run that was stopped goes on. Needs Rust, gcc
and python3; valgrind (apt), NumPy, MuJoCo and Exudyn (pip, into target/performance/venv) are installed where they are missing; the wheel
of the Python package is taken from `wheels/` (README) where there is one. A peer or a package that is not to be had is left out, and the
page says so. ROM_BIN names a folder with romgen; otherwise target/release or target/debug.
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
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "performance.md"
HOME = ROOT / "target" / "performance"
KEPT = HOME / "figures.json"
START = "<!-- written by benches/performance.py -->\n"
METHODS = {"rom": "reduced", "mean-axes": "mean axes", "rigid": "rigid"}
CONSISTENT = ["--inertia", "consistent", "--elastic", "geometric"]
# Package, benchmark and features of the programs that are measured: each by itself, without the generator.
BENCHES = {"stepping": ("rom-runtime", ["--features", "parallel"]), "step": ("rom-runtime", ["--features", "parallel"]), "overhead": ("rom-capi", [])}


def run(*command, **options):
    return subprocess.run([str(part) for part in command], check=True, text=True, cwd=ROOT, stdout=subprocess.PIPE, **options).stdout


def kept():
    return json.loads(KEPT.read_text()) if KEPT.exists() else {}


def keep(**found):
    HOME.mkdir(parents=True, exist_ok=True)
    KEPT.write_text(json.dumps(kept() | found, indent=2) + "\n")


def build():
    # The format may have changed with the programs.
    for file in HOME.glob("*.rom"):
        file.unlink()
    environment = os.environ | {"CARGO_TARGET_DIR": str(HOME / "build"), "CARGO_INCREMENTAL": "0"}
    programs = kept().get("programs", {})
    for bench, (package, features) in BENCHES.items():
        said = run("cargo", "bench", "--package", package, *features, "--bench", bench, "--locked", "--no-run", "--message-format", "json", env=environment)
        messages = (json.loads(line) for line in said.splitlines() if line.startswith("{"))
        made = [m["executable"] for m in messages if m.get("executable") and m["target"]["name"] == bench]
        programs[bench] = made[-1]
        keep(programs=programs)
    run("cargo", "build", "--package", "rom-fmu", "--release", "--locked", "--quiet", env=environment)
    programs["fmu"] = str(HOME / "build" / "release" / "librom_fmu.so")
    keep(programs=programs)


class Missing(Exception):
    """What a part needs and is not there."""


def program(name):
    found = kept().get("programs", {}).get(name)
    if not found or not pathlib.Path(found).exists():
        raise Missing(f"{name} has not been built (benches/performance.py build)")
    return found


def romgen():
    folders = [os.environ["ROM_BIN"]] if "ROM_BIN" in os.environ else [ROOT / "target/release", ROOT / "target/debug"]
    for folder in folders:
        if (pathlib.Path(folder) / "romgen").exists():
            return (pathlib.Path(folder) / "romgen").resolve()
    sys.exit("there is no romgen: cargo build --release")


def model(modes, *options):
    file = HOME / f"{modes}{'-consistent' if options else ''}.rom"
    if not file.exists():
        HOME.mkdir(parents=True, exist_ok=True)
        run(romgen(), "build", "models/fmb.toml", "--modes", max(modes, 1), *options, "-o", file, "--quiet")
    return file


def figures(*command):
    """Lines `KEY<tab>VALUE` that a program prints."""
    return dict(line.split("\t") for line in run(*command).splitlines() if "\t" in line)


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows]) + "\n"


def machine():
    processor = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return f"{processor[1] if processor else 'unknown processor'}, {os.cpu_count()} cores"


def steps(quick):
    """ns per step, for models of 0 to 40 modes, by method and integrator, alone and in a batch."""
    rows = []
    for modes, options, name in [(0, [], ""), (10, [], ""), (20, [], ""), (40, [], ""), (10, CONSISTENT, "consistent, geometric")]:
        if quick and modes not in (0, 10) or quick and options:
            continue
        found = figures(program("stepping"), model(modes, *options), "lc2")
        for method, label in METHODS.items():
            # Without elastic modes all methods are the rigid body.
            if (modes == 0) != (method == "rigid") or (options and method != "rom"):
                continue
            for integrator in ("rk4", "newmark"):
                alone, batch, pool = (float(found.get(f"{method} {integrator}{kind}", "nan")) for kind in ("", " batch", " pool"))
                rows.append([name or label, modes, integrator, f"{alone:.0f}", f"{batch:.0f}", f"{alone / batch:.1f}", f"{1e3 / batch:.2f}", f"{1e3 / pool:.2f}"])
    text = "Load case 2, per step and instance, the least of many stretches of 200 steps. By hand: `cargo bench -p rom-runtime --features parallel --bench stepping -- FILE lc2`.\n\n"
    head = ["method", "modes", "integrator", "alone, ns", "batch of 8, ns", "times faster", "million steps/s, one core", "all cores"]
    return text + table(head, rows)


def latency(quick):
    """Every one of a million steps timed."""
    count = 100_000 if quick else 1_000_000
    pin = ["taskset", "-c", os.cpu_count() - 1]
    found = figures(*pin, program("stepping"), model(10), "lc2", count)
    rows = [[key.removeprefix("latency "), *value.split()] for key, value in found.items()]
    text = f"Ten modes, each of {count:,} steps timed by itself on one core, the clock's own time (some 25 ns) included. By hand: `taskset -c 1 cargo bench -p rom-runtime --bench stepping -- FILE lc2 {count}`.\n\n"
    return text + table(["integrator", "least, ns", "median, ns", "99.9 %, ns", "most, ns (information)"], rows)


def criterion(command, wanted, environment=None):
    folder = HOME / "criterion"
    run(*command, env=os.environ | {"CRITERION_HOME": str(folder)} | (environment or {}))
    rows = []
    for file in sorted(folder.glob("**/new/estimates.json")):
        parts = file.relative_to(folder).parts
        if wanted(parts[0], parts[-3]):
            rows.append([parts[-3], f"{json.loads(file.read_text())['median']['point_estimate']:.0f}"])
    return rows


def contraction(_quick):
    """An evaluation of the equations beside the contraction of its tensors alone."""
    rom = model(10)
    command = [program("step"), "--bench", "--quick", "--noplot", "contraction|evaluation"]
    rows = criterion(command, lambda group, name: rom.name in group, {"ROM_BENCH_MODEL": str(rom)})
    text = "Ten modes. The limit is every stored tensor entry read once, times a product taken as given. By hand: `ROM_BENCH_MODEL=FILE cargo bench -p rom-runtime --bench step`.\n\n"
    return text + table(["", "median, ns"], rows)


def c(_quick):
    """Setting a load, a step, reading a point: in Rust and through C."""
    rows = criterion([program("overhead"), "--bench", "--noplot"], lambda group, name: "in Rust" in name or "through C" in name)
    text = "Setting a load, a step and reading a point, a lumped model of ten modes. By hand: `cargo bench -p rom-capi`.\n\n"
    return text + table(["", "median, ns"], rows)


def venv(*packages):
    environment = HOME / "venv"
    if not (environment / "bin/python").exists():
        run(sys.executable, "-m", "venv", environment)
    run(environment / "bin/pip", "install", "--quiet", *packages)
    return environment / "bin/python"


def python(_quick):
    """A step from Python: one call for each, and one for many."""
    wheels = sorted((ROOT / "wheels").glob("romgen-*.whl"))
    if not wheels:
        raise Missing("there is no wheel in wheels/ (README)")
    said = run(venv("numpy", "--force-reinstall", wheels[-1]), "python/bench/overhead.py")
    return "By hand: `python3 python/bench/overhead.py`.\n\n```text\n" + said + "```\n"


def fmu(_quick):
    """A communication step of one internal step, called from C through FMI 2.0."""
    rom = model(10)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run(romgen(), "export", rom, "--fmu", folder / "fmb.fmu", "--fmi", "2")
        with zipfile.ZipFile(folder / "fmb.fmu") as archive:
            archive.extractall(folder)
        xml = (folder / "modelDescription.xml").read_text()
        token = re.search(r'guid="([^"]*)"', xml)[1]
        reference = {name: re.search(rf'<ScalarVariable name="{name}"[^>]*valueReference="(\d+)"', xml)[1] for name in ("load_case", "dt", "integrator")}
        run("gcc", "-O2", "-o", folder / "fmu_step", "benches/fmu_step.c", "-ldl")
        rows = []
        for integrator, number, dt in (("rk4", 2, 0.005), ("newmark", 1, 0.01)):
            arguments = [program("fmu"), token, f"file://{folder}/resources", reference["load_case"], 2, reference["dt"], dt, reference["integrator"], number]
            rows.append([integrator, run(folder / "fmu_step", *arguments).strip()])
    text = "Ten modes, load case 2, called from C (`benches/fmu_step.c`), the least of stretches of 200 steps.\n\n"
    return text + table(["integrator", "ns per communication step"], rows)


def counted(_quick):
    """Instructions under callgrind."""
    counts = json.loads(run(ROOT / ".ci/bare/instructions/check", "--json", env=os.environ | {"ROM_BIN": str(romgen().parent)}))
    rows = [[name, f"{count:,}"] for name, count in counts["counts"].items()]
    return "The runtime without std. By hand: `.ci/bare/instructions/check`.\n\n" + table([f"baseline instructions, {counts['compiler']}", "instructions"], rows)


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
print(f"{mujoco.__version__}\\t{model.nv} {1e9 * best:.0f}")
"""


def peers(_quick):
    """Other engines in the same run."""
    rows = []
    try:
        for version, found in figures(venv("numpy", "mujoco"), "-c", MUJOCO).items():
            dof, ns = found.split()
            rows.append([f"MuJoCo {version}", f"a free tree of {dof} degrees of freedom as its humanoid has, no contacts, semi-implicit Euler", ns])
    except subprocess.CalledProcessError:
        rows.append(["MuJoCo", "did not install here", ""])
    try:
        python = venv("numpy", "scipy", "exudyn")
        found = figures(python, ROOT / "benches/peers/exudyn_floating.py")
        rows += [[f"Exudyn {version}", text, ns] for version, found in found.items() for text, ns in [found.rsplit(" ", 1)]]
    except subprocess.CalledProcessError:
        rows.append(["Exudyn", "did not install or run here", ""])
    return table(["engine", "what it steps", "ns per step"], rows)


PARTS = {
    "steps": ("Steps", steps),
    "latency": ("Latency", latency),
    "contraction": ("Against the bare contraction", contraction),
    "c": ("Through C", c),
    "python": ("Through Python", python),
    "fmu": ("Through FMI", fmu),
    "counted": ("Counted", counted),
    "peers": ("Peers", peers),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help="build, or parts to measure anew")
    parser.add_argument("--print", action="store_true")
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    if unknown := set(options.parts) - PARTS.keys() - {"build"}:
        parser.error(f"{', '.join(sorted(unknown))}: expected build or some of {', '.join(PARTS)}")
    if "build" in options.parts:
        build()
        if options.parts == ["build"]:
            return
    place = "quick" if options.quick else "measured"
    wanted = set(options.parts) - {"build"}
    for name, (_, measure) in PARTS.items():
        if name in wanted if wanted else name not in kept().get(place, {}):
            print(f"{name} ..", file=sys.stderr)
            try:
                text = measure(options.quick)
            except Missing as missing:
                print(f"{name}: {missing}", file=sys.stderr)
                continue
            keep(**{place: kept().get(place, {}) | {name: text}})
    text = f"## Figures\n\n{datetime.date.today()}, {machine()}, {run('rustc', '--version').split(' (')[0]}; all by `benches/performance.py`. "
    text += "The machine is a virtual one that others share: compare the figures with each other rather than with those of another machine.\n"
    for name, (title, _) in PARTS.items():
        text += f"\n### {title}\n\n{kept().get(place, {}).get(name, 'Not measured on this machine.' + chr(10))}"
    if options.print or options.quick:
        print(text)
    else:
        PAGE.write_text(PAGE.read_text().split(START)[0].rstrip() + "\n\n" + START + text)


if __name__ == "__main__":
    main()
