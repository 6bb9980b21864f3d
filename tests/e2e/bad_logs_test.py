#!/usr/bin/env python3
# Damaged logs: kintsugi-map and kintsugi-log never crash, use what is intact and count what is not.
# SPDX-License-Identifier: BSD-3-Clause
import json
import random
import struct
import unittest

from programs import SMALL_VOLUME, WORK, ProgramTest, run

SYNC = 0xEDA1DA01


def events(log):
    """(begin, end, channel) of every event of an intact LCM log."""
    position, found = 0, []
    while position < len(log):
        sync, _, _, channel_size, size = struct.unpack_from(">IqqII", log, position)
        assert sync == SYNC
        begin, position = position, position + 28 + channel_size + size
        found.append((begin, position, log[begin + 28 : begin + 28 + channel_size].decode()))
    return found


def poses_in(log_events):
    return sum(channel == "KINTSUGI_POSE" for _, _, channel in log_events)


class BadLogsTest(ProgramTest):
    def setUp(self):
        super().setUp()
        log, report = self.collect(f"tum:{WORK / 'moving'}", settings=SMALL_VOLUME)
        self.assertGreater(report["slices"], 2)
        self.intact = log.read_bytes()
        self.events = events(self.intact)
        self.poses = poses_in(self.events)
        self.assertEqual(self.poses, report["frames"])

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

    def test_an_intact_log(self):
        self.assertEqual(self.try_log(self.intact), self.poses)

    def test_flipped_bits(self):
        session_end = self.events[0][1]
        random.seed(1)
        for i in range(16):
            damaged = bytearray(self.intact)
            # Slices are most of the bytes: half of the flips go to the other events.
            event = random.choice([e for e in self.events if (e[1] - e[0] < 1000) == (i % 2 == 0)])
            position = random.randrange(*event[:2])
            damaged[position] ^= 1 << random.randrange(8)
            with self.subTest(position=position, event=event):
                poses = self.try_log(bytes(damaged))
                if poses is None:  # only a log without its first event is useless
                    self.assertLess(position, session_end)
                else:
                    self.assertGreaterEqual(poses, self.poses - 1)

    def test_cut_off_anywhere(self):
        size, session_end = len(self.intact), self.events[0][1]
        first_pose_end = next(end for _, end, channel in self.events if channel == "KINTSUGI_POSE")
        for length in (0, 1, 20, 27, session_end, first_pose_end - 1, first_pose_end, size // 3, size // 2, size - 1):
            with self.subTest(length=length):
                whole_events = [event for event in self.events if event[1] <= length]
                self.assertEqual(self.try_log(self.intact[:length]), poses_in(whole_events) or None)

    def test_a_hole_in_the_middle(self):
        begin, end, _ = next(event for event in self.events[8:] if event[2] == "KINTSUGI_POSE")
        hole_begin, hole_end = begin + 10, end + 10  # the end of one event and the start of another
        lost = [event for event in self.events if event[0] < hole_end and hole_begin < event[1]]
        poses = self.try_log(self.intact[:hole_begin] + bytes(hole_end - hole_begin) + self.intact[hole_end:])
        self.assertEqual(poses, self.poses - poses_in(lost))
        integrity = json.loads((self.folder / "map" / "report.json").read_text())
        self.assertIn("integrity", integrity)

    def test_no_log_at_all(self):
        for content in (b"hello\n", bytes(100_000), random.Random(2).randbytes(100_000)):
            self.assertIsNone(self.try_log(content))
        self.run_badly("map", self.folder / "none.lcm", "--output", self.folder / "map", naming=["none.lcm"])

    def test_output_that_cannot_be_written(self):
        (self.folder / "file").write_text("not a folder")
        self.run_badly("map", self.folder / "mission.lcm", "--output", self.folder / "file", naming=["file"])


if __name__ == "__main__":
    unittest.main()
