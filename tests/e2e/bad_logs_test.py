#!/usr/bin/env python3
# Damaged logs: kintsugi-map and kintsugi-log never crash, use what is intact and count what is not.
# SPDX-License-Identifier: BSD-3-Clause
import random
import unittest

from programs import WORK, ProgramTest, run


class BadLogsTest(ProgramTest):
    def setUp(self):
        super().setUp()
        log, _ = self.collect(f"tum:{WORK / 'small'}")
        self.intact = log.read_bytes()

    def try_log(self, content):
        """Maps a log; returns the number of poses, or none where the log is refused with one clear line."""
        log = self.folder / "damaged.lcm"
        log.write_bytes(content)
        for program, arguments in (("log", ["info", log]), ("map", [log, "--output", self.folder / "map"])):
            result = run(program, *arguments)
            self.assertIn(result.returncode, (0, 1), f"{program} crashed:\n{result.stdout}")
            if result.returncode == 1:
                self.assertIn("damaged.lcm", result.stdout.strip().splitlines()[-1])
        if result.returncode == 1:
            return None
        lines = (self.folder / "map" / "trajectory.txt").read_text().splitlines()
        return sum(not line.startswith("#") for line in lines)

    def test_flipped_bits(self):
        whole = self.try_log(self.intact)
        random.seed(1)
        for _ in range(12):
            damaged = bytearray(self.intact)
            # Small events are a sliver of the bytes: half of the flips go to the first part, where poses lie.
            end = len(damaged) if random.random() < 0.5 else min(len(damaged), 6000)
            position = random.randrange(end)
            damaged[position] ^= 1 << random.randrange(8)
            with self.subTest(position=position):
                poses = self.try_log(bytes(damaged))
                if poses is None:  # only a log without its first event is useless
                    self.assertLess(position, 3000)
                else:
                    self.assertGreaterEqual(poses, whole - 1)

    def test_cut_off_anywhere(self):
        whole = self.try_log(self.intact)
        size = len(self.intact)
        for length in (0, 1, 20, 27, 400, size // 3, size // 2, size - 1):
            with self.subTest(length=length):
                poses = self.try_log(self.intact[:length])
                self.assertLessEqual(poses or 0, whole)
                if length == size - 1:
                    self.assertEqual(poses, whole)  # the last event is the last status

    def test_a_hole_in_the_middle(self):
        whole = self.try_log(self.intact)
        damaged = self.intact[:5000] + bytes(300) + self.intact[5300:]
        poses = self.try_log(damaged)
        self.assertIsNotNone(poses)
        self.assertGreaterEqual(poses, whole - 4)

    def test_no_log_at_all(self):
        for content in (b"hello\n", bytes(100_000), random.Random(2).randbytes(100_000)):
            self.assertIsNone(self.try_log(content))
        self.run_badly("map", self.folder / "none.lcm", "--output", self.folder / "map", naming=["none.lcm"])

    def test_output_that_cannot_be_written(self):
        (self.folder / "file").write_text("not a folder")
        self.run_badly("map", self.folder / "mission.lcm", "--output", self.folder / "file", naming=["file"])


if __name__ == "__main__":
    unittest.main()
