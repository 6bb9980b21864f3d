#!/usr/bin/env python3
# Nothing recorded is lost: killed missions, full, low and dead disks, logs in many files.
# SPDX-License-Identifier: BSD-3-Clause
import json
import os
import select
import signal
import subprocess
import sys
import unittest

from programs import BIN, ROOT, SMALL_VOLUME, WORK, ProgramTest, command, run

MOVING = f"tum:{WORK / 'moving'}"


class StorageTest(ProgramTest):
    def info(self, log):
        return json.loads(self.run_well("log", "info", log, "--json"))

    def collect_moving(self, name, *flags):
        log = self.folder / name
        settings = [word for setting in SMALL_VOLUME for word in ("--set", setting)]
        self.run_well("collect", "--input", MOVING, "--log", log, *settings, *flags)
        return log

    def map_files(self, log, name):
        output = self.folder / name
        self.run_well("map", log, "--output", output)
        return {file: (output / file).read_bytes() for file in ("map.ply", "trajectory.txt", "poses.g2o")}

    def test_killed_missions_and_full_disks(self):
        result = subprocess.run([sys.executable, ROOT / "tools" / "crash_test", "--runs", "5", "--full-disks", "2", "--bin", BIN],
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        self.assertEqual(result.returncode, 0, result.stdout)
        self.assertIn("5 kills", result.stdout)

    def test_a_log_in_many_files_is_the_same_log(self):
        flags = ["--record-raw", "--raw-colour", "png"]
        whole = self.collect_moving("whole.lcm", *flags)
        rolled = self.collect_moving("rolled.lcm", *flags, "--roll", "500kB")
        parts = sorted(self.folder.glob("rolled*.lcm"))
        self.assertGreater(len(parts), 3)
        info = self.info(rolled)
        self.assertTrue(info["integrity"]["sound"])
        self.assertEqual(info["files"], len(parts))
        self.assertEqual(info["integrity"]["events"], self.info(whole)["integrity"]["events"] + len(parts) - 1)
        expected = self.map_files(whole, "of-whole")
        self.assertEqual(self.map_files(rolled, "of-rolled"), expected)
        self.run_well("map", *parts, "--output", self.folder / "of-parts")  # as the shell names them
        self.assertEqual((self.folder / "of-parts" / "map.ply").read_bytes(), expected["map.ply"])
        again = self.folder / "again.lcm"
        settings = [word for setting in SMALL_VOLUME for word in ("--set", setting)]
        self.run_well("collect", "--input", f"lcm-log:{rolled}", "--log", again, *flags, *settings)
        self.assertEqual(again.read_bytes(), whole.read_bytes(), "its raw frames give the same mission")
        (self.folder / "rolled.002.lcm").unlink()
        self.assertIn("1 part of the log missing", self.run_well("log", "info", rolled))
        self.run_well("map", rolled, "--output", self.folder / "of-rest")

    def test_old_parts_do_not_mix_with_a_new_mission(self):
        log = self.collect_moving("mission.lcm", "--roll", "200kB")
        self.assertTrue((self.folder / "mission.001.lcm").exists())
        log.unlink()
        self.run_badly("collect", "--input", MOVING, "--log", log, naming=["mission.001.lcm"])
        self.collect_moving("mission.lcm", "--overwrite")
        self.assertFalse((self.folder / "mission.001.lcm").exists())
        self.assertTrue(self.info(log)["integrity"]["sound"])

    def test_a_low_disk_costs_raw_frames_first(self):
        # A reserve that no disk has.
        log, report = self.folder / "mission.lcm", self.folder / "report.json"
        result = run("collect", "--input", f"tum:{WORK / 'small'}", "--log", log, "--record-raw", "--reserve", "1000TB", "--report", report,
                     "--quiet")
        self.assertEqual(result.returncode, 1)
        lines = result.stdout.strip().splitlines()
        self.assertEqual(lines[0], "kintsugi-collect: log: no raw frames and no keyframes are stored any more")
        self.assertIn("had no room for 24 raw frames", lines[-1])
        self.assertEqual(json.loads(report.read_text())["not_stored"]["raw_frames"], 24)
        info = self.info(log)
        self.assertEqual(info["channels"]["KINTSUGI_RGBD"]["messages"], 0)
        self.assertEqual(info["channels"]["KINTSUGI_POSE"]["messages"], 24)
        self.assertFalse(info["integrity"]["final_slice_missing"])

    def test_a_dead_disk_does_not_outlast_the_signal(self):
        pipe = self.folder / "pipe.lcm"
        os.mkfifo(pipe)
        reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)  # never reads
        self.addCleanup(os.close, reader)
        with subprocess.Popen(command("collect", "--input", f"tum:{WORK / 'room'}", "--log", pipe, "--record-raw", "--quiet"),
                              stderr=subprocess.PIPE, text=True) as process:
            select.select([reader], [], [], 120)
            process.send_signal(signal.SIGTERM)
            _, errors = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 1)
        self.assertIn("answers no more", errors)

    def test_a_silent_source_ends_with_the_signal(self):
        log = self.folder / "mission.lcm"
        with subprocess.Popen(command("collect", "--input", "lcm:memq://", "--calibration", "synthetic", "--log", log),
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            process.stderr.readline()  # it is about to begin
            try:
                process.communicate(timeout=2)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGTERM)
            output, errors = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 0, errors)
        self.assertIn("stopped by the user", output)
        self.assertFalse(log.exists())


if __name__ == "__main__":
    unittest.main()
