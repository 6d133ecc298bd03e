#!/usr/bin/env python3
"""Runs every command the README shows, in order, as one shell session in a copy of the checkout.

Commands are the lines of blocks fenced with ```sh. Nothing is skipped but `.ci/run`, which is what runs this.
"""

import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent


def commands():
    text = (ROOT / "README.md").read_text()
    blocks = re.findall(r"^```sh\n(.*?)^```$", text, re.M | re.S)
    lines = "".join(blocks).replace("\\\n", " ").splitlines()
    return [line for line in lines if line.strip() and line.strip() != ".ci/run"]


def main():
    script = ["set -euo pipefail"]
    for command in commands():
        script += [f"echo {shlex.quote('$ ' + command)}", command]
    with tempfile.TemporaryDirectory() as folder:
        clone, bin_root = pathlib.Path(folder, "clone"), pathlib.Path(folder, "root")
        clone.mkdir()
        # What a fresh clone would hold, with the changes not yet committed.
        files = subprocess.run(
            ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT, check=True, stdout=subprocess.PIPE,
        ).stdout
        present = b"\0".join(f for f in files.split(b"\0") if f and (ROOT / os.fsdecode(f)).exists())
        archive = subprocess.run(["tar", "-c", "--null", "-T", "-"], cwd=ROOT, input=present, check=True, stdout=subprocess.PIPE)
        subprocess.run(["tar", "-x"], cwd=clone, input=archive.stdout, check=True)
        environment = dict(os.environ)
        environment.pop("DISPLAY", None)
        environment.pop("WAYLAND_DISPLAY", None)
        environment |= {
            "CARGO_TARGET_DIR": str(ROOT / "target"),
            "CARGO_INSTALL_ROOT": str(bin_root),
            "PATH": f"{bin_root / 'bin'}:{environment['PATH']}",
        }
        run = subprocess.run(["bash", "-c", "\n".join(script)], cwd=clone, env=environment)
    sys.exit(run.returncode)


if __name__ == "__main__":
    main()
