#!/usr/bin/env python3
# Variants, altered images and verdicts of tools/robustness, from a made-up recording; the e2e tests run the real programs.
# SPDX-License-Identifier: BSD-3-Clause
import math
import random
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib
from dataclasses import replace
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path

TOOL = Path(__file__).resolve().parents[3] / "tools" / "robustness"
sys.dont_write_bytecode = True
sys.path.insert(0, str(TOOL.parent))
robustness = module_from_spec(spec_from_loader("robustness", SourceFileLoader("robustness", str(TOOL))))
sys.modules["robustness"] = robustness
robustness.__loader__.exec_module(robustness)
import mission_files  # noqa: E402  (found through the path above)
from mission_files import Frame, LoggedPose, Recording, Rigid  # noqa: E402

INTERVAL_US = 33333
NOTHING = Rigid(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0))


def turned(degrees, axis, translation):
    half = math.radians(degrees) / 2
    return Rigid(mission_files.rotation_of(*(math.sin(half) * a for a in axis), math.cos(half)), tuple(translation))


def truth_at(i):
    """A camera that goes along x at 1 cm per frame and turns by a degree per frame."""
    return turned(i, (0, 1, 0), (0.01 * i, 0.0, 0.0))


def recording(count=400):
    frames = [Frame(1000000 + i * INTERVAL_US, Path(f"depth/{i}.png"), Path(f"rgb/{i}.png"), truth_at(i), "here")
              for i in range(count)]
    return Recording("made-up", frames)


PICTURES = {kind: [(Path(f"{kind}-depth.png"), Path(f"{kind}-colour.png"))] for kind in ("black", "near", "blind")}
T_ODOM_WORLD = turned(40, (0.6, 0.0, 0.8), (3.0, -2.0, 1.0))


def logged(frame, T_world_camera=None, segment=0, is_good=True, source=2):
    return LoggedPose(frame.stamp_us, T_ODOM_WORLD @ (T_world_camera or frame.truth), segment, is_good, source, 0)


class RigidTest(unittest.TestCase):
    def test_quaternions_and_matrices_agree(self):
        rng = random.Random(1)
        axes = [(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)]
        for q in axes + [tuple(rng.gauss(0, 1) for _ in range(4)) for _ in range(200)]:
            again = mission_files.quaternion_of(mission_files.rotation_of(*q))
            cosine = sum(a * b for a, b in zip(q, again)) / math.dist(q, (0, 0, 0, 0))
            self.assertAlmostEqual(abs(cosine), 1, 12)

    def test_inverse_and_angle(self):
        pose = turned(150, (0, 0.6, 0.8), (1, 2, 3))
        product = pose @ pose.inverse()
        self.assertAlmostEqual(math.dist(product.translation, (0, 0, 0)), 0, 12)
        self.assertAlmostEqual(product.angle(), 0, 12)
        self.assertAlmostEqual(math.degrees(pose.angle()), 150, 9)
        self.assertEqual(turned(90, (0, 0, 1), (5, 0, 0)).apply((1, 0, 0))[1], 1)


