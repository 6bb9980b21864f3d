# What tools/benchmark and tools/robustness share: the built programs, and tables.
# SPDX-License-Identifier: BSD-3-Clause
import json
import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DASH = "–"  # there is no such figure


class Programs:
    """The built programs; each call shows the command and raises CalledProcessError where it fails."""

    def __init__(self, folder, commands_to=None):
        self.folder = folder
        self.commands_to = commands_to  # stdout by default

    def run(self, name, *arguments, capture=False):
        command = [str(self.folder / name), *map(str, arguments)]
        print("$ " + " ".join(command), file=self.commands_to, flush=True)
        return subprocess.run(command, check=True, text=True, stdout=subprocess.PIPE if capture else None).stdout

    def json(self, name, *arguments):
        return json.loads(self.run(name, *arguments, "--json", capture=True))


def build(*targets):
    """Builds programs with the release preset; returns their folder."""
    subprocess.run([ROOT / "tools" / "setup"], check=True)
    subprocess.run(["cmake", "--preset", "release"], cwd=ROOT, check=True)
    subprocess.run(["cmake", "--build", "--preset", "release", "--parallel", str(os.cpu_count()), "--target", *targets],
                   cwd=ROOT, check=True)
    return ROOT / "build" / "release" / "bin"


def table(header, rows):
    """A table in Markdown."""
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"
