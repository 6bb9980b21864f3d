#!/usr/bin/env python3
# Plants one fault of each kind in a small tree and expects tools/check_layers to name exactly that one.
# SPDX-License-Identifier: BSD-3-Clause
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

CHECKER = Path(__file__).resolve().parents[3] / "tools" / "check_layers"
OPENING = "// A file of the test, in one sentence.\n// SPDX-License-Identifier: BSD-3-Clause\n"
SOUND_TREE = {
    "shared/core/check.h": "#include <string>\n",
    "shared/geometry/se3.h": '#include <Eigen/Core>\n\n#include "shared/core/check.h"\n',
    "shared/exec/for_each.cuh": '#include <cuda_runtime.h>\n\n#include "shared/core/check.h"\n',
    "shared/wire/codec.cpp": '#include <kintsugi/pose_t.hpp>\n#include <lcm/lcm-cpp.hpp>\n\n#include "shared/geometry/se3.h"\n',
    "onboard/fusion/fuse_kernel.h": '#include "shared/core/check.h"\n',
    "onboard/app/collector.cpp": '#include "onboard/fusion/fuse_kernel.h"\n#include "shared/wire/codec.h"\n',
    "offboard/pose_graph/solve.cpp": "#include <ceres/ceres.h>\n",
    "tests/onboard/fusion/fuse_test.cpp": '#include "onboard/fusion/fuse_kernel.h"\n',
}


class CheckLayersTest(unittest.TestCase):
    def check(self, changes):
        """Runs the checker on the sound tree with `changes` ({path: whole text}) and returns its lines."""
        with tempfile.TemporaryDirectory() as folder:
            tree = {path: OPENING + text for path, text in SOUND_TREE.items()} | changes
            for path, text in tree.items():
                file = Path(folder) / path
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text)
            run = subprocess.run([sys.executable, CHECKER, folder], capture_output=True, text=True, check=False)
        lines = run.stdout.splitlines()
        self.assertEqual(run.stderr, "")
        self.assertEqual(run.returncode, 0 if len(lines) == 1 and "keeps to the drawing" in lines[0] else 1)
        return lines

    def assert_only_fault(self, changes, place, words):
        lines = self.check(changes)
        self.assertEqual(len(lines), 2, lines)  # the fault and the count
        self.assertTrue(lines[0].startswith(place + ": "), lines[0])
        self.assertIn(words, lines[0])

    def test_sound_tree_passes(self):
        self.assertEqual(self.check({}), ["tools/check_layers: the tree keeps to the drawing"])

    def test_upward_include(self):
        text = OPENING + '#include "shared/geometry/se3.h"\n'
        self.assert_only_fault({"shared/core/bad.h": text}, "shared/core/bad.h:3", "may not include shared/geometry")

    def test_sideways_include(self):
        text = OPENING + '#pragma once\n#include "onboard/fusion/fuse_kernel.h"\n'
        self.assert_only_fault({"onboard/tracking/icp.h": text}, "onboard/tracking/icp.h:4", "onboard/fusion")

    def test_onboard_may_not_know_offboard(self):
        text = OPENING + '#include "offboard/session/load.h"\n'
        self.assert_only_fault({"onboard/app/main.cpp": text}, "onboard/app/main.cpp:3", "offboard/session")

    def test_libraries_stay_at_their_edges(self):
        for include, folder in (("lcm/lcm.h", "onboard/publish"), ("kintsugi/pose_t.hpp", "onboard/publish"),
                                ("ceres/ceres.h", "onboard/loops"),
                                ("pcl/point_cloud.h", "tools/eval"), ("cuda_runtime.h", "onboard/fusion")):
            with self.subTest(include=include):
                text = OPENING + f"#include <{include}>\n"
                self.assert_only_fault({f"{folder}/a.cpp": text}, f"{folder}/a.cpp:3", "only in")

    def test_eigen_reaches_no_kernel_even_indirectly(self):
        text = OPENING + '#include "shared/geometry/se3.h"\n'
        way = "onboard/fusion/cast_kernel.h -> shared/geometry/se3.h -> Eigen/Core"
        self.assert_only_fault({"onboard/fusion/cast_kernel.h": text}, "onboard/fusion/cast_kernel.h:1", way)

    def test_opencv_reaches_no_cuda_file(self):
        text = OPENING + "#include <opencv2/core.hpp>\n"
        self.assert_only_fault({"onboard/fusion/all.cu": text}, "onboard/fusion/all.cu:1", "opencv2/core.hpp")

    def test_exec_knows_no_eigen(self):
        text = OPENING + "#include <Eigen/Core>\n"
        self.assert_only_fault({"shared/exec/device.cpp": text}, "shared/exec/device.cpp:3", "may not include")

    def test_includes_start_at_the_root(self):
        for include in ("../core/check.h", "check.h"):
            with self.subTest(include=include):
                text = OPENING + f'#include "{include}"\n'
                self.assert_only_fault({"shared/core/a.cpp": text}, "shared/core/a.cpp:3", "from the root")

    def test_unknown_folder(self):
        self.assert_only_fault({"onboard/helper/a.h": OPENING}, "onboard/helper/a.h:1", "not in the drawing")

    def test_opening_sentence(self):
        licence = "// SPDX-License-Identifier: BSD-3-Clause\n"
        for first in ("#pragma once\n", "// helper\n", "/* Block comments do not count as a sentence. */\n"):
            with self.subTest(first=first):
                text = first + licence
                self.assert_only_fault({"shared/core/a.h": text}, "shared/core/a.h:1", "first line")

    def test_licence_line(self):
        text = "// A file of the test, in one sentence.\n#pragma once\n"
        self.assert_only_fault({"shared/core/a.h": text}, "shared/core/a.h:2", "SPDX")

    def test_scripts_open_likewise(self):
        self.assert_only_fault({"tools/run": "#!/bin/sh\nexit 0\n# SPDX-License-Identifier: BSD-3-Clause\n"},
                               "tools/run:1", "first line")


if __name__ == "__main__":
    unittest.main()
