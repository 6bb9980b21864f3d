#!/usr/bin/env python3
# Figures and promises of tools/benchmark, from made-up reports; the e2e tests run it with the real programs.
# SPDX-License-Identifier: BSD-3-Clause
import copy
import json
import subprocess
import sys
import tempfile
import unittest
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path

TOOL = Path(__file__).resolve().parents[3] / "tools" / "benchmark"
sys.dont_write_bytecode = True
sys.path.insert(0, str(TOOL.parent))
benchmark = module_from_spec(spec_from_loader("benchmark", SourceFileLoader("benchmark", str(TOOL))))
sys.modules["benchmark"] = benchmark
benchmark.__loader__.exec_module(benchmark)

TIMES = {"p50_ms": 30.0, "p95_ms": 70.0, "max_ms": 90.0, "count": 600}
GOOD = {
    "collect": {"frames": 601, "tracked_share": 1.0, "process": TIMES, "fallback": TIMES, "stages": {"track": TIMES}, "peak_memory_mb": 300.4},
    "trajectory": {"ate": {"rmse_m": 0.004}, "rpe": {"translation": {"rmse_m": 0.002}, "rotation": {"rmse_deg": 0.1}},
                   "consistency": {"pose": {"mean": 1.234}},
                   "loops": {"accepted": 13, "precision": 1.0, "events": {"count": 2, "recalled": 2}}},
    "map": {"ate": {"rmse_m": 0.003}},
    "surface": {"accuracy": {"mean_m": 0.002}, "completeness": 0.97, "f_score": 0.98},
}

RUN = {"volume_resolution": 512, "voxel_size_m": 0.005, "width": 640, "height": 480, "frames": 20, "slices": 3,
       "stages": {stage: {"p50_ms": 10.04 * i} for i, stage in enumerate(("frame", "preprocess", "track", "integrate", "raycast"), 1)},
       "traffic": {stage: {"bytes": 21_700_000, "gb_per_s": 0.627, "share_of_bandwidth": 0.0321} for stage in ("integrate", "raycast")}}
KERNELS = {
    "device": "cpu", "threads": 2, "bandwidth": {"bytes_per_array": 2**28, "gb_per_s": 19.53}, "runs": [RUN],
    "reductions": {"residuals": 307200, "fixed_order_ms": 1.7779, "unordered_ms": 8.2147, "fixed_to_unordered": 0.216},
    "growth": {key: dict.fromkeys(RUN["stages"], 0.639) for key in ("with_pixels", "with_voxels")},
    "mission": RUN | {"frames": 2000, "first_tenth_p50_ms": 20.0, "last_tenth_p50_ms": 21.0, "last_to_first": 1.05},
}

PROMISED = list(dict.fromkeys(promise[0] for promise in benchmark.PROMISES))


def sequence(name, **changes):
    return benchmark.Sequence(name, "tum:x", "x", results=copy.deepcopy(GOOD) | changes)


