#!/usr/bin/env python3
"""Runs what pages show, as a reader would: every page is one shell session, all in the same copy of the checkout.

    .ci/pages.py [PAGE.md ..]      README.md and those of the hosts where none is named

Blocks of `sh` are commands, in their order; blocks that name a file, such as ```c loop.c, are put into it; lines of blocks of `text` have to
be among the lines printed. Nothing is skipped but `.ci/run`, which is what runs this. Port 5005 of the pages is a free one.
README.md installs the programs and comes first; for other pages alone they have to be on the PATH.
"""

import os
import pathlib
import re
import shlex
import socket
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGES = ["README.md", "docs/c-api.md", "docs/udp.md", "docs/codegen.md"]


def blocks(text):
    """Language, file (empty where none is named) and contents of every fenced block."""
    return re.findall(r"^```(\w+) ?(\S*)\n(.*?)^```$", text, re.M | re.S)


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        return str(one.getsockname()[1])


def session(page, folder, environment):
    """Runs a page in a folder; what it printed."""
    text = re.sub(r"\b5005\b", free_port(), (ROOT / page).read_text())
    script = ["set -euo pipefail", "trap 'kill $(jobs -p) 2>/dev/null || true' EXIT"]
    for language, name, contents in blocks(text):
        if name:
            (folder / name).write_text(contents)
        elif language == "sh":
            commands = contents.replace("\\\n", " ").splitlines()
            for command in filter(lambda line: line.strip() and line.strip() != ".ci/run", commands):
                script += [f"echo {shlex.quote('$ ' + command)}", command]
    run = subprocess.Popen(
        ["bash", "-c", "\n".join(script)], cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    printed = []
    for line in run.stdout:
        print(line, end="", flush=True)
        printed.append(line.split())
    if run.wait() != 0:
        sys.exit(f"{page}: exit code {run.returncode}")
    for language, name, contents in blocks(text):
        for line in contents.splitlines() if language == "text" and not name else []:
            if line.split() not in printed:
                sys.exit(f"{page}: this line is not among those printed: {line}")


def copy_of_the_checkout(folder):
    """What a fresh clone would hold, with the changes not yet committed."""
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    files = subprocess.run(listed, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout
    present = b"\0".join(f for f in files.split(b"\0") if f and (ROOT / os.fsdecode(f)).exists())
    archive = subprocess.run(["tar", "-c", "--null", "-T", "-"], cwd=ROOT, input=present, check=True, stdout=subprocess.PIPE)
    subprocess.run(["tar", "-x"], cwd=folder, input=archive.stdout, check=True)


def main(pages):
    with tempfile.TemporaryDirectory() as folder:
        clone, bin_root = pathlib.Path(folder, "clone"), pathlib.Path(folder, "root")
        clone.mkdir()
        copy_of_the_checkout(clone)
        environment = dict(os.environ)
        environment.pop("DISPLAY", None)
        environment.pop("WAYLAND_DISPLAY", None)
        environment |= {
            "CARGO_TARGET_DIR": str(ROOT / "target"),
            "CARGO_INSTALL_ROOT": str(bin_root),
            "PATH": f"{bin_root / 'bin'}:{environment['PATH']}",
        }
        for page in pages:
            print(f"-- {page}", flush=True)
            session(page, clone, environment)


if __name__ == "__main__":
    main(sys.argv[1:] or PAGES)
