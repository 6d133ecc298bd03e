#!/usr/bin/env python3
"""Our nonlinear path against Exudyn: the flexible multi-beam frame, load case 1, sigma = 1.

What is compared
    The frame of `models/fmb.toml` (Hesse & Palacios 2012, section 4.2), load case `lc1`: 20 s with dt = 0.01 s, 60
    and 120 two-node geometrically exact beam elements, generalised-alpha with rho_inf = (1 - 0.01)/(1 + 0.01), the
    spectral radius that belongs to the numerical damping of 0.01 of the load case. Milliseconds per step on one
    thread, and whether both codes compute the same motion.

How the frame is built in Exudyn
    - ObjectBeamGeometricallyExact on NodeRigidBodyEP (Euler parameters), local x along the member, local y along
      global y. The Lie-group node NodeRigidBodyRotVecLG would be nearer to ours; the solver does not converge with it
      here (`--node LG` shows it).
    - The orientation of a node is that of the section, so a corner takes two nodes. A GenericJoint with the rotation
      of each node turned back in its marker (localHT) holds them together.
    - Dead forces: LoadForceVector. Follower moments: LoadTorqueVector with bodyFixed=True on a MarkerNodeRigid of the
      tip; local y of the arm is the y of the node. Time functions are symbolic, evaluated without Python. Exudyn's
      implicit solver leaves the derivative of the loads out of its Jacobian (computeLoadsJacobian = False): its
      default.

Settings of Exudyn (`--variants`)
    tuned    module without range checks and with AVX2, sparse LU that keeps its pattern, Jacobian once per step
    lazy     the same, Jacobian only when the convergence gets slow (Exudyn's default)
    full     the same, Jacobian in each iteration
    sparse   default module, sparse LU as it comes, full Newton, load functions in Python
    dense    default module, its default dense solver, full Newton, load functions in Python (slow: 0.5 s are timed)

Tolerance
    Ours stops when a correction is below 1e-10 of the size of the structure. Exudyn's default, a residual of 1e-10 or
    1e-8 of its first value, is below the rounding of the axial forces (EA = 3.5e8 N) and fails in the first step, so
    its corrections are tested too (residualMode = 1), by default to `--tolerance 1e-8`.

Timing
    Wall and processor time of the solver only in Exudyn (model building and assembly left out; each run in a process
    of its own), wall time of the steps as our example prints it, and processor time of our whole process, start-up
    included. On a machine that does other things compare the processor times. The least of `--repeat` runs, the codes
    in turn. The ratios are of processor times: to our romgen, the same scheme (generalised-alpha) with the files it
    writes, and to our example, which is Newmark and always runs 20 s at dt = 0.01 s.

Use
    pip install exudyn numpy
    cargo build --release -p rom-generator --example nonlinear
    cargo build --release
    python benches/peers/exudyn_fmb.py --nonlinear target/release/examples/nonlinear --romgen target/release/romgen
Without --nonlinear and --romgen only Exudyn is run. The exit code is 1 if the motions or the exact velocity of the
centre of mass do not agree within the bounds given below.
"""

import argparse
import importlib.metadata
import json
import os
import platform
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# One thread, whatever numpy is linked with; before numpy is loaded.
for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
MODEL = ROOT / "models" / "fmb.toml"
DAMPING = 0.01
SAMPLE = 0.5  # s between compared states

# Bounds of the check. Velocity of the centre of mass: that of a particle, up to the error of the scheme at the kink
# of the ramp, O(dt^2). P: relative to the distance it travels, 146 m in 20 s. The codes are 0.07 m apart with 60
# elements and 0.02 m with 120, whatever the step: the gap is that of two different elements and falls with the square
# of their length. The bound is 0.3 m, four times the gap of the coarser mesh.
BOUND_CM = 1e-4
BOUND_P = 2e-3

# module without range checks, sparse, pattern kept, Newton, symbolic loads
VARIANTS = {
    "tuned": dict(fast=True, sparse=True, reuse=True, newton="step", symbolic=True),
    "lazy": dict(fast=True, sparse=True, reuse=True, newton="modified", symbolic=True),
    "full": dict(fast=True, sparse=True, reuse=True, newton="full", symbolic=True),
    "sparse": dict(fast=False, sparse=True, reuse=False, newton="full", symbolic=False),
    "dense": dict(fast=False, sparse=False, reuse=False, newton="full", symbolic=False, longest=0.5),
}


