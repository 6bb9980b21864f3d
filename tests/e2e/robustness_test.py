#!/usr/bin/env python3
# A camera that is blinded, covered or carried off is found again, and no wrong pose is believed on the way.
# SPDX-License-Identifier: BSD-3-Clause
import sys
import unittest
from dataclasses import replace
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader

from programs import ROOT, WORK, ProgramTest

TOOL = ROOT / "tools" / "robustness"
sys.path.insert(0, str(TOOL.parent))
robustness = module_from_spec(spec_from_loader("robustness", SourceFileLoader("robustness", str(TOOL))))
sys.modules["robustness"] = robustness
robustness.__loader__.exec_module(robustness)
from mission_files import SOURCES, read_poses, read_recording, write_tum  # noqa: E402  (found through the path above)

# A quarter of the usual pixels show fewer corners.
SETTINGS = ["volume.voxel_size_m=0.02", "volume.resolution=256"]
SECOND = 30  # frames
SOON = 1.5 * SECOND


class RobustnessTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.recording = read_recording(WORK / "turning")
        self.frames = self.recording.frames
        self.interval_us = self.recording.interval_us()

    def judged(self, variant):
        """Runs a variant; returns its verdict, its poses and the report."""
        source = self.folder / "recording"
        write_tum(source, variant.frames, self.recording.calibration)
        log, report = self.collect(f"tum:{source}", settings=SETTINGS)
        poses = read_poses(log)
        verdict = robustness.judge(variant, poses)
        self.assertEqual(len(verdict.wrong), 0, f"good poses are wrong, by up to {verdict.largest_error_m:.3f} m")
        before = {frame.stamp_us for frame in variant.frames[:variant.returns[0]] if not frame.is_damaged}
        self.assertTrue(all(pose.is_good for pose in poses if pose.stamp_us in before), "lost before the damage")
        return verdict, poses, report

    def covered(self, kind, seconds, moved):
        """From frame 60 on the camera sees the pictures of that kind and stands still; then it is `moved` frames farther."""
        at = 60
        pictures = robustness.make_pictures(self.folder / "altered", self.recording)[kind]
        dark = [replace(self.frames[at], depth=depth, colour=colour, is_damaged=True)
                for depth, colour in (pictures * SECOND * seconds)[:SECOND * seconds]]
        frames = self.frames[:at] + dark + self.frames[at + moved:at + moved + 40]
        return robustness.Variant(kind, robustness.played(frames, self.interval_us), [at + len(dark)])

    def assert_found_soon(self, variant):
        verdict, poses, report = self.judged(variant)
        until_good, _ = verdict.recoveries[0]
        self.assertIsNotNone(until_good, "never good again")
        self.assertLessEqual(until_good, SOON)
        self.assertTrue(poses[-1].is_good)
        self.assertEqual(verdict.segments, 1, "it is in the same place")
        self.assertEqual(report["stretches"][0]["end"], "found again")
        return report

    def test_after_a_blackout(self):
        report = self.assert_found_soon(self.covered("black", seconds=1, moved=10))
        self.assertEqual(report["frames_skipped"], SECOND)
        self.assertEqual(report["stretches"][0]["cause"], "gap")

    def test_after_a_hand_before_the_lens(self):
        self.assert_found_soon(self.covered("near", seconds=2, moved=0))

    def test_after_a_covered_lens_that_measures_nothing(self):
        self.assert_found_soon(self.covered("blind", seconds=2, moved=10))

    def test_carried_to_a_place_it_knows(self):
        before, after = self.frames[:100], self.frames[10:40]
        verdict, poses, report = self.judged(robustness.carry_off("known", before, after, self.interval_us))
        until_good, source = verdict.recoveries[0]
        self.assertIsNotNone(until_good, "never good again")
        self.assertEqual(source, "relocalised")
        self.assertTrue(poses[-1].is_good)
        self.assertEqual(verdict.segments, 1)
        self.assertGreater(report["poses_by_source"]["relocalised"], 0)

    def test_carried_to_a_place_it_has_never_seen(self):
        elsewhere = read_recording(WORK / "elsewhere").frames
        variant = robustness.carry_off("unknown", self.frames[:60], elsewhere, self.interval_us)
        verdict, poses, report = self.judged(variant)
        self.assertEqual(verdict.segments, 2)
        self.assertEqual((report["segments"], report["segment"]), (2, 1))
        self.assertTrue(poses[-1].is_good)
        there = [pose for pose in poses if pose.segment == 1 and pose.is_good]
        self.assertEqual(SOURCES[there[0].source], "start")
        self.assertEqual(report["stretches"][0]["end"], "new segment")


if __name__ == "__main__":
    unittest.main()
