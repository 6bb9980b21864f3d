#!/usr/bin/env python3
# The tools around a mission: wrong use, kintsugi-bench, plots, and tools/benchmark on a tiny recording.
# SPDX-License-Identifier: BSD-3-Clause
import json
import os
import shutil
import subprocess
import sys
import unittest

from programs import BIN, ROOT, WORK, ProgramTest, run

PROGRAMS = {"collect": ["--threads", "-3"], "map": [], "log": ["convert", "a"], "eval": ["trajectory", "--delta", "x"],
            "synth": ["--downscale", "9"], "render": ["--view", "behind"], "bench": ["--frames", "many"],
            "graph": ["optimise", "no.g2o"]}


class ToolsTest(ProgramTest):
    def test_wrong_use_is_one_line_and_code_1(self):
        for program, arguments in PROGRAMS.items():
            for wrong in (arguments, ["--no-such-option"]):
                with self.subTest(program=program, arguments=wrong):
                    self.run_badly(program, *wrong)
                    self.assertEqual(len(run(program, *wrong).stdout.splitlines()), 1)

    def test_help(self):
        for program in PROGRAMS:
            with self.subTest(program=program):
                self.assertIn("--help", self.run_well(program, "--help"))

    def test_bench_prints_every_stage(self):
        report = json.loads(self.run_well("bench", "--input", f"tum:{WORK / 'small'}", "-n", 3))
        self.assertEqual(report["frames_good"], 13)  # with the ten before the clock starts
        for stage in ("frame", "preprocess", "track", "integrate", "raycast"):
            self.assertEqual(report["stages"][stage]["count"], 3, stage)
            self.assertGreater(report["stages"][stage]["p50_ms"], 0, stage)

    @unittest.skipUnless(shutil.which("gnuplot"), "no gnuplot")
    def test_plots_and_a_trajectory_shorter_than_the_span(self):
        log, _ = self.collect(f"tum:{WORK / 'small'}")
        picture = self.folder / "plot.png"
        truth = WORK / "small" / "groundtruth.txt"
        report = self.evaluate("trajectory", estimate=self.map(log) / "trajectory.txt", groundtruth=truth, plot=picture)
        self.assertEqual(picture.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        self.assertLess(report["ate"]["rmse_m"], 0.01)
        self.assertIsNone(report["rpe"])  # 24 frames are less than a second

    def benchmark(self, *arguments):
        return subprocess.run([sys.executable, ROOT / "tools" / "benchmark", "--work", self.folder, *arguments],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)

    def test_benchmark_leaves_no_figure_out(self):
        tiny, page = self.folder / "tiny", self.folder / "page.md"
        tiny.mkdir()
        for file in (WORK / "room").iterdir():
            os.symlink(file, tiny / file.name)
        lines = (WORK / "room" / "depth.txt").read_text().splitlines(keepends=True)
        (tiny / "depth.txt").unlink()
        (tiny / "depth.txt").write_text("".join(lines[:42]))  # two comments and 40 frames
        result = self.benchmark(tiny, "--bin", os.path.relpath(BIN), "--output", page)
        self.assertEqual(result.returncode, 0, result.stdout)
        text = page.read_text()
        self.assertEqual(text.count("| tiny |"), 3, text)
        self.assertEqual(text.count("–"), 1, "so short a mission has no closures, of which none can be true")
        self.assertIn("| tiny | 40 | 100.0 |", text)

    def test_benchmark_says_what_failed(self):
        result = self.benchmark("--bin", BIN, self.copy_without_images())
        self.assertEqual(result.returncode, 1)
        self.assertIn("broken failed", result.stdout.splitlines()[-1])
        self.assertFalse((self.folder / "benchmarks.md").exists())

    def copy_without_images(self):
        broken = self.folder / "broken"
        broken.mkdir()
        for name in ("depth.txt", "rgb.txt", "groundtruth.txt", "calibration.yaml"):
            shutil.copy(WORK / "small" / name, broken / name)
        return broken


if __name__ == "__main__":
    unittest.main()