class BenchmarkTest(unittest.TestCase):
    def verdicts(self, sequences, cores=2):
        return {tuple(row[:3]): row[4] for row in benchmark.check_promises(sequences, cores)}

    def test_promises_kept(self):
        verdicts = self.verdicts([sequence(name) for name in [*PROMISED, "other"]])
        self.assertEqual(len(verdicts), len(benchmark.PROMISES))
        self.assertEqual(set(verdicts.values()), {"kept"})

    def test_each_promise_can_be_broken(self):
        bad = {"trajectory": {"ate": {"rmse_m": 0.0501}, "rpe": None, "loops": {"precision": 0.98}},
               "map": {"ate": {"rmse_m": 0.027}},
               "surface": {"accuracy": {"mean_m": 0.009}, "completeness": 0.94, "f_score": 0.89},
               "collect": GOOD["collect"] | {"tracked_share": 0.999, "process": TIMES | {"p50_ms": 81}}}
        broken = set()
        for nees in (0.32, 3.1):  # too low and too high at once is not possible
            bad["trajectory"]["consistency"] = {"pose": {"mean": nees}}
            verdicts = self.verdicts([sequence(name, **bad) for name in PROMISED])
            broken |= {promise for promise, verdict in verdicts.items() if verdict == "**broken**"}
        self.assertEqual(len(broken), len(benchmark.PROMISES))

    def test_a_promised_figure_that_is_missing_breaks_the_promise(self):
        verdicts = self.verdicts([sequence("room", surface=None)])
        self.assertEqual(verdicts["room", "accuracy mm", "≤ 8"], "**broken**")

    def test_speed_is_promised_on_two_cores(self):
        self.assertNotIn(("room", "median frame ms", "≤ 33"), self.verdicts([sequence("room")], cores=1))

    def test_a_renamed_key_is_an_error_but_null_is_a_dash(self):
        renamed = copy.deepcopy(GOOD)
        renamed["trajectory"]["ate"] = {"root_mean_square_m": 0.004}
        with self.assertRaisesRegex(LookupError, "trajectory.ate.rmse_m"):
            benchmark.figures(renamed)
        short = copy.deepcopy(GOOD)
        short["trajectory"]["rpe"] = None
        short["trajectory"]["consistency"] = None
        self.assertEqual(benchmark.figures(short)["trajectory"]["RPE mm"], benchmark.DASH)
        self.assertEqual(benchmark.figures(short)["trajectory"]["NEES"], benchmark.DASH)
        self.assertEqual(benchmark.figures(short)["trajectory"]["ATE mm"], "4.0")

    def test_the_page(self):
        page = benchmark.document([sequence("room"), sequence("a", surface=None, trajectory=None)],
                                  benchmark.check_promises([sequence("room")], 2), "1.2", ["--threads", "2"])
        self.assertIn("| room | completeness % | ≥ 95 | 97.0 | kept |", page)
        self.assertIn("| room | NEES | ≥ 0.333 | 1.23 | kept |", page)
        self.assertIn("| a | 601 | 100.0 | – | – | – | – |", page)
        self.assertIn("| sequence | p50 | p95 | max | fallbacks | fallback p50 | fallback p95 | track | peak MiB |", page)
        self.assertIn("| room | 30.0 | 70.0 | 90.0 | 600 | 30.0 | 70.0 | 30.0 | 300 |", page)

    def test_the_page_of_a_recording_without_promises_and_surface(self):
        page = benchmark.document([sequence("a", surface=None)], [], "1.2", [])
        self.assertIn("None of the sequences has such figures.\n\n## Trajectory", page)
        self.assertIn("None of the sequences has such figures.\n\n## Speed", page)

    def test_the_kernels(self):
        page = benchmark.document([], benchmark.check_promises([], 2, KERNELS), "1.2", [], KERNELS)
        self.assertIn("| mission | last tenth / first | ≤ 1.25 | 1.05 | kept |", page)
        self.assertIn("`kintsugi-core-bench --suite` on cpu (2 threads)", page)
        self.assertIn("| 512³ | 5 | 640 x 480 | 10.0 | 20.1 | 30.1 | 40.2 | 50.2 |", page)
        self.assertIn("| 512³ | 5 | 640 x 480 | 21.7 | 0.63 | 3.2 | 21.7 | 0.63 | 3.2 |", page)
        self.assertIn("| voxels | 0.64 | 0.64 | 0.64 | 0.64 | 0.64 |", page)
        self.assertIn("19.5 GB/s, measured beside them by the triad a = b + s c over three arrays of 256 MiB", page)
        self.assertIn("0.22 times as long. No compiler", page)
        on_gpu = KERNELS | {"device": "cuda", "threads": 1,
                            "reductions": KERNELS["reductions"] | {"contracted_ms": 1.5, "fixed_to_contracted": 1.185}}
        self.assertIn("not fusing them costs a factor of 1.19.", benchmark.document([], [], "1.2", [], on_gpu))
        self.assertNotIn("## Kernels", benchmark.document([sequence("room")], [], "1.2", []))

    def test_what_a_gpu_gave(self):
        check = {"ok": True, "why": "", "machine": {"gpu": "Some GPU", "cpu": "Some CPU", "cores": 16},
                 "steps": {tool: {"errors": 0} for tool in ("memcheck", "initcheck", "racecheck")} |
                 {"tests": {"run": 486, "passed": 485, "failed": 0, "compared_with_gpu": 37},
                  "bench_cuda": {"report": KERNELS | {"device": "cuda", "program_version": "1.2"}}, "bench_cpu": {"report": KERNELS}}}
        page = benchmark.document([], [], "1.2", [], None, check)
        self.assertIn("all is well. Some GPU, Some CPU, 16 cores. Of 486 tests of the core 485 passed and 0 failed;\n37 tests compared", page)
        self.assertIn("racecheck found 0 errors. The same suite", page)
        self.assertIn("| 512³ | 5 | 640 x 480 | 10.0 | 20.1 | 30.1 | 40.2 | 50.2 |", page)
        self.assertIn("| 512³ | 5 | 640 x 480 | 10.04 | 20.08 | 30.12 | 40.16 | 50.20 |", page)
        failed = check | {"ok": False, "why": "failed: contraction", "steps": check["steps"] | {"initcheck": {"result": "skipped"}}}
        self.assertIn("failed: contraction. Some GPU", benchmark.gpu_section(failed))
        self.assertIn("initcheck was not run, racecheck found 0 errors", benchmark.gpu_section(failed))
        with self.assertRaisesRegex(LookupError, "initcheck"):
            benchmark.gpu_section(check | {"steps": {k: v for k, v in check["steps"].items() if k != "initcheck"}})

    def test_frames_may_not_take_longer_as_a_mission_goes_on(self):
        slower = KERNELS | {"mission": KERNELS["mission"] | {"last_to_first": 1.26}}
        self.assertEqual(benchmark.check_promises([], 2, slower)[0][4], "**broken**")
        with self.assertRaisesRegex(LookupError, "growth"):
            benchmark.kernels_section({key: value for key, value in KERNELS.items() if key != "growth"})

    def test_writes_nothing_where_nothing_succeeded(self):
        with tempfile.TemporaryDirectory() as folder:
            recording, output = Path(folder) / "recording", Path(folder) / "page.md"
            recording.mkdir()
            (recording / "depth.txt").write_text("")
            (Path(folder) / "kintsugi-collect").symlink_to("/bin/false")
            run = subprocess.run([sys.executable, TOOL, recording, "--bin", folder, "--output", output, "--work", folder],
                                 capture_output=True, text=True, check=False)
            self.assertEqual(run.returncode, 1, run.stderr)
            self.assertIn("nothing was written", run.stderr.splitlines()[-1])
            self.assertFalse(output.exists())

    def test_runs_the_kernels_where_asked_and_says_where_they_fail(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            recording, output = folder / "recording", folder / "page.md"
            recording.mkdir()
            (recording / "depth.txt").write_text("")
            (folder / "report.json").write_text(json.dumps(KERNELS))
            collect, bench = folder / "kintsugi-collect", folder / "kintsugi-core-bench"
            collect.write_text("#!/bin/sh\n[ $1 = --version ] && echo kintsugi-collect 1.2\n")
            bench.write_text(f"#!/bin/sh\n[ \"$*\" = '--suite --threads 2' ] && cat '{folder}/report.json'\n")
            for program in (collect, bench):
                program.chmod(0o755)
            command = [sys.executable, TOOL, recording, "--bin", folder, "--output", output, "--work", folder, "--kernels"]
            run = subprocess.run([*command, "--threads", "2"], capture_output=True, text=True, check=False)
            self.assertEqual(run.stderr.splitlines()[-1], "tools/benchmark: recording failed")
            self.assertIn("## Kernels", output.read_text())
            output.unlink()
            run = subprocess.run(command, capture_output=True, text=True, check=False)  # the made-up bench refuses
            self.assertIn("recording, kernels failed; there are no figures", run.stderr.splitlines()[-1])
            self.assertFalse(output.exists())


if __name__ == "__main__":
    unittest.main()