class VariantsTest(unittest.TestCase):
    def setUp(self):
        self.recording = recording()
        variants = robustness.variants_of(self.recording, self.recording.frames, PICTURES)
        self.variants = {variant.name: variant for variant in variants}

    def test_all_are_made_and_their_stamps_increase(self):
        self.assertEqual(list(self.variants), ["unharmed", "gap-10", "gap-20", "gap-30", "blackout", "cover-near", "cover-blind",
                                               "kidnap-known", "kidnap-unknown", "stop-and-go", "low-rate", "reversed"])
        for variant in self.variants.values():
            stamps = [frame.stamp_us for frame in variant.frames]
            self.assertTrue(all(a < b for a, b in zip(stamps, stamps[1:])), variant.name)
            self.assertTrue(variant.returns and all(0 <= i < len(stamps) for i in variant.returns), variant.name)

    def test_gaps_leave_the_stamps_alone(self):
        gap = self.variants["gap-20"]
        self.assertEqual(len(gap.frames), 340)
        for i in gap.returns:
            self.assertEqual(gap.frames[i].stamp_us - gap.frames[i - 1].stamp_us, 21 * INTERVAL_US)

    def test_altered_frames_last_as_long_as_they_should(self):
        for name, seconds in (("blackout", 1), ("cover-near", 3), ("cover-blind", 3)):
            damaged = [i for i, frame in enumerate(self.variants[name].frames) if frame.is_damaged]
            self.assertAlmostEqual(len(damaged), 30 * seconds, delta=1)
            self.assertEqual(damaged, list(range(200, self.variants[name].returns[0])))
        self.assertEqual(self.variants["blackout"].frames[200].depth, Path("black-depth.png"))
        self.assertEqual(self.variants["cover-near"].frames[200].colour, Path("near-colour.png"))

    def test_a_recording_too_short_has_fewer(self):
        short = recording(100)
        names = [variant.name for variant in robustness.variants_of(short, short.frames, PICTURES)]
        self.assertNotIn("cover-near", names)
        self.assertNotIn("gap-20", names)
        self.assertIn("blackout", names)

    def test_kidnapped_to_where_it_was_or_was_not(self):
        for name, was_seen in (("kidnap-known", True), ("kidnap-unknown", False)):
            variant = self.variants[name]
            at = variant.returns[0]
            self.assertEqual([i for i, frame in enumerate(variant.frames) if frame.is_jump], [at])
            before = {frame.depth for frame in variant.frames[:at]}
            self.assertEqual(variant.frames[at].depth in before, was_seen, name)
            self.assertEqual(variant.frames[at].stamp_us - variant.frames[at - 1].stamp_us, INTERVAL_US)

    def test_kidnapped_elsewhere(self):
        there = [replace(frame, world="there") for frame in recording().frames]
        variant = robustness.kidnap_unknown(self.recording.frames, INTERVAL_US, there)
        self.assertEqual({frame.world for frame in variant.frames[:variant.returns[0]]}, {"here"})
        self.assertEqual({frame.world for frame in variant.frames[variant.returns[0]:]}, {"there"})

    def test_stops_last_a_second(self):
        variant = self.variants["stop-and-go"]
        self.assertEqual(len(variant.frames), 400 + 3 * 30)
        at = variant.returns[0]
        self.assertEqual(len({frame.depth for frame in variant.frames[at - 31:at]}), 1)
        self.assertNotEqual(variant.frames[at].depth, variant.frames[at - 1].depth)

    def test_turns_back_to_the_beginning(self):
        variant = self.variants["reversed"]
        self.assertEqual(variant.frames[-1].depth, Path("depth/0.png"))
        self.assertEqual(variant.frames[variant.returns[0]].depth, variant.frames[variant.returns[0] - 2].depth)


class FilesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def test_a_folder_that_is_written_reads_the_same(self):
        source = self.folder / "with space" / "source"
        (source / "depth").mkdir(parents=True)
        (source / "depth" / "a.png").touch()
        frame = Frame(1305031102175304, source / "depth" / "a.png", None)
        for _ in range(2):  # a second run replaces the first one's
            mission_files.write_tum(self.folder / "made", [frame], "depth_unit_m: 0.0005\n")
        again = mission_files.read_recording(self.folder / "made")
        self.assertEqual(again.frames[0].stamp_us, frame.stamp_us)
        self.assertEqual(again.frames[0].depth.resolve(), frame.depth.resolve())
        self.assertEqual(again.depth_unit_m, 0.0005)

    def test_reads_both_layouts(self):
        tum = self.folder / "rgbd_dataset_freiburg2_desk"
        tum.mkdir()
        (tum / "depth.txt").write_text("# comment\n1.000000 depth/1.png\n2.000000 depth/2.png\n")
        (tum / "rgb.txt").write_text("1.015000 rgb/1.png\n2.030000 rgb/2.png\n")
        (tum / "groundtruth.txt").write_text("1.001 1 2 3 0 0 0 1\n1.5 0 0 0 0 0 0 1\n")
        found = mission_files.read_recording(tum)
        self.assertEqual(found.camera, "tum-fr2")
        self.assertEqual([frame.colour for frame in found.frames], [tum.resolve() / "rgb/1.png", None])
        self.assertEqual(found.frames[0].truth, replace(NOTHING, translation=(1.0, 2.0, 3.0)))
        self.assertIsNone(found.frames[1].truth)
        scenes = self.folder / "scenes"
        scenes.mkdir()
        for name in ("frame-000030.depth.png", "frame-000030.color.jpg"):
            (scenes / name).touch()
        (scenes / "frame-000030.pose.txt").write_text("1 0 0 4\n0 1 0 5\n0 0 1 6\n0 0 0 1\n")
        found = mission_files.read_recording(scenes)
        self.assertEqual((found.camera, found.depth_unit_m), ("7scenes", 0.001))
        self.assertEqual(found.frames[0].stamp_us, 2000000)
        self.assertEqual(found.frames[0].colour.name, "frame-000030.color.jpg")
        self.assertEqual(found.frames[0].truth.translation, (4, 5, 6))
        with self.assertRaisesRegex(ValueError, "no TUM RGB-D or 7-Scenes recording"):
            mission_files.read_recording(self.folder)

    def test_images_as_large_as_the_recordings_own(self):
        depth, colour = self.folder / "depth.png", self.folder / "colour.jpg"
        mission_files.write_png(depth, 40, 30, bytes(2400), 16, 1)
        # Start of image, a comment, the frame header of a baseline JPEG of 50 x 20.
        colour.write_bytes(b"\xff\xd8" + b"\xff\xfe\x00\x04hi" + b"\xff\xc0\x00\x11\x08\x00\x14\x00\x32\x03" + bytes(9))
        self.assertEqual(mission_files.image_size(colour), (50, 20))
        made = recording(3)
        made.frames[0] = replace(made.frames[0], depth=depth, colour=colour)
        pictures = robustness.make_pictures(self.folder / "altered", made)
        for kind, least_m, most_m, share in (("black", 0, 0, 0), ("near", 0.3, 0.5, 1), ("blind", 0.3, 4, 0.02)):
            for depth, colour in pictures[kind]:
                self.assertEqual(mission_files.image_size(depth), (40, 30))
                self.assertEqual(mission_files.image_size(colour), (50, 20))
                samples = [sample * made.depth_unit_m for sample in self.samples(depth, 40, 30)]
                measured = [sample for sample in samples if sample > 0]
                self.assertAlmostEqual(len(measured), share * len(samples), delta=1)
                self.assertTrue(all(least_m <= sample <= most_m for sample in measured), kind)

    def samples(self, path, width, height):
        """The depth of a PNG as write_png makes them."""
        content = path.read_bytes()
        self.assertTrue(content.startswith(b"\x89PNG\r\n\x1a\n"))
        size = struct.unpack_from(">I", content, 33)[0]
        self.assertEqual(struct.unpack_from(">I", content, 41 + size)[0], zlib.crc32(content[37:41 + size]))
        rows = zlib.decompress(content[41:41 + size])
        self.assertEqual(len(rows), height * (1 + 2 * width))
        return [value for v in range(height) for value in struct.unpack_from(f">x{width}H", rows, v * (1 + 2 * width))]

    def test_poses_of_a_log(self):
        def event(number, channel, content):
            return struct.pack(">IqqII", 0xEDA1DA01, number, 0, len(channel), len(content)) + channel + content

        def encoded(sequence, stamp_us, *last):
            matrix = [1, 0, 0, 4, 0, 1, 0, 5, 0, 0, 1, 6]
            return struct.pack(">QqqiQ12dq21d4dibbbb", 1, sequence, stamp_us, 0, 7, *matrix, 6, *[0] * 25, 3, *last)

        pose, lost = encoded(0, 123456, 0, 0, 5, 0), encoded(1, 156789, 6, 2, 0, 1)
        log = self.folder / "mission.lcm"
        log.write_bytes(event(0, b"KINTSUGI_SESSION", b"x" * 50) + event(1, b"KINTSUGI_POSE", pose) +
                        event(2, b"KINTSUGI_POSE", lost))
        first, second = mission_files.read_poses(log)
        self.assertEqual(first, LoggedPose(123456, replace(NOTHING, translation=(4, 5, 6)), 3, True, 5, 0))
        self.assertEqual((second.is_good, second.source, second.cause), (False, 0, 1))
        log.write_bytes(event(0, b"KINTSUGI_POSE", pose[:-1]))
        with self.assertRaisesRegex(ValueError, "another version"):
            mission_files.read_poses(log)


