#!/usr/bin/env python3
# The paths and graphs that tools/graph_trials makes.
# SPDX-License-Identifier: BSD-3-Clause
import math
import sys
import tempfile
import unittest
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path

TOOL = Path(__file__).resolve().parents[3] / "tools" / "graph_trials"
sys.dont_write_bytecode = True
sys.path.insert(0, str(TOOL.parent))
trials = module_from_spec(spec_from_loader("graph_trials", SourceFileLoader("graph_trials", str(TOOL))))
sys.modules["graph_trials"] = trials  # where dataclasses look for its names
trials.__loader__.exec_module(trials)

CASE = trials.Case(frames=300, loops=20)
TRUTH = trials.true_path(CASE.frames)


def error(edge):
    """(rad, m) of an edge's measurement."""
    i, j, T, _, _ = edge
    E = (TRUTH[i].inverse() @ TRUTH[j]).inverse() @ T
    return E.angle(), math.dist(E.translation, (0, 0, 0))


class MadePaths(unittest.TestCase):
    def test_edges_err_as_their_sigmas_say(self):
        edges = trials.edges(CASE, TRUTH, 1)
        odometry, loops = edges[:299], edges[299:]
        self.assertEqual([(i, i + 1) for i in range(299)], [edge[:2] for edge in odometry])
        self.assertEqual(20, len(loops))
        for edges, (rad, m) in ((odometry, trials.ODOMETRY_SIGMAS), (loops, trials.LOOP_SIGMAS)):
            for index, sigma in enumerate((rad, m)):
                rms = math.sqrt(sum(error(edge)[index] ** 2 for edge in edges) / len(edges))
                self.assertTrue(0.75 < rms / (sigma * math.sqrt(3)) < 1.25, rms)

    def test_loops_join_rounds(self):
        for i, j, *_ in trials.edges(CASE, TRUTH, 2)[299:]:
            self.assertLess(math.dist(TRUTH[i].translation[:2], TRUTH[j].translation[:2]), 1.5)

    def test_a_bias_turns_every_frame(self):
        biased = trials.edges(trials.Case(frames=300, loops=0, bias=(0.1, 0)), TRUTH, 1)
        for plain, turned in zip(trials.edges(trials.Case(frames=300, loops=0), TRUTH, 1), biased):
            self.assertAlmostEqual(0.1, (plain[2].inverse() @ turned[2]).angle(), 3)

    def test_a_seed_is_a_path(self):
        self.assertEqual(trials.edges(CASE, TRUTH, 1), trials.edges(CASE, TRUTH, 1))
        self.assertNotEqual(trials.edges(CASE, TRUTH, 1), trials.edges(CASE, TRUTH, 2))

    def test_the_file_has_what_odometry_leads_to_and_says_what_the_case_does(self):
        case = trials.Case(frames=300, loops=20, loops_say=10)
        edges = trials.edges(case, TRUTH, 3)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "made.g2o"
            trials.write_graph(file, edges)
            lines = [line.split() for line in file.read_text().splitlines()]
        self.assertEqual(300, sum(line[0].startswith("VERTEX") for line in lines))
        T = edges[0][2] @ edges[1][2]
        for expected, field in zip(T.translation, lines[2][2:5]):
            self.assertAlmostEqual(expected, float(field), 9)
        loop = [float(field) for field in lines[-1][10:]]
        self.assertEqual(21, len(loop))
        self.assertAlmostEqual(10 / 0.01**2, loop[0], 6)
        self.assertAlmostEqual(10 * 4 / 0.005**2, loop[-1], 6)


if __name__ == "__main__":
    unittest.main()
