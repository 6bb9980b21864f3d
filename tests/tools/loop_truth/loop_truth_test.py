#!/usr/bin/env python3
# Rings of tools/loop_truth, from made-up closures, odometry and truth.
# SPDX-License-Identifier: BSD-3-Clause
import math
import sys
import unittest
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path

TOOL = Path(__file__).resolve().parents[3] / "tools" / "loop_truth"
sys.dont_write_bytecode = True
sys.path.insert(0, str(TOOL.parent))
loop_truth = module_from_spec(spec_from_loader("loop_truth", SourceFileLoader("loop_truth", str(TOOL))))
loop_truth.__loader__.exec_module(loop_truth)
from mission_files import Rigid, rotation_of  # noqa: E402  (found through the path above)


def pose(i, offset_m=0.0):
    half = math.radians(3 * i) / 2
    return Rigid(rotation_of(0, math.sin(half), 0, math.cos(half)), (0.01 * i + offset_m, 0.02 * i, 0.0))


ODOMETRY = [pose(i) for i in range(200)]


def closure(a, b, poses):
    return a, b, poses[a].inverse() @ poses[b]


class RingsTest(unittest.TestCase):
    def test_what_is_exact_leads_back(self):
        (ring,) = loop_truth.rings([closure(5, 150, ODOMETRY), closure(9, 160, ODOMETRY)], ODOMETRY, ODOMETRY, 20)
        self.assertEqual((5, 150, 9, 160), ring[:4])
        for miss in ring[4:]:
            self.assertLess(max(miss), 1e-4)

    def test_an_error_counts_where_it_is(self):
        truth = list(ODOMETRY)
        truth[160] = pose(160, 0.03)
        (ring,) = loop_truth.rings([closure(5, 150, ODOMETRY), closure(9, 160, ODOMETRY)], ODOMETRY, truth, 20)
        self.assertLess(ring[4][0], 1e-4)
        self.assertAlmostEqual(30, ring[5][0], 6)
        (ring,) = loop_truth.rings([closure(5, 150, ODOMETRY), closure(9, 160, truth)], ODOMETRY, ODOMETRY, 20)
        self.assertAlmostEqual(30, ring[4][0], 6)

    def test_ends_too_far_apart_make_no_ring(self):
        self.assertEqual([], loop_truth.rings([closure(5, 150, ODOMETRY), closure(26, 160, ODOMETRY)], ODOMETRY, ODOMETRY, 20))

    def test_frames_without_truth_are_left_out(self):
        truth = list(ODOMETRY)
        truth[9] = None
        self.assertEqual([], loop_truth.rings([closure(5, 150, ODOMETRY), closure(9, 160, ODOMETRY)], ODOMETRY, truth, 20))


if __name__ == "__main__":
    unittest.main()