class VerdictTest(unittest.TestCase):
    def setUp(self):
        self.frames = recording().frames
        self.variant = robustness.Variant("gap", self.frames, [100, 200])

    def test_of_the_truth_itself(self):
        verdict = robustness.judge(self.variant, [logged(frame) for frame in self.frames])
        self.assertEqual((verdict.frames, verdict.counted, verdict.counted_good, verdict.segments), (400, 300, 300, 1))
        self.assertEqual(verdict.recoveries, [(0, "model"), (0, "model")])
        self.assertLess(verdict.largest_error_m, 1e-9)
        self.assertEqual(verdict.wrong, [])

    def test_counts_frames_until_good(self):
        poses = [logged(frame, is_good=not 100 <= i < 112 and i < 200, source=3 if i == 112 else 2)
                 for i, frame in enumerate(self.frames)]
        verdict = robustness.judge(self.variant, poses)
        self.assertEqual(verdict.recoveries, [(12, "features"), (None, None)])
        self.assertEqual(verdict.counted_good, 88)

    def test_damaged_frames_and_frames_without_pose_are_not_good_ones(self):
        frames = [replace(frame, is_damaged=180 <= i < 200) for i, frame in enumerate(self.frames)]
        poses = [logged(frame) for i, frame in enumerate(frames) if i < 250]
        verdict = robustness.judge(robustness.Variant("cover", frames, [180]), poses)
        self.assertEqual((verdict.counted, verdict.counted_good), (200, 50))

    def test_a_good_pose_beyond_the_bound_is_wrong(self):
        def verdict_of(i, **changes):
            return robustness.judge(self.variant, [logged(frame, **(changes if k == i else {}))
                                                   for k, frame in enumerate(self.frames)])

        truth = truth_at(300)  # 3 m on its way: 11 cm are allowed
        near = replace(truth, translation=(truth.translation[0], 0.10, 0))
        far = replace(truth, translation=(truth.translation[0], 0.12, 0))
        self.assertEqual(verdict_of(300, T_world_camera=near).wrong, [])
        self.assertAlmostEqual(verdict_of(300, T_world_camera=near).largest_error_m, 0.10)
        self.assertEqual(verdict_of(300, T_world_camera=far).wrong, [self.frames[300].stamp_us])
        self.assertEqual(verdict_of(300, T_world_camera=far, is_good=False).wrong, [])
        turned_far = turned(306, (0, 1, 0), truth.translation)
        self.assertEqual(verdict_of(300, T_world_camera=turned_far).wrong, [self.frames[300].stamp_us])

    def test_what_the_unharmed_recording_is_off_by_is_allowed(self):
        # The truth bends away by 30 cm behind frame 200: of the poses none is to blame.
        bent = [replace(pose, T_odom_camera=T_ODOM_WORLD @ replace(truth, translation=(truth.translation[0], 0.3 * (i > 200), 0)))
                for i, (pose, truth) in enumerate((logged(frame), frame.truth) for frame in self.frames)]
        unharmed = robustness.judge(self.variant, bent)
        self.assertEqual(len(unharmed.wrong), 199)
        self.assertEqual(robustness.judge(self.variant, bent, unharmed.errors).wrong, [])
        truth = truth_at(350)
        worse = [*bent]
        worse[350] = logged(self.frames[350], replace(truth, translation=(truth.translation[0], 0.5, 0)))
        self.assertEqual(robustness.judge(self.variant, worse, unharmed.errors).wrong, [self.frames[350].stamp_us])

    def test_each_segment_stands_by_itself(self):
        shift = turned(77, (0, 0, 1), (9, 9, 9))
        poses = [logged(frame) if i < 200 else replace(logged(frame, segment=1), T_odom_camera=shift @ frame.truth)
                 for i, frame in enumerate(self.frames)]
        verdict = robustness.judge(self.variant, poses)
        self.assertEqual((verdict.segments, verdict.wrong), (2, []))
        one = robustness.judge(self.variant, [replace(pose, segment=0) for pose in poses])
        self.assertEqual(len(one.wrong), 200)

    def test_a_segment_that_goes_on_elsewhere_is_wrong(self):
        frames = [replace(frame, world="there") if i >= 300 else frame for i, frame in enumerate(self.frames)]
        variant = robustness.Variant("kidnap-unknown", frames, [300])
        self.assertEqual(len(robustness.judge(variant, [logged(frame) for frame in frames]).wrong), 100)
        apart = robustness.judge(variant, [logged(frame, segment=int(frame.world == "there")) for frame in frames])
        self.assertEqual(apart.wrong, [])

    def test_a_carried_camera_went_no_way(self):
        far = replace(self.frames[1], truth=replace(NOTHING, translation=(100, 0, 0)), is_jump=True)
        self.assertEqual(robustness.paths_m([self.frames[0], far])[-1], 0)

    def test_the_page(self):
        verdict = robustness.judge(self.variant, [logged(frame, is_good=i < 200) for i, frame in enumerate(self.frames)])
        page = robustness.document([robustness.row(recording(), self.variant, verdict)])
        self.assertIn("| made-up | gap | 400 | 33.3 | 0, never | model | 1 | 0 | 0 |", page)
        verdict.wrong.append(5)
        self.assertEqual(robustness.row(recording(), self.variant, verdict)[-1], "**1**")


class ProgramTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        source = self.folder / "recording"
        source.mkdir()
        mission_files.write_png(source / "depth.png", 4, 3, bytes(24), 16, 1)
        stamps = [f"{1 + i / 30:.6f}" for i in range(90)]
        (source / "depth.txt").write_text("".join(f"{stamp} depth.png\n" for stamp in stamps))
        (source / "groundtruth.txt").write_text("".join(f"{s} {i / 100} 0 0 0 0 0 1\n" for i, s in enumerate(stamps)))
        (self.folder / "kintsugi-collect").symlink_to("/bin/false")

    def run_tool(self, *arguments):
        return subprocess.run([sys.executable, TOOL, self.folder / "recording", "--bin", self.folder,
                               "--work", self.folder / "work", *arguments], capture_output=True, text=True, check=False)

    def test_programs_that_fail_are_told(self):
        done = self.run_tool("--variants", "reversed", "low-rate")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertEqual(done.stderr.splitlines()[-1],
                         "tools/robustness: recording, unharmed failed; recording, low-rate failed; recording, reversed failed")
        self.assertIn("| recording | variant |", done.stdout)

    def test_wrong_use_is_one_line(self):
        done = self.run_tool("--variants", "fire")
        self.assertEqual(done.returncode, 1)
        self.assertIn("no variant fire", done.stderr.splitlines()[-1])
        self.assertIn("20 frames with ground truth", self.run_tool("--frames", "20").stderr.splitlines()[-1])


if __name__ == "__main__":
    unittest.main()
