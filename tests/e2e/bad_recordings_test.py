#!/usr/bin/env python3
# Damaged recordings: one clear error, or the frame is skipped and counted and the mission goes on.
# SPDX-License-Identifier: BSD-3-Clause
import re
import struct
import unittest
import zlib

from programs import MISSIONS, WORK, ProgramTest

FRAMES = int(MISSIONS["small"][2])
WIDTH, HEIGHT = 320, 240


def images(folder, kind):
    """Paths of the images of a TUM folder in the order of its list."""
    lines = (folder / f"{kind}.txt").read_text().splitlines()
    return [folder / line.split()[1] for line in lines if not line.startswith("#")]


def png16(width, height, value):
    """A grey 16-bit PNG of one value."""
    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
    row = b"\0" + struct.pack(">H", value) * width
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(row * height)) + chunk(b"IEND", b""))


class BadRecordingsTest(ProgramTest):
    def assert_skipped(self, folder, count):
        """The mission runs through without `count` of its frames and says so; the log can be mapped."""
        log, report = self.collect(f"tum:{folder}")
        self.assertEqual(report["frames"], FRAMES - count)
        self.assertEqual(report["frames_skipped"], count)
        self.map(log)
        return report

    def test_truncated_images(self):
        small = self.copy_of("small")
        for image in (images(small, "depth")[7], images(small, "rgb")[11]):
            image.write_bytes(image.read_bytes()[: image.stat().st_size // 2])
        self.assert_skipped(small, 2)

    def test_missing_images(self):
        small = self.copy_of("small")
        images(small, "depth")[5].unlink()
        self.assert_skipped(small, 1)

    def test_garbage_for_an_image(self):
        small = self.copy_of("small")
        images(small, "depth")[5].write_bytes(b"no picture at all" * 50)
        images(small, "depth")[6].write_bytes(b"")
        self.assert_skipped(small, 2)

    def test_wrong_image_size(self):
        small = self.copy_of("small")
        images(small, "depth")[9].write_bytes(png16(WIDTH // 2, HEIGHT, 5000))
        self.assert_skipped(small, 1)

    def test_time_going_backwards(self):
        small = self.copy_of("small")
        lists = {kind: (small / f"{kind}.txt").read_text().splitlines() for kind in ("depth", "rgb")}
        for kind, lines in lists.items():
            first = next(i for i, line in enumerate(lines) if not line.startswith("#"))
            frame = lines[first + 12]
            lines[first + 12] = re.sub(r"^\S+", lines[first + 3].split()[0], frame)
            (small / f"{kind}.txt").write_text("\n".join(lines) + "\n")
        log, report = self.collect(f"tum:{small}")
        self.assertEqual(report["frames"], FRAMES - 1)
        self.assertEqual(report["frames_skipped"], 1)
        stamps = [float(line.split()[0]) for line in (self.map(log) / "trajectory.txt").read_text().splitlines()
                  if not line.startswith("#")]
        self.assertEqual(stamps, sorted(set(stamps)))

    def test_depth_that_is_zero_for_a_while(self):
        small = self.copy_of("small")
        for image in images(small, "depth")[8:12]:
            image.write_bytes(png16(WIDTH, HEIGHT, 0))
        report = self.assert_skipped(small, 4)
        self.assertEqual(report["tracked_share"], 1)  # of the frames that show anything

    def test_depth_that_is_always_zero(self):
        small = self.copy_of("small")
        for image in images(small, "depth"):
            image.write_bytes(png16(WIDTH, HEIGHT, 0))
        log = self.folder / "mission.lcm"
        self.run_badly("collect", "--input", f"tum:{small}", "--log", log, naming=["no usable frame", "no valid depth"])

    def test_absurd_calibration(self):
        text = (WORK / "small" / "calibration.yaml").read_text()
        calibration = self.folder / "calibration.yaml"
        for change in (("fx: .*", "fx: -480"), ("fx: .*", "fx: .nan"), ("fy: .*", "fy: 1e9"), ("cx: .*", "cx: hello"),
                       ("width: .*", "width: 0"), ("depth_unit_m: .*", "depth_unit_m: 0")):
            with self.subTest(change=change[1]):
                changed = re.sub(*change, text, count=1)
                self.assertNotEqual(changed, text)
                calibration.write_text(changed)
                self.run_badly("collect", "--input", f"tum:{WORK / 'small'}", "--log", self.folder / "x.lcm",
                               "--calibration", calibration, naming=["calibration.yaml"])

    def test_sources_that_do_not_exist(self):
        log = self.folder / "x.lcm"
        for source in ("tum:/no/such/folder", "7scenes:/no/such/folder", "icl:/no/such/folder", "lcm-log:/no/such.lcm",
                       "synthetic:nowhere", "webcam:0", "tum"):
            with self.subTest(source=source):
                self.run_badly("collect", "--input", source, "--log", log, naming=[source.split(":")[-1]])
        empty = self.folder / "empty"
        empty.mkdir()
        self.run_badly("collect", "--input", f"tum:{empty}", "--log", log, naming=[empty])

    def test_unknown_configuration(self):
        config = self.folder / "config.yaml"
        for text in ("no_such_option: 3\n", "[1, 2\n"):
            with self.subTest(text=text):
                config.write_text(text)
                self.run_badly("collect", "--input", f"tum:{WORK / 'small'}", "--log", self.folder / "x.lcm", "--config",
                               config, naming=["config.yaml"])


if __name__ == "__main__":
    unittest.main()
