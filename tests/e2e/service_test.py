#!/usr/bin/env python3
# The collector as a service: what systemd hears of it, --check, its unit, and kintsugi-log watch.
# SPDX-License-Identifier: BSD-3-Clause
import fcntl
import os
import pty
import queue
import shutil
import signal
import socket
import struct
import subprocess
import termios
import threading
import unittest

from programs import BIN, WORK, ProgramTest, command, run

SMALL = ["--set", "volume.resolution=128", "--set", "volume.voxel_size_m=0.04"]


class ServiceTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.socket.close)
        self.socket.bind(str(self.folder / "notify"))
        self.words = queue.Queue()
        threading.Thread(target=self.listen, daemon=True).start()

    def listen(self):
        try:
            while word := self.socket.recv(4096).decode():
                self.words.put(word)
        except OSError:  # closed at the end of the test
            pass

    def start(self, *arguments, watchdog_s=0.4):
        """kintsugi-collect as systemd starts it."""
        environment = {**os.environ, "NOTIFY_SOCKET": str(self.folder / "notify"), "WATCHDOG_USEC": str(int(watchdog_s * 1e6))}
        process = subprocess.Popen(command("collect", *arguments, *SMALL), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                   text=True, env=environment)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def hear(self, seconds=120):
        """The next word of the service; None where none comes."""
        try:
            return self.words.get(timeout=seconds)
        except queue.Empty:
            return None

    def hear_rest(self):
        """What a service that has ended said last."""
        words = []
        while (word := self.hear(0.5)) is not None:
            words.append(word)
        return words

    def end(self, process):
        output, _ = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 0, output)

    def test_a_mission_is_ready_then_alive_then_stopping(self):
        self.end(self.start("--quiet", "--input", f"tum:{WORK / 'small'}", "--log", self.folder / "m.lcm"))
        words = self.hear_rest()
        kinds = [word for word in words if not word.startswith("STATUS=")]
        self.assertEqual(kinds[:2], ["READY=1", "WATCHDOG=1"], words)
        self.assertEqual(kinds[-1], "STOPPING=1", words)
        self.assertEqual(kinds.count("READY=1"), 1)
        self.assertTrue(any(word.startswith("STATUS=frame ") for word in words), words)

    def test_a_missing_camera_is_alive(self):
        process = self.start("--quiet", "--input", "lcm:memq://", "--calibration", "tum-fr1", "--log", self.folder / "m.lcm")
        words = [self.hear() for _ in range(8)]
        self.assertEqual([word for word in words if not word.startswith("STATUS=")][:1], ["READY=1"])
        self.assertGreater(words.count("WATCHDOG=1"), 4)
        process.send_signal(signal.SIGTERM)
        self.end(process)
        self.assertIn("STOPPING=1", self.hear_rest())

    def test_a_hung_disk_is_not_alive(self):
        log = self.folder / "m.lcm"
        os.mkfifo(log)
        reader = os.open(log, os.O_RDONLY | os.O_NONBLOCK)
        process = self.start("--quiet", "--input", f"tum:{WORK / 'room'}", "--log", log, "--record-raw")
        words = []
        while (word := self.hear(2)) is not None or "READY=1" not in words:
            words.append(word)
            self.assertIsNone(process.poll(), words)
        self.assertNotIn("STOPPING=1", words)
        # The disk answers again, and the mission goes on to its end.
        os.set_blocking(reader, True)
        while os.read(reader, 1 << 20):
            pass
        os.close(reader)
        self.end(process)
        self.assertIn("STOPPING=1", self.hear_rest())

    def test_an_input_that_is_not_there_is_never_ready(self):
        process = self.start("--quiet", "--input", "tum:/no/such/folder", "--log", self.folder / "m.lcm")
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1)
        self.assertNotIn("READY=1", self.hear_rest())

    @unittest.skipUnless(shutil.which("systemd-analyze"), "no systemd-analyze")
    def test_unit_is_sound(self):
        target = self.folder / "installed"
        subprocess.run(["cmake", "--install", BIN.parent, "--component", "onboard", "--prefix", target], check=True,
                       stdout=subprocess.DEVNULL)
        unit = target / "lib/systemd/system/kintsugi-collector.service"
        self.assertIn(f"ExecStart={target}/bin/kintsugi-collect --quiet --config {target}/etc/kintsugi/collector.yaml\n",
                      unit.read_text())
        result = subprocess.run(["systemd-analyze", "verify", "--man=no", unit], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                text=True, check=False)
        complaints = [line for line in result.stdout.splitlines() if "kintsugi" in line]
        self.assertEqual((result.returncode, complaints), (0, []), result.stdout)

    def test_installing_keeps_a_changed_configuration(self):
        target = self.folder / "installed"
        for _ in range(2):
            subprocess.run(["cmake", "--install", BIN.parent, "--component", "onboard", "--prefix", target], check=True,
                           stdout=subprocess.DEVNULL)
            config = target / "etc/kintsugi/collector.yaml"
            config.write_text("mission:\n  input: mine\n")
        self.assertIn("input: mine", config.read_text())


