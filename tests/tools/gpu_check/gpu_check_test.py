#!/usr/bin/env python3
# Arguments, --prepare, steps with their limits, the report and the reading of PTX of tools/gpu_check; it builds nothing.
# SPDX-License-Identifier: BSD-3-Clause
import json
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

TOOLS = Path(__file__).resolve().parents[3] / "tools"
STEPS = """
program=test build="$1"
source "$2"
well() { members='"count": 3'; }
bad() { echo 'a line'; echo 'x.cpp:3: error: no "good"	tab'; echo another; return 3; }
slow() { limited sleep 30; }
nothing() { why="no tool"; return 77; }
loud() { echo on stdout; }
total_s=48  # limits are a tenth of those for 480 s
run_step first 100 well
run_step second 100 bad
run_step third 30 slow
run_step fourth 100 nothing
run_step fifth 100 loud
skip_step sixth 'not "here"'
"""


class GpuCheckTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def run_tool(self, *arguments, **environment):
        return subprocess.run([TOOLS / "gpu_check", *map(str, arguments)], capture_output=True, text=True, check=False,
                              env=os.environ | environment, timeout=120)

    def steps(self, more):
        run = subprocess.run(["bash", "-c", STEPS + more, "bash", self.folder, TOOLS / "steps.sh"], capture_output=True,
                             text=True, check=True, timeout=60)
        return run

    def test_wrong_use_is_one_line_and_code_2(self):
        for wrong in (["--nope"], ["folder"], ["--minutes"], ["--minutes", "0"], ["--minutes", "x"], ["--deps"]):
            run = self.run_tool(*wrong)
            self.assertEqual((run.returncode, run.stdout, len(run.stderr.splitlines())), (2, "", 1), wrong)
        self.assertIn("--allow-no-gpu", self.run_tool("--help").stdout)

    def test_a_report_of_steps_that_went_well_badly_and_not_at_all(self):
        run = self.steps('print_report false "failed: ${steps_failed[*]}" \'"gpu_checked": false\'')
        report = json.loads(run.stdout)  # nothing but the report is on stdout
        self.assertEqual((report["ok"], report["gpu_checked"], report["why"]), (False, False, "failed: second third"))
        steps = report["steps"]
        self.assertEqual({name: step["result"] for name, step in steps.items()},
                         {"first": "ok", "second": "failed", "third": "failed", "fourth": "skipped", "fifth": "ok", "sixth": "skipped"})
        self.assertEqual(steps["first"]["count"], 3)
        self.assertEqual(steps["second"]["why"], 'x.cpp:3: error: no "good"tab')
        self.assertTrue(steps["third"]["why"].startswith("ran past 3 s"))
        self.assertLess(steps["third"]["seconds"], 8)
        self.assertEqual((steps["fourth"]["why"], steps["sixth"]["why"]), ("no tool", 'not "here"'))
        self.assertEqual((self.folder / "fifth.log").read_text(), "on stdout\n")

    def test_no_time_left_is_a_failure(self):
        report = json.loads(self.steps('total_s=$((SECONDS - started_s + 1)); run_step late 480 well; print_report false x ""').stdout)
        self.assertEqual(report["steps"]["late"]["result"], "failed")
        self.assertIn("no time was left", report["steps"]["late"]["why"])

    def test_prepare_copies_what_is_needed(self):
        eigen, googletest = self.folder / "eigen3", self.folder / "googletest"
        for module in ("Core", "LU", "Cholesky", "QR", "SVD", "Geometry", "Eigenvalues", "Jacobi", "Householder", "Sparse"):
            (eigen / "Eigen" / "src" / module).mkdir(parents=True)
            (eigen / "Eigen" / module).touch()
        (eigen / "Eigen" / "Dense").touch()
        for part in ("misc", "plugins"):
            (eigen / "Eigen" / "src" / part).mkdir()
        for part in ("googletest", "googlemock"):
            for name in ("cmake", "include", "src", "test"):
                (googletest / part / name).mkdir(parents=True)
            (googletest / part / "CMakeLists.txt").touch()
        (googletest / "CMakeLists.txt").touch()
        deps = self.folder / "deps"
        for _ in range(2):  # the second call replaces the first one's
            run = self.run_tool("--deps", deps, "--prepare", KT_EIGEN_FROM=str(eigen), KT_GOOGLETEST_FROM=str(googletest))
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertRegex(run.stdout, r"\d+\.\d MiB")
        self.assertTrue((deps / "eigen/Eigen/Core").exists() and (deps / "eigen/Eigen/src/misc").is_dir())
        self.assertTrue((deps / "googletest/googlemock/CMakeLists.txt").exists())
        self.assertFalse((deps / "eigen/Eigen/Sparse").exists() or (deps / "googletest/googletest/test").exists())
        shutil.rmtree(eigen)
        run = self.run_tool("--deps", deps, "--prepare", KT_EIGEN_FROM=str(eigen))
        self.assertEqual(run.returncode, 1)
        self.assertIn("install libeigen3-dev", run.stderr)

    def count(self, text, name="a.ptx"):
        (self.folder / name).write_text(text)
        run = subprocess.run(["awk", "-f", TOOLS / "gpu_check.awk", *sorted(self.folder.glob("a.*"))], capture_output=True,
                             text=True, check=True)
        return {line.split()[0]: [other.split(" ", 1)[1] for other in run.stdout.splitlines() if other.startswith(line.split()[0])]
                for line in run.stdout.splitlines()}

    def test_finds_what_may_be_fused(self):
        good = ".visible .entry one(\n\tmul.rn.f32 \t%f1, %f2, %f3;\n\tadd.rn.f32 %f1, %f1, %f4;\n\tdiv.rn.f32 %f1, %f1, %f2;\n" \
               "\tmad.lo.s32 %r1, %r2, %r3, %r4;\n\tadd.s64 %rd1, %rd2, %rd3;\n"
        found = self.count(good)
        self.assertNotIn("fused", found)
        self.assertEqual(found["counts"], ['"kernels": 1, "fma": 0, "unrounded": 0, "rounded": 2, "divisions_and_roots": 1'])
        for bad in ("\tfma.rn.f32 %f1, %f2, %f3, %f4;\n", "\t@%p1 fma.rn.f64 %fd1, %fd2, %fd3, %fd4;\n", "\tmul.f32 %f1, %f2, %f3;\n",
                    "\tadd.ftz.f32 %f1, %f2, %f3;\n"):
            self.assertEqual(self.count(good + ".visible .entry two(\n" + bad)["fused"], ["1 products or sums may be fused in two"], bad)

    def test_tells_multiply_adds_of_divisions_from_others(self):
        self.count(".visible .entry one(\n\tdiv.rn.f32 %f1, %f1, %f2;\n.visible .entry two(\n")
        sass = "\t\tFunction : one\n  /*0010*/  FFMA R1, R2, R3, R4 ;\n  /*0020*/  FFMA.FTZ R1, R2, R3, R4 ;\n" \
               "\t\tFunction : two\n  /*0010*/  DFMA R2, R4, R6, R8 ;\n  /*0020*/  IMAD R1, R2, R3, R4 ;\n"
        found = json.loads("{" + self.count(sass, "a.sass")["sass"][0] + "}")
        self.assertEqual((found["kernels"], found["fma"]), (2, 3))
        self.assertEqual(found["fma_without_division_or_root"], [{"fma": 1, "kernel": "two"}])
        self.assertIn({"fma": 2, "divisions_and_roots": 1, "kernel": "one"}, found["by_kernel"])


if __name__ == "__main__":
    unittest.main()
