#!/usr/bin/env python3
# Live missions: what is lost or done without is counted, and the log repeats the rest; memory that is locked.
# SPDX-License-Identifier: BSD-3-Clause
import json
import resource
import shutil
import subprocess
import unittest

from lcm_test import messages
from programs import MISSIONS, SMALL_VOLUME, WORK, ProgramTest, command

FRAMES = int(MISSIONS["moving"][2])


class RealtimeTest(ProgramTest):
    def test_a_live_mission_is_repeated_by_its_log(self):
        options = ["--record-raw", "--raw-colour", "png", *(word for setting in SMALL_VOLUME for word in ("--set", setting))]
        live, again, report = (self.folder / name for name in ("live.lcm", "again.lcm", "report.json"))
        self.run_well("collect", "--input", f"tum:{WORK / 'moving'}", "--log", live, "--real-time", "--report", report, *options)
        counts = json.loads(report.read_text())
        self.assertEqual(counts["frames"] + counts["frames_dropped"], FRAMES)
        self.assertEqual(counts["frames_skipped"], counts["frames_dropped"])
        self.assertEqual(sum(counts["frames_by_effort"].values()), counts["frames"])
        self.assertEqual(counts["stages"]["latency"]["count"], counts["frames"])
        self.run_well("collect", "--input", f"lcm-log:{live}", "--log", again, *options)
        for channel in ("SESSION", "POSE", "SLICE", "KEYFRAME", "LOOP", "RGBD"):
            self.assertEqual(messages(live, channel), messages(again, channel), channel)

    def test_memory_that_may_not_be_locked_is_one_clear_error(self):
        inside = ["unshare", "--user", "--map-root-user"]  # without the privileges of a root user
        if shutil.which("unshare") is None or subprocess.run([*inside, "true"], capture_output=True, check=False).returncode != 0:
            self.skipTest("this system lets no user be another (unshare -r)")
        log = self.folder / "a.lcm"
        result = subprocess.run([*inside, *command("collect", "--input", f"tum:{WORK / 'small'}", "--log", log, "--lock-memory")],
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
                                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_MEMLOCK, (1 << 20, 1 << 20)))
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertIn("this user may lock 1 MiB", result.stdout)
        self.assertIn("LimitMEMLOCK=infinity", result.stdout)
        self.assertFalse(log.exists())


if __name__ == "__main__":
    unittest.main()