class ConfigurationTest(ProgramTest):
    def test_file_and_command_line_make_one_mission(self):
        config = self.folder / "collector.yaml"
        config.write_text(f"mission:\n  input: tum:{WORK / 'small'}\n  log: {self.folder}/m-%Y%m%d.lcm\n  threads: 7\n"
                          f"  report: {self.folder}/r.json\nvolume:\n  resolution: 128\n  voxel_size_m: 0.04\n")
        for _ in range(2):
            self.run_well("collect", "--config", config, "--threads", "1", "--quiet")
        logs = sorted(path.name for path in self.folder.glob("*.lcm"))
        self.assertEqual(len(logs), 2)
        self.assertRegex(logs[0], r"^m-\d{8}-2\.lcm$|^m-\d{8}\.lcm$")
        self.assertEqual((self.folder / logs[0]).read_bytes(), (self.folder / logs[1]).read_bytes())
        self.assertIn('"threads": 1', (self.folder / "r.json").read_text())

    def test_errors_name_line_and_key(self):
        config = self.folder / "collector.yaml"
        config.write_text("mission:\n  input: tum:x\n  trheads: 7\n")
        self.run_badly("collect", "--config", config, naming=[f"{config}:3", "mission.trheads"])

    def test_print_config_is_a_configuration(self):
        config = self.folder / "collector.yaml"
        text = self.run_well("collect", "--print-config", "--no-overwrite", "--publish", "--raw-colour", "png")
        self.assertIn('publish: "default"', text)
        config.write_text(text)
        self.assertEqual(self.run_well("collect", "--print-config", "--config", config), text)
        self.assertIn('publish: "off"', self.run_well("collect", "--print-config", "--config", config, "--publish", "off"))


class CheckTest(ProgramTest):
    def test_a_sound_setup(self):
        text = self.run_well("collect", "--check", "--input", f"tum:{WORK / 'small'}", "--log", self.folder / "m.lcm",
                             "--record-raw", "--publish", "memq://", *SMALL)
        lines = text.splitlines()
        self.assertEqual([line.split()[1] for line in lines], ["configuration", "camera", "processor", "disk", "network"], text)
        self.assertNotIn("FAIL", text)
        self.assertTrue(lines[1].startswith("ok "), text)
        self.assertIn("320 x 240, 30.0 Hz", lines[1])
        self.assertEqual([path for path in self.folder.iterdir() if path.suffix == ".lcm"], [], "it makes no log")

    def test_every_fault_has_its_line(self):
        result = run("collect", "--check", "--input", "openni2:no-such-device", "--log", "/no/such/folder/m.lcm")
        self.assertEqual(result.returncode, 1, result.stdout)
        faults = [line.split()[1] for line in result.stdout.splitlines() if line.startswith("FAIL")]
        self.assertEqual(faults, ["camera", "disk"], result.stdout)

    def test_a_camera_that_is_missing_names_itself(self):
        result = run("collect", "--check", "--input", "v4l2:depth=/dev/video99", "--calibration", "tum-fr1", "--log",
                     self.folder / "m.lcm")
        self.assertEqual(result.returncode, 1)
        self.assertRegex(result.stdout, r"FAIL  camera .*/dev/video99")


class WatchTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.log, _ = self.collect(f"tum:{WORK / 'small'}", settings=["volume.resolution=128", "volume.voxel_size_m=0.04"])

    def test_a_log_line_by_line(self):
        lines = self.run_well("log", "watch", self.log, "--seconds", "2.5").splitlines()
        self.assertGreaterEqual(len(lines), 2)
        for part in ("good (", "24 frames", "0 lost", "camera at ", "volume around ", "GB free"):
            self.assertIn(part, lines[0])
        self.assertNotIn("\x1b", "".join(lines))

    def test_a_log_that_grows(self):
        whole, growing = self.log.read_bytes(), self.folder / "growing" / "now.lcm"
        growing.parent.mkdir()
        growing.write_bytes(whole[:3000])
        process = subprocess.Popen(command("log", "watch", growing.parent), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                   text=True)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        self.assertNotIn("24 frames", process.stdout.readline())
        with growing.open("ab") as file:
            file.write(whole[3000:])
        for _ in range(60):
            line = process.stdout.readline()
            if "24 frames" in line:
                break
        self.assertIn("24 frames", line)
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(60), 0)

    def test_on_a_terminal_it_is_redrawn(self):
        terminal, inside = pty.openpty()
        fcntl.ioctl(inside, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 50, 0, 0))
        process = subprocess.Popen(command("log", "watch", self.log, "--seconds", "2"), stdout=inside, stderr=inside)
        os.close(inside)
        output = b""
        try:
            while chunk := os.read(terminal, 4096):
                output += chunk
        except OSError:  # how a terminal ends
            pass
        os.close(terminal)
        self.assertEqual(process.wait(60), 0, output)
        text = output.decode()
        self.assertRegex(text, r"\x1b\[\d+A")
        lines = [line.split("\x1b[K")[0] for line in text.replace("\r", "").split("\n")]
        self.assertTrue(any(line.startswith("tracking     good") for line in lines), text)
        self.assertLessEqual(max(len(line) for line in lines if "\x1b" not in line), 49, text)

    def test_the_bus(self):
        lines = self.run_well("log", "watch", "--lcm", f"file://{self.log}?speed=0", "--seconds", "2.5")
        self.assertIn("24 frames", lines)
        self.assertIn("around", lines, "the session was heard too")

    def test_silence_is_told(self):
        line = self.run_badly("log", "watch", "--lcm", "memq://", "--seconds", "4.5", naming=["memq://", "--publish"])
        self.assertIn("nothing came", line)
        text = run("log", "watch", "--lcm", "memq://", "--seconds", "4.5").stdout
        self.assertIn("listening to memq://", text)
        self.assertRegex(text, r"nothing for \d s from memq://")

    def test_what_is_no_log(self):
        self.run_badly("log", "watch", self.folder / "none.lcm", naming=["none.lcm"])
        self.run_badly("log", "watch", "--lcm", "nonsense://", naming=["nonsense://"])


if __name__ == "__main__":
    unittest.main()
