#!/usr/bin/env python3
# Makes the synthetic missions that the other end-to-end tests read.
# SPDX-License-Identifier: BSD-3-Clause
import shutil
import subprocess
import sys

from programs import MISSIONS, WORK, command

for name, arguments in MISSIONS.items():
    folder = WORK / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    code = subprocess.run(command("synth", *arguments[:1], folder, *arguments[1:]), check=False).returncode
    if code != 0:
        sys.exit(code)
