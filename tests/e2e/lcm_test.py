#!/usr/bin/env python3
# LCM as the robot's bus, with LCM's own lcm-logger and lcm-logplayer, on a network that this test has for itself.
# SPDX-License-Identifier: BSD-3-Clause
import json
import os
import shutil
import signal
import struct
import subprocess
import time
import unittest
from pathlib import Path

import private_network
from programs import WORK, ProgramTest, command

LCM_JAR = Path("/usr/share/java/lcm.jar")
SMALL_RESULTS = ("SESSION", "POSE", "LOOP", "STATUS")


def events(log):
    """(channel without "KINTSUGI_", message) of every event of a log."""
    data, at = Path(log).read_bytes(), 0
    while at < len(data):
        sync, _, _, name_bytes, message_bytes = struct.unpack_from(">IqqII", data, at)
        assert sync == 0xEDA1DA01
        at += 28
        yield data[at:at + name_bytes].decode().removeprefix("KINTSUGI_"), data[at + name_bytes:at + name_bytes + message_bytes]
        at += name_bytes + message_bytes


def messages(log, channel):
    return [message for name, message in events(log) if name == channel]


def sequence(message):
    return struct.unpack_from(">q", message, 8)[0]


def stamp(message):
    return struct.unpack_from(">q", message, 16)[0]


def frame_of(pose):
    return struct.unpack_from(">q", pose, 28)[0]


def triangles(message):
    return struct.unpack_from(">i", message, 149)[0]


class LcmTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.recorded = self.folder / "recorded.lcm"
        self.run_well("collect", "--input", f"tum:{WORK / 'wheels'}", "--log", self.recorded, "--record-raw", "--raw-colour",
                      "png")

    def start(self, *arguments, **options):
        process = subprocess.Popen([str(word) for word in arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                   text=True, **options)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def start_collector(self, url, *more):
        """A collector on the bus that logs to live.lcm and ends when nothing comes any more."""
        return self.start(*command("collect", "--input", f"lcm:{url}", "--log", self.folder / "live.lcm", "--record-raw",
                                   "--raw-colour", "png", "--when-late", "drop", "--idle-timeout", 5, "--report", self.folder / "live.json", *more))

    def end(self, process):
        output, _ = process.communicate(timeout=300)
        self.assertEqual(process.returncode, 0, output)
        return output

    def report(self):
        return json.loads((self.folder / "live.json").read_text())

    def check_arrived(self):
        """What arrived gave the poses that it gives when read from a file, and what did not is counted."""
        live, report = self.folder / "live.lcm", self.report()
        sent = {stamp(frame): frame for frame in messages(self.recorded, "RGBD")}
        arrived = messages(live, "RGBD")
        self.assertGreater(len(arrived), 0)
        for frame in arrived:
            self.assertEqual(frame[36:], sent[stamp(frame)][36:], "a frame changed on its way")
        last = sequence(sent[stamp(arrived[-1])])
        self.assertEqual(report["frames"], len(arrived))
        self.assertEqual(report["frames_skipped"], last + 1 - len(arrived))
        self.assertTrue(report["timed_out"])
        replayed, _ = self.collect(f"lcm-log:{live}", self.folder / "replayed.lcm")
        self.assertEqual(messages(replayed, "POSE"), messages(live, "POSE"))
        return len(sent) - len(arrived)

    def test_frames_over_udp(self):
        collector = self.start_collector("")
        self.assertTrue(private_network.wait_for_listeners(1, collector), "the collector does not listen")
        self.end(self.start("lcm-logplayer", self.recorded))
        self.end(collector)
        if self.check_arrived() == 0:
            self.assertEqual(messages(self.folder / "live.lcm", "POSE"), messages(self.recorded, "POSE"))

    def test_frames_over_a_server_all_arrive(self):
        if not LCM_JAR.exists() or shutil.which("java") is None:
            self.skipTest("LCM's server is not installed (Debian packages liblcm-java, default-jre-headless)")
        self.start("java", "-cp", LCM_JAR, "lcm.lcm.TCPService", 7700)
        url = "tcpq://127.0.0.1:7700"
        for _ in range(600):
            if ":1E14 " in Path("/proc/net/tcp").read_text() + Path("/proc/net/tcp6").read_text():
                break
            time.sleep(0.1)
        collector = self.start_collector(url)
        for _ in range(600):
            if Path("/proc/net/tcp").read_text().count(":1E14 01 ") + Path("/proc/net/tcp").read_text().count(":1E14 ") > 1:
                break
            time.sleep(0.1)
        time.sleep(1)
        self.end(self.start("lcm-logplayer", "-l", url, self.recorded))
        self.end(collector)
        self.assertEqual(self.check_arrived(), 0)
        self.assertEqual(messages(self.folder / "live.lcm", "POSE"), messages(self.recorded, "POSE"))

    def test_a_log_played_as_a_network_is_the_mission(self):
        self.end(self.start_collector(f"file://{self.recorded}?speed=0"))
        self.assertEqual((self.folder / "live.lcm").read_bytes(), self.recorded.read_bytes())

    def test_results_are_published_while_they_are_logged(self):
        heard, log = self.folder / "heard.lcm", self.folder / "mission.lcm"
        logger = self.start("lcm-logger", "--force", heard)
        self.assertTrue(private_network.wait_for_listeners(1, logger), "lcm-logger does not listen")
        report = self.folder / "report.json"
        text = self.run_well("collect", "--input", f"tum:{WORK / 'wheels'}", "--log", log, "--record-raw", "--publish",
                             "--report", report)
        self.assertIn("published ", text)
        # The log is not touched by who listens.
        self.run_well("collect", "--input", f"tum:{WORK / 'wheels'}", "--log", self.folder / "alone.lcm", "--record-raw")
        self.assertEqual(log.read_bytes(), (self.folder / "alone.lcm").read_bytes())
        self.check_heard(logger, heard, log, json.loads(report.read_text())["publishing"])
        self.check_log_is_played(log)

    def check_heard(self, logger, heard, log, published):
        time.sleep(0.5)
        logger.send_signal(signal.SIGINT)
        self.end(logger)
        self.assertEqual(published["dropped"], 0)
        self.assertEqual(published["refused"], 0)
        lost = published["messages"] - len(list(events(heard)))
        self.assertGreaterEqual(lost, 0)
        self.assertLess(lost, published["messages"] / 2)
        self.assertFalse({"RGBD", "MOTION"} & {name for name, _ in events(heard)}, "input comes back")
        for channel in SMALL_RESULTS:
            self.assertLessEqual(set(messages(heard, channel)), set(messages(log, channel)), channel)
        if lost == 0:
            for channel in SMALL_RESULTS:
                self.assertEqual(messages(heard, channel), messages(log, channel), channel)
            self.assertEqual(sum(map(triangles, messages(heard, "SLICE"))), sum(map(triangles, messages(log, "SLICE"))))
            self.assertEqual(list(map(frame_of, messages(heard, "BODY_POSE"))), list(map(frame_of, messages(log, "POSE"))))
        self.assertEqual(messages(log, "BODY_POSE"), [])
        for slice_part in messages(heard, "SLICE"):
            self.assertLess(len(slice_part), 60_000)

    def check_log_is_played(self, log):
        again = self.folder / "again.lcm"
        logger = self.start("lcm-logger", "--force", again)
        self.assertTrue(private_network.wait_for_listeners(1, logger))
        self.end(self.start("lcm-logplayer", log))
        time.sleep(0.5)
        logger.send_signal(signal.SIGINT)
        self.end(logger)
        played = messages(again, "POSE")
        self.assertGreater(len(played), 0)
        self.assertLessEqual(set(played), set(messages(log, "POSE")))

    def test_a_collector_that_hears_nothing_ends_when_told(self):
        log = self.folder / "live.lcm"
        for more, code in ((["--idle-timeout", "0"], 0), (["--idle-timeout", "0.5"], 1)):
            collector = self.start(*command("collect", "--input", "lcm:", "--calibration", "synthetic", "--log", log, *more))
            self.assertTrue(private_network.wait_for_listeners(1, collector))
            if code == 0:
                time.sleep(0.5)
                collector.send_signal(signal.SIGTERM)
            output, _ = collector.communicate(timeout=60)
            self.assertEqual(collector.returncode, code, output)
            self.assertFalse(log.exists(), "an empty log is removed")

    def test_without_a_network_it_is_one_clear_error(self):
        os.environ.pop("LCM_DEFAULT_URL", None)
        self.run_badly("collect", "--input", "lcm:tcpq://127.0.0.1:1", "--log", self.folder / "a.lcm", naming=["tcpq://127.0.0.1:1"])


if __name__ == "__main__":
    private_network.enter()
    unittest.main()
