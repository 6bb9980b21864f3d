#!/usr/bin/env python3
# What tools/train_vocabulary takes and says, with made-up programs.
# SPDX-License-Identifier: BSD-3-Clause
import contextlib
import io
import os
import sys
import tempfile
import unittest
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from unittest import mock

TOOL = Path(__file__).resolve().parents[3] / "tools" / "train_vocabulary"
sys.dont_write_bytecode = True
sys.path.insert(0, str(TOOL.parent))
training = module_from_spec(spec_from_loader("train_vocabulary", SourceFileLoader("train_vocabulary", str(TOOL))))
training.__loader__.exec_module(training)


class MadeUpPrograms:
    """Takes down what is called; a vocabulary holds b"words"."""

    def __init__(self):
        self.calls = []

    def run(self, name, *arguments):
        self.calls.append([name, *map(str, arguments)])
        if name == "kintsugi-train-vocabulary":
            Path(self.calls[-1][self.calls[-1].index("--output") + 1]).write_bytes(b"words")


class TrainVocabularyTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder, self.programs = Path(folder.name), MadeUpPrograms()

    def sources(self):
        with mock.patch.dict(os.environ, {"KT_DATA": str(self.folder)}), contextlib.redirect_stderr(io.StringIO()) as said:
            return training.shipped_sources(self.programs, self.folder / "work"), said.getvalue()

    def test_missions_are_made_once_and_come_before_the_recording(self):
        (self.folder / "fr1_xyz_260").mkdir()
        sources, said = self.sources()
        self.assertEqual(["room", "apartment", "corridor-doors", "ring", "fr1_xyz_260"], [Path(s).name for s in sources])
        self.assertEqual("", said)
        made = len(self.programs.calls)
        self.sources()
        self.assertEqual((4, 4), (made, len(self.programs.calls)))

    def test_a_missing_recording_is_told(self):
        sources, said = self.sources()
        self.assertEqual(4, len(sources))
        self.assertIn("will differ", said)

    def test_tells_whether_a_file_changed(self):
        for expected in (None, False):
            path, differs = training.train(self.programs, "surf", ["tum:a"], self.folder, [])
            self.assertIs(expected, differs)
        path.write_bytes(b"other words")
        self.assertTrue(training.train(self.programs, "surf", ["tum:a"], self.folder, [])[1])
        self.assertEqual(["surf64.voc"], [p.name for p in self.folder.iterdir()])


if __name__ == "__main__":
    unittest.main()
