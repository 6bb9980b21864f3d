#!/usr/bin/env python3
# A mission that is stopped, or whose disk runs full, leaves a log that can be mapped.
# SPDX-License-Identifier: BSD-3-Clause
import resource
import signal
import subprocess
import time
import unittest

from programs import WORK, ProgramTest, command


class InterruptionTest(ProgramTest):
    def poses(self, log):
        lines = (self.map(log) / "trajectory.txt").read_text().splitlines()
        return sum(not line.startswith("#") for line in lines)

    def test_signals_flush_the_volume(self):
        for stop in (signal.SIGTERM, signal.SIGINT):
            with self.subTest(stop=stop.name):
                log = self.folder / f"{stop.name}.lcm"
                process = subprocess.Popen(command("collect", "--input", f"tum:{WORK / 'room'}", "--log", log),
                                           stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
                deadline = time.monotonic() + 120
                # The session and a few poses are in the log: the mission runs.
                while not (log.exists() and log.stat().st_size > 3000):
                    self.assertIsNone(process.poll(), "ended before it could be stopped")
                    self.assertLess(time.monotonic(), deadline)
                    time.sleep(0.01)
                process.send_signal(stop)
                output, _ = process.communicate(timeout=120)
                self.assertEqual(process.returncode, 0, output)
                poses = self.poses(log)
                self.assertGreater(poses, 0)
                self.assertLess(poses, 90, "the mission had ended before the signal came")
                # The surface seen so far is there, not poses alone.
                header = (self.folder / "map" / "map.ply").read_bytes()[:400].decode("ascii", "replace")
                vertices = int(header.split("element vertex ")[1].split()[0])
                self.assertGreater(vertices, 1000)

    def test_full_disk_is_one_clear_error(self):
        self.run_badly("collect", "--quiet", "--input", f"tum:{WORK / 'small'}", "--log", "/dev/full", naming=["/dev/full"])

    def test_disk_that_fills_up_keeps_what_was_logged(self):
        log = self.folder / "mission.lcm"

        def limit_files():
            # A file at its limit fails to grow as one on a full disk does, once the signal is ignored.
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))

        self.run_badly("collect", "--quiet", "--input", f"tum:{WORK / 'small'}", "--log", log, naming=[log],
                       preexec_fn=limit_files, restore_signals=False)
        self.assertGreater(self.poses(log), 0)

    def test_log_that_cannot_be_written(self):
        source = f"tum:{WORK / 'small'}"
        for log in (self.folder / "none" / "mission.lcm", self.folder):
            with self.subTest(log=log):
                self.run_badly("collect", "--input", source, "--log", log, naming=[log])


if __name__ == "__main__":
    unittest.main()
