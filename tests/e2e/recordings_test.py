#!/usr/bin/env python3
# Real recordings, where this machine has them: tracked throughout, within the promised error.
# SPDX-License-Identifier: BSD-3-Clause
import json
import os
import sys
import unittest

from programs import DATA, ProgramTest

FRAMES = 150  # of redkitchen, to keep the test short; tools/benchmark runs the whole recordings


class RecordingsTest(ProgramTest):
    def collect_and_evaluate(self, source, groundtruth):
        self.log, report = self.collect(source)
        self.assertEqual(report["tracked_share"], 1)
        self.out = self.map(self.log)
        return self.evaluate("trajectory", estimate=self.out / "trajectory.txt", groundtruth=groundtruth)

    @unittest.skipUnless((DATA / "redkitchen").is_dir(), f"no recording {DATA / 'redkitchen'}")
    def test_redkitchen(self):
        folder = self.folder / "redkitchen"
        folder.mkdir()
        for file in sorted((DATA / "redkitchen").glob("frame-*"))[: 3 * FRAMES]:
            os.symlink(file, folder / file.name)
        source = f"7scenes:{folder}"
        self.assertLess(self.collect_and_evaluate(source, groundtruth=source)["ate"]["rmse_m"], 0.028)

    @unittest.skipUnless((DATA / "fr1_xyz_260").is_dir(), f"no recording {DATA / 'fr1_xyz_260'}")
    def test_fr1_xyz(self):
        folder = DATA / "fr1_xyz_260"
        ate = self.collect_and_evaluate(f"tum:{folder}", folder / "groundtruth.txt")["ate"]
        self.assertLess(ate["rmse_m"], 0.017)
        # Its colour images come 5 to 10 ms later than the depth images of their stamps.
        change = json.loads((self.out / "report.json").read_text())["refinement"]["calibration_change"]
        self.assertGreater(change["colour_delay_s"], 0.003)
        corrected = self.out / "corrected_calibration.yaml"
        self.assertIn("colour_delay_s: 0.00", corrected.read_text())
        self.run_well("collect", "--input", f"tum:{folder}", "--calibration", corrected, "--log", self.folder / "again.lcm")
        self.run_well("map", self.log, "--output", self.out, "--no-refine")
        self.assertFalse(corrected.exists(), "that of an earlier run")


if __name__ == "__main__":
    if not DATA.is_dir():
        print(f"skipped: no recordings in {DATA} (set KT_DATA to their folder)")
        sys.exit(77)
    unittest.main()