def exact_cm_velocity(t):
    """y velocity of the centre of mass: only F/4 at the origin has a resultant. m/s."""
    return 25.0 * (0.5 * min(t, 10.0) ** 2 + 10.0 * max(t - 10.0, 0.0)) / 405.0


# --- Exudyn, in a process of its own --------------------------------------------------------------------------------


def exudyn_section(exu):
    b, h, rho, young, nu = 0.1, 0.05, 2700.0, 70e9, 0.3
    shear, area = young / (2 * (1 + nu)), b * h
    iy, iz = b * h**3 / 12, h * b**3 / 12
    gj = shear * 0.22887745119762 * b * h**3
    section = exu.BeamSection()
    section.stiffnessMatrix = np.diag(
        [young * area, 5 / 6 * shear * area, 5 / 6 * shear * area, gj, young * iy, young * iz]
    )
    section.massPerLength = rho * area
    section.inertia = rho * np.diag([iy + iz, iy, iz])
    return section


def exudyn_frame(exu, ex, mbs, elements, node):
    """Nodes of the main beam (left to right), of the right and left arm; elements as pairs of nodes with lengths."""
    section = exudyn_section(exu)
    pairs = []

    def member(start, end, n):
        start, end = np.array(start, float), np.array(end, float)
        length = np.linalg.norm(end - start)
        x, y = (end - start) / length, np.array([0.0, 1.0, 0.0])
        rotation = np.array([x, y, np.cross(x, y)]).T
        if node == "EP":
            kind, turned = ex.NodeRigidBodyEP, ex.RotationMatrix2EulerParameters(rotation)
        else:
            kind, turned = ex.NodeRigidBodyRotVecLG, ex.RotationMatrix2RotationVector(rotation)
        nodes = [
            mbs.AddNode(kind(referenceCoordinates=[*(start + (end - start) * i / n), *turned])) for i in range(n + 1)
        ]
        for i in range(n):
            mbs.AddObject(
                ex.ObjectBeamGeometricallyExact(nodeNumbers=nodes[i : i + 2], length=length / n, sectionData=section)
            )
            pairs.append((nodes[i], nodes[i + 1], length / n))
        return nodes, rotation

    beam, beam_rotation = member([-10, 0, 0], [10, 0, 0], elements * 2 // 3)
    right, right_rotation = member([10, 0, 0], [10, 0, 5], elements // 6)
    left, left_rotation = member([-10, 0, 0], [-10, 0, 5], elements // 6)

    def back(n, rotation):
        return mbs.AddMarker(ex.MarkerNodeRigid(nodeNumber=n, localHT=exu.HT(rotation=rotation.T)))

    for corner, arm, rotation in ((beam[-1], right[0], right_rotation), (beam[0], left[0], left_rotation)):
        mbs.AddObject(ex.GenericJoint(markerNumbers=[back(corner, beam_rotation), back(arm, rotation)]))
    return beam, right, left, pairs


def exudyn_loads(exu, ex, mbs, beam, right, left, symbolic):
    smaller = exu.symbolic.min if symbolic else min

    def grow(mbs, t, v):
        f = 100 * smaller(t, 10)
        return [f * v[0], f * v[1], f * v[2]]

    def load(node, vector, kind, **options):
        marker = mbs.AddMarker(ex.MarkerNodeRigid(nodeNumber=node))
        if not symbolic:
            options["loadVectorUserFunction"] = grow
        number = mbs.AddLoad(kind(markerNumber=marker, loadVector=vector, **options))
        if symbolic:
            function = ex.CreateSymbolicUserFunction(mbs, grow, "loadVectorUserFunction", number)
            mbs.SetLoadParameter(number, "loadVectorUserFunction", function)

    load(right[-1], [0, 0, 1], ex.LoadForceVector)
    load(left[-1], [0, 0, -1], ex.LoadForceVector)
    load(right[-1], [0, 2, 0], ex.LoadTorqueVector, bodyFixed=True)
    load(left[-1], [0, -2, 0], ex.LoadTorqueVector, bodyFixed=True)
    load(beam[-1], [0, 0.1, 0], ex.LoadForceVector)
    load(beam[0], [0, -0.1, 0], ex.LoadForceVector)
    load(beam[len(beam) // 2], [0, 0.25, 0], ex.LoadForceVector)


def exudyn_settings(exu, job, steps):
    settings = exu.SimulationSettings()
    settings.parallel.numberOfThreads = 1
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = SAMPLE
    if job["sparse"]:
        settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
        settings.linearSolver.reuseAnalyzedPattern = job["reuse"]
    integration = settings.timeIntegration
    integration.verboseMode = 0
    integration.endTime = steps * job["dt"]
    integration.numberOfSteps = steps
    integration.adaptiveStep = False
    integration.generalizedAlpha.spectralRadius = (1 - DAMPING) / (1 + DAMPING)
    newton = integration.newton
    newton.useModifiedNewton = job["newton"] != "full"
    newton.modifiedNewtonJacUpdatePerStep = job["newton"] == "step"
    newton.residualMode = 1
    newton.relativeTolerance = newton.absoluteTolerance = job["tolerance"]
    return settings


def exudyn_worker(job):
    """One run of Exudyn; the result goes to the file job["result"], for Exudyn prints to standard output."""
    sys.exudynFast = job["fast"]
    import exudyn as exu
    import exudyn.utilities as ex

    container = exu.SystemContainer()
    mbs = container.AddSystem()
    beam, right, left, pairs = exudyn_frame(exu, ex, mbs, job["elements"], job["node"])
    exudyn_loads(exu, ex, mbs, beam, right, left, job["symbolic"])
    output = exu.OutputVariableType
    tip, reference = right[-1], beam[len(beam) // 2]
    sensors = [
        mbs.AddSensor(
            ex.SensorNode(nodeNumber=n, outputVariableType=output.Position, storeInternal=True, writeToFile=False)
        )
        for n in (tip, reference)
    ]
    mbs.Assemble()
    steps = round(job["t_end"] / job["dt"])
    settings = exudyn_settings(exu, job, steps)
    solver = exu.MainSolverImplicitSecondOrder()
    if not solver.InitializeSolver(mbs, settings):
        raise SystemExit("Exudyn's solver could not be initialised")
    wall, processor = time.perf_counter(), time.process_time()
    done = solver.SolveSteps(mbs, settings)
    wall, processor = time.perf_counter() - wall, time.process_time() - processor
    counts, unknowns = solver.it, solver.GetODE2size() + solver.GetAEsize()
    reached = mbs.systemData.GetTime()
    solver.FinalizeSolver(mbs, settings)
    velocity = {n: np.array(mbs.GetNodeOutput(n, output.Velocity)) for pair in pairs for n in pair[:2]}
    length = sum(pair[2] for pair in pairs)
    cm = sum(pair[2] * (velocity[pair[0]] + velocity[pair[1]]) / 2 for pair in pairs) / length
    tracks = [np.array(mbs.GetSensorStoredData(s)) for s in sensors]
    result = {
        "done": bool(done) and reached > job["t_end"] - 0.5 * job["dt"],
        "reached": reached,
        "wall": 1e3 * wall / steps,
        "cpu": 1e3 * processor / steps,
        "iterations": counts.newtonStepsCount / steps,
        "jacobians": counts.newtonJacobiCount / steps,
        "unknowns": unknowns,
        "v_cm": cm.tolist(),
        "t": tracks[0][:, 0].tolist(),
        "P": tracks[0][:, 1:4].tolist(),
        "A": tracks[1][:, 1:4].tolist(),
    }
    Path(job["result"]).write_text(json.dumps(result))


def run_exudyn(variant, elements, options, dt=None):
    job = {k: v for k, v in VARIANTS[variant].items() if k != "longest"}
    t_end = min(options.t_end, VARIANTS[variant].get("longest", options.t_end))
    job |= dict(elements=elements, node=options.node, tolerance=options.tolerance, t_end=t_end, dt=dt or options.dt)
    with tempfile.TemporaryDirectory() as folder:
        job["result"] = str(Path(folder) / "result.json")
        # Exudyn writes an information file into its current folder.
        finished = subprocess.run(
            [sys.executable, str(Path(__file__).resolve()), "--worker", json.dumps(job)],
            cwd=folder,
            capture_output=True,
            text=True,
        )
        if not Path(job["result"]).exists():
            return {"done": False, "why": (finished.stdout + finished.stderr).strip().splitlines()[-3:]}
        return json.loads(Path(job["result"]).read_text())


# --- Ours -----------------------------------------------------------------------------------------------------------


def children_cpu():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run_example(elements, options):
    """The example `nonlinear`: always Newmark with the damping, dt and t_end of the load case."""
    before = children_cpu()
    text = subprocess.run(
        [options.nonlinear, str(MODEL), "lc1", "sigma=1", f"elements={elements}"],
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    cpu = children_cpu() - before
    steps = int(re.search(r"(\d+) steps", text)[1])
    iterations, factorisations = map(
        float, re.search(r"iterations per step ([\d.]+), factorisations ([\d.]+)", text).groups()
    )
    wall = float(re.search(r"([\d.]+) ms per step", text)[1])
    return {"wall": wall, "cpu": 1e3 * cpu / steps, "iterations": iterations, "jacobians": factorisations}


def run_romgen(elements, options, dt=None):
    """`romgen validate` with generalised-alpha: the motion. Its processor time holds start-up and the files written."""
    dt = dt or options.dt
    command = [options.romgen, "validate", str(MODEL), "--loads", "lc1", "--method", "nonlinear"]
    command += ["--set", "sigma=1", "--set", f"elements={elements}", "--integrator", "gen-alpha", "--quiet"]
    command += ["--numerical-damping", str(DAMPING), "--dt", str(dt), "--t-end", str(options.t_end), "--no-report"]
    with tempfile.TemporaryDirectory() as folder:
        before, wall = children_cpu(), time.perf_counter()
        subprocess.run([*command, "--out", folder], check=True)
        cpu, wall = children_cpu() - before, time.perf_counter() - wall
        data = np.load(Path(folder) / "results.npz")
        steps = len(data["t"]) - 1
        every = round(SAMPLE / dt)
        return {
            "wall": 1e3 * wall / steps,
            "cpu": 1e3 * cpu / steps,
            "v_cm": (data["p_G"][-1] / 405.0).tolist(),
            "t": data["t"][::every].tolist(),
            "P": data["P.R_G"][::every].tolist(),
            "A": data["A.R_G"][::every].tolist(),
        }


# --- Report ---------------------------------------------------------------------------------------------------------


def least(runs):
    """The run of least processor time, with the least wall time of all."""
    best = min(runs, key=lambda r: r["cpu"])
    return best | {"wall": min(r["wall"] for r in runs)}


def vector(v):
    return "(" + ", ".join(f"{x:9.4f}" for x in v) + ")"


def row(name, run, references=()):
    counts = f"{run['iterations']:10.2f} {run['jacobians']:9.2f}" if "iterations" in run else " " * 20
    ratio = " ".join(f"{run['cpu'] / r['cpu']:9.2f}" if r else f"{'-':>9}" for r in references)
    print(f"  {name:34} {run['cpu']:8.3f} {run['wall']:8.3f} {counts}   {ratio}")


def distance(one, other, point):
    n = min(len(one["t"]), len(other["t"]))
    assert np.allclose(one["t"][:n], other["t"][:n], atol=1e-6)
    return np.linalg.norm(np.array(one[point][:n]) - np.array(other[point][:n]), axis=1)


def compare_motion(peer, ours, label):
    """Distances between the two trajectories; true if within the bound."""
    gaps = {point: distance(peer, ours, point) for point in "PA"}
    t = np.array(peer["t"][: len(gaps["P"])])
    path = np.linalg.norm(np.diff(np.array(ours["P"]), axis=0), axis=1).sum()
    print(f"  distance between the codes, {label}: P travels {path:.1f} m")
    for end in sorted({5.0, 10.0, 15.0, float(t[-1])}):
        if end <= t[-1] + 1e-9:
            upto = t <= end + 1e-9
            print(f"    up to {end:5.1f} s   P {gaps['P'][upto].max():.2e} m   A {gaps['A'][upto].max():.2e} m")
    return gaps["P"].max() < BOUND_P * path


def states(name, run, t_end):
    exact = exact_cm_velocity(t_end)
    print(f"  {name:20} P {vector(run['P'][-1])}  A {vector(run['A'][-1])}  v_CM {vector(run['v_cm'])}")
    return abs(run["v_cm"][1] - exact) < BOUND_CM * exact and np.hypot(run["v_cm"][0], run["v_cm"][2]) < BOUND_CM


def compare(elements, options):
    print(f"\n{elements} elements, {round(options.t_end / options.dt)} steps of {options.dt} s")
    columns = "cpu ms  wall ms iterations jacobians   x romgen x example"
    print(f"  {'per step':34} {columns}")
    peers = {name: [] for name in options.variants}
    examples, romgens = [], []
    for turn in range(options.repeat):
        for name in options.variants:
            if turn > 0 and "longest" in VARIANTS[name]:
                continue  # far too slow for noise to matter
            peers[name].append(run_exudyn(name, elements, options))
        if options.nonlinear:
            examples.append(run_example(elements, options))
        if options.romgen:
            romgens.append(run_romgen(elements, options))
    ours = least(romgens) if romgens else None
    example = least(examples) if examples else None
    if example:
        row("ours, example, Newmark", example)
    if ours:
        row("ours, romgen with files, gen-alpha", ours)
    good, motion = True, None
    for name, runs in peers.items():
        failed = [r for r in runs if not r["done"]]
        if failed:
            print(f"  Exudyn {name}: stopped at {failed[0].get('reached', '?')} s {failed[0].get('why', '')}")
            good = False
            continue
        best = least(runs)
        row(f"Exudyn, {name}", best, (ours, example))
        if abs(best["t"][-1] - options.t_end) < 1e-9 and motion is None:
            motion = best
    if motion is None:
        return False
    print(f"  Exudyn solves for {motion['unknowns']} coordinates and multipliers, ours for {6 * (elements + 1)}")
    print(f"  at {options.t_end} s (exact: v_CM y = {exact_cm_velocity(options.t_end):.4f} m/s)")
    good &= states("Exudyn", motion, options.t_end)
    if ours:
        good &= states("ours", ours, options.t_end)
        good &= compare_motion(motion, ours, f"dt = {options.dt} s")
        if options.refine > 1:
            dt = options.dt / options.refine
            finer = run_exudyn(options.variants[0], elements, options, dt)
            ours_finer = run_romgen(elements, options, dt)
            states(f"Exudyn, dt = {dt:g}", finer, options.t_end)
            states(f"ours, dt = {dt:g}", ours_finer, options.t_end)
            good &= compare_motion(finer, ours_finer, f"dt = {dt:g} s")
            for name, one, other in (("Exudyn", motion, finer), ("ours", ours, ours_finer)):
                print(f"  {name}, dt = {options.dt} against {dt:g} s: P up to {distance(one, other, 'P').max():.2e} m")
    return bool(good)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worker", help=argparse.SUPPRESS)
    parser.add_argument("--elements", default="60,120", help="meshes, multiples of 6 (60,120)")
    parser.add_argument("--t-end", type=float, default=20.0, help="end of the runs, s (20)")
    parser.add_argument("--dt", type=float, default=0.01, help="time step, s (0.01)")
    parser.add_argument("--variants", default="tuned,lazy,full,sparse,dense", help="settings of Exudyn, see above")
    parser.add_argument("--tolerance", type=float, default=1e-8, help="of Exudyn's corrections (1e-8)")
    parser.add_argument("--node", choices=("EP", "LG"), default="EP", help="node type of Exudyn (EP)")
    parser.add_argument("--repeat", type=int, default=3, help="runs of which the least time counts (3)")
    parser.add_argument("--refine", type=int, default=1, help="compare the motion with dt divided by this too (1: no)")
    parser.add_argument("--nonlinear", help="our example `nonlinear`, for the time (runs 20 s at dt = 0.01 s, always)")
    parser.add_argument("--romgen", help="our `romgen`, for the motion")
    options = parser.parse_args()
    if options.worker:
        exudyn_worker(json.loads(options.worker))
        return 0
    options.variants = options.variants.split(",")
    for name in ("nonlinear", "romgen"):
        if getattr(options, name):
            setattr(options, name, str(Path(getattr(options, name)).resolve()))
    print(f"Exudyn {importlib.metadata.version('exudyn')}, numpy {np.__version__}, Python {platform.python_version()}")
    if options.romgen:
        print(subprocess.run([options.romgen, "--version"], capture_output=True, text=True).stdout.strip())
    print(f"one thread; load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    results = [compare(int(n), options) for n in options.elements.split(",")]
    print("\n" + ("both codes compute the same motion" if all(results) else "NOT ALL AGREES, see above"))
    return 0 if all(results) else 1


if __name__ == "__main__":
    sys.exit(main())
