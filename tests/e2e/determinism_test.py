#!/usr/bin/env python3
# Equal input gives equal bytes: for any number of threads, on either device, for every run, in the log and in the map.
# SPDX-License-Identifier: BSD-3-Clause
import hashlib
import json
import unittest

from programs import SMALL_VOLUME, WORK, ProgramTest


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


class DeterminismTest(ProgramTest):
    def collect_moving(self, log=None, **flags):
        """A mission during which the volume moves, so that shift and slices are compared, too."""
        log, report = self.collect(f"tum:{WORK / 'moving'}", log, SMALL_VOLUME, **flags)
        self.assertGreater(report["slices"], 2)
        self.assertEqual(report["tracked_share"], 1)
        return log

    def test_log_bytes_do_not_depend_on_threads_device_or_runs(self):
        logs = [self.collect_moving(self.folder / f"{i}.lcm", device="cpu", threads=threads)
                for i, threads in enumerate((1, 2, 3))]
        logs.append(self.collect_moving(self.folder / "auto.lcm"))  # the GPU where there is one, else a second run
        self.assertEqual(len({digest(log) for log in logs}), 1, [digest(log) for log in logs])

    def test_map_bytes_do_not_depend_on_the_run(self):
        log = self.collect_moving()
        maps = []
        for _ in range(2):
            out = self.folder / "map"
            self.run_well("map", log, "--output", out, "--from", "load")
            report = json.loads((out / "report.json").read_text())
            del report["run"]  # durations and memory: the one part that tells of the machine
            # The stages' files too, but for their records, which hold durations.
            digests = {str(file.relative_to(out)): digest(file) for file in sorted(out.rglob("*"))
                       if file.is_file() and file.suffix != ".json"}
            self.assertIn("stages/deform-0", digests)
            maps.append((report, digests))
        self.assertEqual(maps[0], maps[1])

    def test_another_mission_gives_another_log(self):
        # Guards the tests above: a digest of nothing would be equal, too.
        small = self.copy_of("small")
        log, _ = self.collect(f"tum:{small}", self.folder / "whole.lcm")
        lines = (small / "depth.txt").read_text().splitlines()
        (small / "depth.txt").write_text("\n".join(lines[:-1]) + "\n")
        shorter, _ = self.collect(f"tum:{small}", self.folder / "shorter.lcm")
        self.assertNotEqual(digest(log), digest(shorter))


if __name__ == "__main__":
    unittest.main()
