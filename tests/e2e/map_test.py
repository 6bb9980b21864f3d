#!/usr/bin/env python3
# Whole maps: the surface fused anew, several logs joined, and every format.
# SPDX-License-Identifier: BSD-3-Clause
import json
import resource
import shutil
import signal
import subprocess
import time
import unittest

from ply import read_ply
from programs import WORK, ProgramTest, command


def split(folder, first, last):
    """Keeps the frames [first, last) of a copied recording."""
    for name in ("rgb.txt", "depth.txt"):
        lines = [line for line in (folder / name).read_text().splitlines() if not line.startswith("#")]
        (folder / name).write_text("\n".join(lines[first:last]) + "\n")
    return folder


class MapTest(ProgramTest):
    def report(self, out):
        return json.loads((out / "report.json").read_text())

    def map_with(self, name, *arguments):
        self.run_well("map", *arguments, "--output", self.folder / name)
        return self.folder / name

    def test_the_frames_of_a_log_or_of_its_recording_give_the_same_map(self):
        source = f"tum:{WORK / 'small'}"
        self.run_well("collect", "--input", source, "--log", self.folder / "raw.lcm", "--record-raw", "--raw-colour", "png")
        log, _ = self.collect(source)
        from_log = self.map_with("a", self.folder / "raw.lcm")
        from_recording = self.map_with("b", log, "--frames", source)
        slices = self.map_with("c", log)
        for out, surface, made in ((from_log, "frames", "fuse"), (from_recording, "frames", "fuse"), (slices, "slices", "deform")):
            self.assertEqual(self.report(out)["segments"]["list"][0]["surface"], surface)
            self.assertEqual(len(list((out / "stages").glob(f"{made}-*"))), 1, "the tiles, and nothing that was for a while")
            self.assertEqual([], list(out.glob("*.tmp*")))
        self.assertEqual((from_log / "map.ply").read_bytes(), (from_recording / "map.ply").read_bytes())
        self.assertGreater(self.report(slices)["map"]["triangles"], 10_000)
        ratio = self.report(from_log)["map"]["triangles"] / self.report(slices)["map"]["triangles"]
        self.assertTrue(0.9 < ratio < 1.1, ratio)

    def test_frames_are_fused_with_the_limits_that_their_log_was_collected_with(self):
        source = f"tum:{WORK / 'small'}"
        log, _ = self.collect(source, settings=["preprocess.depth_max_m=1.5"])
        near = self.report(self.map_with("near", log, "--frames", source))["map"]["triangles"]
        slices = self.report(self.map_with("slices", log))["map"]["triangles"]
        far_log, _ = self.collect(source, self.folder / "far.lcm")
        far = self.report(self.map_with("far", far_log, "--frames", source))["map"]["triangles"]
        self.assertTrue(0.9 < near / slices < 1.1, (near, slices))
        self.assertLess(near, 0.9 * far)

    def test_frames_are_brought_to_one_exposure(self):
        mission = WORK / "metered"
        log, _ = self.collect(f"tum:{mission}")
        errors = {}
        for exposure in ("even", "asis"):
            out = self.map_with(exposure, log, "--frames", f"tum:{mission}", "--exposure", exposure)
            told = self.report(out)["segments"]["list"][0]["exposure"]
            if exposure == "even":
                self.assertTrue(told["applied"], told)
                self.assertLess(told["disagreement_after"], 0.7 * told["disagreement_before"])
            else:
                self.assertIsNone(told)
            surface = self.evaluate("surface", map=out / "map.ply", groundtruth=mission / "surface.ply",
                                    seen=mission / "surface_seen.ply", colours=mission / "surface_colours.ply",
                                    align_estimate=out / "trajectory.txt", align_groundtruth=mission / "groundtruth.txt")
            errors[exposure] = surface["colour"]["mean_levels"]
        self.assertLess(errors["even"], 0.9 * errors["asis"], errors)

    def test_two_halves_are_joined_by_what_both_saw(self):
        truth = WORK / "turning" / "groundtruth.txt"
        logs = []
        for name, first, last in (("a", 0, 70), ("b", 45, 110)):
            folder = self.folder / name
            shutil.copytree(WORK / "turning", folder)
            logs.append(self.collect(f"tum:{split(folder, first, last)}", self.folder / f"{name}.lcm")[0])
        out = self.map_with("joined", *logs)
        report = self.report(out)
        self.assertEqual(len(report["segments"]["list"]), 1, report["segments"])
        self.assertEqual(report["segments"]["list"][0]["joined"], [1])
        self.assertEqual(report["frames"]["processed"], 135)
        residuals = report["optimisation"]["residuals"]
        self.assertGreater(residuals["edges_between_segments"], 1, residuals)
        self.assertFalse((out / "segment-1").exists())
        files = self.files(out)
        (out / "stages" / "deform-0").unlink()
        self.map_with("joined", *logs)
        self.assertEqual(self.taken(out), ["load", "loops", "optimise", "refine"])
        self.assertEqual(self.files(out), files)
        error = self.evaluate("trajectory", estimate=out / "trajectory.txt", groundtruth=truth)
        self.assertLess(error["ate"]["rmse_m"], 0.01)
        apart = self.report(self.map_with("apart", *logs, "--loops", "none"))
        self.assertEqual(len(apart["segments"]["list"]), 2)

    def files(self, out):
        return {name: (out / name).read_bytes() for name in ("map.ply", "trajectory.txt", "poses.g2o")}

    def taken(self, out):
        return [stage["name"] for stage in self.report(out)["run"]["stages"] if stage["from_file"]]

    def test_a_killed_run_goes_on_and_gives_the_same_bytes(self):
        log, _ = self.collect(f"tum:{WORK / 'turning'}")
        arguments = [log, "--frames", f"tum:{WORK / 'turning'}"]
        whole = self.map_with("whole", *arguments, "--no-stages")
        self.assertFalse((whole / "stages").exists())
        out = self.folder / "killed"
        kills = 0
        # Killed when a stage has just been kept: the next one has begun.
        for stage in ("load", "loops", "optimise", "refine"):
            process = subprocess.Popen(command("map", *arguments, "--output", out), stdout=subprocess.DEVNULL,
                                       stderr=subprocess.STDOUT)
            deadline = time.monotonic() + 120
            while not (out / "stages" / f"{stage}.json").exists() and process.poll() is None:
                self.assertLess(time.monotonic(), deadline)
                time.sleep(0.005)
            process.send_signal(signal.SIGKILL)
            kills += process.wait() == -signal.SIGKILL
        self.assertEqual(kills, 4)
        self.map_with("killed", *arguments)
        self.assertEqual(self.taken(out), ["load", "loops", "optimise", "refine"])
        self.assertEqual(self.files(out), self.files(whole))
        self.assertEqual(self.report(out)["digest"], self.report(whole)["digest"])

        self.map_with("killed", *arguments, "--format", "glb", "--simplify", "0.5")
        self.assertEqual(self.taken(out), ["load", "loops", "optimise", "refine", "fuse"])
        self.map_with("killed", *arguments, "--voxel-size", "0.03")
        self.assertEqual(self.taken(out), ["load", "loops", "optimise", "refine"])
        self.assertNotEqual(self.files(out), self.files(whole))
        # The files of a folder that has changed are other frames.
        moved = self.copy_of("turning")
        self.map_with("killed", log, "--frames", f"tum:{moved}")
        self.assertEqual(self.taken(out), ["load", "loops", "optimise", "refine"])
        (out / "stages" / "optimise").write_bytes(b"rubbish")
        text = self.run_well("map", log, "--frames", f"tum:{moved}", "--output", out)
        self.assertIn("the stage optimise was made anew\n", text)
        self.assertEqual(self.taken(out), ["load", "loops", "refine", "fuse"])
        self.assertEqual(self.files(out), self.files(whole))

    def test_a_full_disk_costs_one_stage(self):
        log, _ = self.collect(f"tum:{WORK / 'small'}")
        out = self.map_with("map", log, "--until", "refine")
        self.assertEqual(sorted(path.name for path in (out / "stages").glob("*.json")),
                         ["load.json", "loops.json", "optimise.json", "refine.json"])

        def limit_files():
            # A file at its limit fails to grow as one on a full disk does, once the signal is ignored.
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))

        self.run_badly("map", log, "--output", out, naming=[out / "stages" / "deform-0"], preexec_fn=limit_files,
                       restore_signals=False)
        self.assertFalse(list((out / "stages").glob("deform*")))
        self.map_with("map", log)
        self.assertEqual(self.taken(out), ["load", "loops", "optimise", "refine"])
        self.run_badly("map", log, "--output", self.folder / "x", "--until", "loops", "--no-stages", naming=["leave nothing"])

    def test_formats_and_options(self):
        log, _ = self.collect(f"tum:{WORK / 'small'}")
        whole = self.map_with("whole", log, "--format", "ply,obj,glb", "--min-island", "0")
        self.assertEqual((whole / "map.glb").read_bytes()[:4], b"glTF")
        self.assertIn("\nf ", (whole / "map.obj").read_text())
        triangles = self.report(whole)["map"]["triangles"]
        self.assertEqual(self.report(whole)["segments"]["list"][0]["dropped_islands"], 0)
        few = self.map_with("few", log, "--simplify", "0.25")
        _, kept = read_ply(few / "map.ply")
        self.assertTrue(0.2 * triangles < len(kept) < 0.3 * triangles, (len(kept), triangles))
        self.assertGreater(self.report(few)["segments"]["list"][0]["dropped_islands"], 0)
        self.run_badly("map", log, "--output", self.folder / "x", "--format", "stl", naming=["stl"])
        self.run_badly("map", log, "--output", self.folder / "x", "--surface", "frames", naming=["holds no raw frames", "--frames"])
        later = self.copy_of("small")
        for name in ("rgb.txt", "depth.txt"):
            lines = [line.split() for line in (later / name).read_text().splitlines() if not line.startswith("#")]
            (later / name).write_text("".join(f"{float(stamp) + 1000:.6f} {image}\n" for stamp, image in lines))
        self.run_badly("map", log, "--output", self.folder / "x", "--frames", f"tum:{later}", naming=["another mission"])
        self.run_badly("map", log, "--output", self.folder / "x", "--frames", f"tum:{WORK / 'elsewhere'}",
                       naming=["another mission"])
        self.run_badly("map", log, log, "--output", self.folder / "x", "--frames", f"tum:{WORK / 'small'}",
                       naming=["one recording for each log"])


if __name__ == "__main__":
    unittest.main()
