# Runs the built programs for the end-to-end tests, and finds the missions that make_missions.py made.
# SPDX-License-Identifier: BSD-3-Clause
import json
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(os.environ.get("KT_BIN", ROOT / "build" / "release" / "bin"))
WORK = Path(os.environ.get("KT_E2E_WORK", ROOT / "build" / "e2e"))
DATA = Path(os.environ.get("KT_DATA", ROOT.parent / "shared" / "data"))

# Name of a test mission: arguments of kintsugi-synth.
MISSIONS = {
    "small": ["room", "--frames", "24", "--downscale", "2", "--no-surface"],
    "wheels": ["room", "--frames", "24", "--downscale", "2", "--no-surface", "--odometry"],
    "room": ["room", "--frames", "90"],
    "moving": ["fast", "--frames", "30", "--downscale", "2", "--no-surface"],
    "metered": ["room", "--frames", "125", "--downscale", "2", "--auto-exposure"],
    "turning": ["room", "--frames", "110", "--downscale", "2", "--no-surface"],
    "elsewhere": ["apartment", "--frames", "150", "--downscale", "2", "--no-surface"],
}
# A volume so small that several slices leave it during the mission "moving".
SMALL_VOLUME = ["volume.shift_distance_m=0.1", "volume.resolution=128", "volume.voxel_size_m=0.02"]


def command(program, *arguments):
    return [str(BIN / f"kintsugi-{program}"), *map(str, arguments)]


def run(program, *arguments, **options):
    """Runs kintsugi-<program> to its end; stdout and stderr are captured together as text."""
    return subprocess.run(command(program, *arguments), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          errors="replace", timeout=600, check=False, **options)


class ProgramTest(unittest.TestCase):
    """A test with a folder of its own, self.folder, gone afterwards."""

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="kintsugi-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def run_well(self, program, *arguments, **options):
        """Runs a program that must succeed; returns what it printed."""
        result = run(program, *arguments, **options)
        self.assertEqual(result.returncode, 0, f"{result.args}\n{result.stdout}")
        return result.stdout

    def run_badly(self, program, *arguments, naming=(), **options):
        """Runs a program that must end with exit code 1 and one clear line, which holds each of `naming`."""
        result = run(program, *arguments, **options)
        self.assertEqual(result.returncode, 1, f"{result.args}\n{result.stdout}")
        line = result.stdout.strip().splitlines()[-1]
        self.assertTrue(line.startswith(f"kintsugi-{program}: "), result.stdout)
        for word in naming:
            self.assertIn(str(word), line)
        return line

    def collect(self, source, log=None, settings=(), **flags):
        """Collects `source` with `settings` as --set takes them, and returns (log, report)."""
        log = log or self.folder / "mission.lcm"
        report = self.folder / "report.json"
        options = [word for name, value in flags.items() for word in (f"--{name.replace('_', '-')}", value)]
        options += [word for setting in settings for word in ("--set", setting)]
        self.run_well("collect", "--input", source, "--log", log, "--report", report, *options)
        return log, json.loads(report.read_text())

    def map(self, log):
        """Maps `log` and returns the output folder."""
        self.run_well("map", log, "--output", self.folder / "map")
        return self.folder / "map"

    def evaluate(self, what, **files):
        options = [word for name, path in files.items() for word in (f"--{name.replace('_', '-')}", path)]
        return json.loads(self.run_well("eval", what, *options, "--json"))

    def copy_of(self, mission):
        """A copy of a test mission that the test may break."""
        target = self.folder / mission
        shutil.copytree(WORK / mission, target)
        return target
