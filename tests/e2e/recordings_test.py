#!/usr/bin/env python3
# The first frames of real recordings, where this machine has them: tracked throughout, within the promised error.
# SPDX-License-Identifier: BSD-3-Clause
import os
import sys
import unittest

from programs import DATA, ProgramTest

FRAMES = 150  # keeps the test short; tools/benchmark runs the whole recordings


class RecordingsTest(ProgramTest):
    def collect_and_evaluate(self, source, groundtruth):
        log, report = self.collect(source)
        self.assertEqual(report["tracked_share"], 1)
        out = self.map(log)
        return self.evaluate("trajectory", estimate=out / "trajectory.txt", groundtruth=groundtruth)

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
        recording, folder = DATA / "fr1_xyz_260", self.folder / "fr1_xyz"
        folder.mkdir()
        for name in ("rgb", "depth", "rgb.txt", "groundtruth.txt"):
            os.symlink(recording / name, folder / name)
        lines = [line for line in (recording / "depth.txt").read_text().splitlines() if not line.startswith("#")]
        (folder / "depth.txt").write_text("\n".join(lines[:FRAMES]) + "\n")
        ate = self.collect_and_evaluate(f"tum:{folder}", folder / "groundtruth.txt")["ate"]
        self.assertLess(ate["rmse_m"], 0.017)


if __name__ == "__main__":
    if not DATA.is_dir():
        print(f"skipped: no recordings in {DATA} (set KT_DATA to their folder)")
        sys.exit(77)
    unittest.main()
