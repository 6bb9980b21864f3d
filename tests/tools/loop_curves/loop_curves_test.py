#!/usr/bin/env python3
# What tools/loop_curves counts and draws, from made-up pairs.
# SPDX-License-Identifier: BSD-3-Clause
import sys
import unittest
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path

TOOL = Path(__file__).resolve().parents[3] / "tools" / "loop_curves"
sys.dont_write_bytecode = True
sys.path.insert(0, str(TOOL.parent))
curves = module_from_spec(spec_from_loader("loop_curves", SourceFileLoader("loop_curves", str(TOOL))))
curves.__loader__.exec_module(curves)


def pair(disturbance, level, verdict="accepted", kind="synthetic", overlap=0.6, degrees=7.0, error_m=0.001):
    return {"disturbance": disturbance, "level": level, "verdict": verdict, "kind": kind, "feature": "surf",
            "truth": {"overlap": overlap, "viewpoint_deg": degrees, "error_m": error_m, "error_deg": 0.1}}


class CountTest(unittest.TestCase):
    def test_undisturbed_pairs_go_into_bins_of_their_angle(self):
        counts = curves.count([pair("none", 1, degrees=angle) for angle in (0.0, 4.9, 5.0)])
        self.assertEqual({2.5: 2, 7.5: 1}, {level: cell[0] for level, cell in counts["pairs", "surf", "synthetic"].items()})

    def test_an_orbit_is_not_asked_where_the_views_hardly_overlap(self):
        self.assertEqual({}, curves.count([pair("viewpoint", 60, overlap=0.39)]))
        self.assertEqual(1, curves.count([pair("viewpoint", 60, overlap=0.41)])["viewpoint", "surf", "synthetic"][60][0])

    def test_shares_and_wrong_ones(self):
        rows = [pair("blur", 2), pair("blur", 2, verdict="too few matches"), pair("blur", 2, error_m=0.06),
                pair("blur", 2, kind="recorded", error_m=0.06)]
        counts = curves.count(rows)
        self.assertEqual([3, 2, 1], counts["blur", "surf", "synthetic"][2][:3])
        self.assertEqual([1, 1, 0], counts["blur", "surf", "recorded"][2][:3])
        self.assertIn("| 2 | 100 (1) | 67 (3), 1 wrong |", curves.document(counts))

    def test_the_picture_leaves_out_what_few_pairs_say(self):
        script = curves.gnuplot_script(curves.count([pair("gain", 2)] * 8 + [pair("gain", 4)] * 7), Path("curves.png"))
        self.assertIn("$gain_surf_synthetic << EOD\n2 100.0\nEOD", script)


if __name__ == "__main__":
    unittest.main()
