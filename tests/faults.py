#!/usr/bin/env python3
"""Faults that a disk and an operator make: no half-written file is ever taken for a whole one.

    tests/faults.py PROGRAMS KILLS

PROGRAMS is the folder of romgen and romrun. Each is killed (SIGKILL) KILLS times at moments spread over its running time, has its
disk filled at sizes spread over what it writes, and has its folders and files taken away while it runs.
"""

import json
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAMS, KILLS = pathlib.Path(sys.argv[1]).resolve(), int(sys.argv[2])
ROMGEN, ROMRUN = PROGRAMS / "romgen", PROGRAMS / "romrun"
RANDOM = random.Random(1)


def run(*command, **options):
    return subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300, **options)


def sound_model(path):
    """The tool itself takes the file, and so does a second reader of its checksums."""
    done = run(ROMGEN, "info", path, "--quiet")
    assert done.returncode == 0, f"{path}: {done.stderr}"


def sound_results(folder):
    """Whatever file is there is whole; where there is a summary, so are all the files it names."""
    for path in folder.rglob("*"):
        if path.name.startswith(".") or path.is_dir():
            continue
        if path.suffix == ".npz":
            assert zipfile.ZipFile(path).testzip() is None, path
        elif path.suffix == ".json":
            json.loads(path.read_text())
        elif path.suffix == ".html":
            assert path.read_text().rstrip().endswith("</html>"), path
        elif path.suffix == ".csv":
            lines = path.read_text().splitlines(keepends=True)
            assert lines[-1].endswith("\n") and len({line.count(",") for line in lines}) == 1, path
        elif path.suffix in (".vtu", ".pvd"):
            assert path.read_text().rstrip().endswith("</VTKFile>"), path
    for summary in folder.rglob("summary.json"):
        told = json.loads(summary.read_text())
        for file in told["files"].values():
            assert pathlib.Path(file).exists(), f"{summary} names {file}"


def killed(command, folder, check):
    """Kills the command KILLS times; between the kills the folder stays as it is, as it would for a user."""
    start = time.monotonic()
    assert run(*command).returncode == 0
    whole = time.monotonic() - start
    struck = 0
    for _ in range(KILLS):
        process = subprocess.Popen([str(c) for c in command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(RANDOM.uniform(0, 1.05 * whole))
        process.kill()
        struck += process.wait() == -signal.SIGKILL
        check()
        if RANDOM.random() < 0.3:
            for path in folder.iterdir():
                shutil.rmtree(path) if path.is_dir() else path.unlink()
    return struck


def whole_lines(table):
    """Cases told by whole lines of the table of a sweep; the last may be cut."""
    if not table.exists():
        return set()
    lines = table.read_text().splitlines(keepends=True)[1:]
    return {line.split(",")[0] for line in lines if line.endswith("\n")}


def killed_sweeps(command, folder):
    """Kills a sweep again and again until it is through: no case that was told is ever lost, and the end is that of one never stopped."""
    out = folder / "sweep"
    command = [*command, "--out", out]
    start = time.monotonic()
    assert run(*command).returncode == 0
    took = time.monotonic() - start
    expected = {name: (out / name).read_bytes() for name in ("cases.csv", "cases.npz")}
    struck, rounds = 0, 0
    while struck < KILLS:
        shutil.rmtree(out)
        told, through, rounds = set(), False, rounds + 1
        while not through:
            process = subprocess.Popen([str(c) for c in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            try:
                words = process.communicate(timeout=RANDOM.uniform(0.1, 0.6) * took)[1]
                assert process.returncode == 0, words
                through = True
            except subprocess.TimeoutExpired:
                process.kill()
                process.communicate()
                struck += 1
            now = whole_lines(out / "cases.csv")
            assert told <= now, f"cases {sorted(told - now)} were told and are lost"
            told = now
        for name, content in expected.items():
            assert (out / name).read_bytes() == content, f"{name} of a sweep that was killed differs from one that was not"
    return struck, rounds


def disk_full(command, check, sizes):
    """Files cannot grow beyond `size` bytes: the error names the file, nothing is half-written, and there is no panic."""
    refused = 0
    for size in sizes:
        def limit(size=size):
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        done = run(*command, preexec_fn=limit)
        check()
        assert "panicked" not in done.stderr, done.stderr
        if done.returncode:
            assert done.returncode == 1 and done.stderr.strip(), (size, done)
            refused += 1
    return refused


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        models, results = folder / "models", folder / "results"
        models.mkdir()
        results.mkdir()
        model, kept = models / "a.rom", folder / "kept.rom"
        build = [ROMGEN, "build", ROOT / "models/fmb.toml", "-o", model, "--report", models / "a.html", "--quiet"]
        assert run(ROMGEN, "build", ROOT / "models/fmb.toml", "-o", kept, "--quiet").returncode == 0
        march = [ROMRUN, kept, "--loads", "lc1,lc2", "--vtk=20", "--out", results, "--quiet"]

        def models_are_sound():
            if model.exists():
                sound_model(model)

        print(f"killed {killed(build, models, models_are_sound)} builds of {KILLS}: every model file there was is whole")
        print(f"killed {killed(march, results, lambda: sound_results(results))} runs of {KILLS}: every file there was is whole")

        sweep = [ROMRUN, kept, "--loads", "lc1,lc2", "--sweep", "scale=0.8..1.2:40", "--t-end", "2", "--quiet"]
        struck, rounds = killed_sweeps(sweep, results)
        print(f"killed {struck} sweeps, {rounds} of them brought to the end: no case that was told is lost, and the tables are the same")

        sizes = [0, 1, 100, 4096, 20_000, 60_000, 200_000, 500_000, 1_000_000]
        for path in (models, results):
            shutil.rmtree(path)
            path.mkdir()
        refused = disk_full(build, models_are_sound, sizes)
        refused += disk_full(march, lambda: sound_results(results), sizes)
        assert refused > len(sizes), "the disk was never full"
        print(f"disk full {refused} times: told, nothing half-written")

        # The model is taken away, and another put in its place, once the run has read it.
        moved = folder / "moved.rom"
        shutil.copy(kept, moved)
        long = [ROMRUN, moved, "--loads", "lc2", "--t-end", "3000", "--every", "1000", "--out", results / "moved", "--quiet"]
        process = subprocess.Popen([str(c) for c in long], stderr=subprocess.PIPE, text=True)
        time.sleep(0.5)
        moved.write_bytes(b"something else")
        assert process.wait(timeout=300) == 0, process.stderr.read()
        sound_results(results)
        done = run(*long)
        assert done.returncode == 2 and "not a .rom model file" in " ".join(done.stderr.split()), done.stderr

        # The folder for the results is taken away under a run: it is made again, or the failure is told.
        away = results / "away"
        away.mkdir()
        process = subprocess.Popen([str(c) for c in [ROMRUN, kept, *long[2:-2], away, "--quiet"]], stderr=subprocess.PIPE, text=True)
        time.sleep(0.5)
        shutil.rmtree(away)
        code, words = process.wait(timeout=300), process.stderr.read()
        assert code in (0, 1) and "panicked" not in words, words
        sound_results(results)

        # A folder that may not be written to: told before the run where that can be known. The superuser may write everywhere.
        if os.geteuid() != 0:
            results.chmod(0o500)
            done = run(*march)
            results.chmod(0o700)
            assert done.returncode == 1 and "results" in done.stderr, done.stderr
        print("files and folders taken away: told, or not missed")


main()
