#!/usr/bin/env python3
# The Debian packages of this build: what is in them, what they need, and that what they install runs.
# SPDX-License-Identifier: BSD-3-Clause
import os
import re
import shutil
import subprocess
import sys
import unittest

from programs import BIN, WORK, ProgramTest

PROGRAMS = {"common": {"kintsugi-log"}, "onboard": {"kintsugi-collect"},
            "offboard": {"kintsugi-map", "kintsugi-eval", "kintsugi-graph", "kintsugi-render", "kintsugi-synth"}}


def output_of(*arguments, **options):
    return subprocess.run([str(word) for word in arguments], check=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          **options).stdout


class PackageTest(ProgramTest):
    def setUp(self):
        super().setUp()
        output_of("cpack", "-G", "DEB", "-B", self.folder / "out", "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=gzip", cwd=BIN.parent)
        self.packages = {path.name.split("_")[0].removeprefix("kintsugi-"): path for path in (self.folder / "out").glob("*.deb")}

    def test_packages(self):
        self.assertEqual(set(self.packages), set(PROGRAMS))
        root = self.folder / "root"
        for part, package in self.packages.items():
            with self.subTest(package=package.name):
                fields = dict(re.findall(r"^ ?([A-Z][\w-]*): (.*)$", output_of("dpkg-deb", "--field", package), re.MULTILINE))
                self.assertEqual(fields["Package"], f"kintsugi-{part}")
                self.assertRegex(fields["Depends"], r"libc6 \(>= ")
                if part != "common":
                    self.assertIn(f"kintsugi-common (= {fields['Version']})", fields["Depends"])
                output_of("dpkg-deb", "--extract", package, root)
                listing = output_of("dpkg-deb", "--contents", package)
                self.assertEqual(set(re.findall(r" \./usr/bin/([\w-]+)$", listing, re.MULTILINE)), PROGRAMS[part])
                self.assertIn(f"./usr/share/doc/kintsugi-{part}/copyright", listing)
                self.assertNotIn(str(BIN.parent), listing)
        self.check_onboard(root)

    def check_onboard(self, root):
        package = self.packages["onboard"]
        self.assertIn("adduser", output_of("dpkg-deb", "--field", package, "Depends"))
        output_of("dpkg-deb", "--control", package, self.folder / "control")
        self.assertEqual((self.folder / "control/conffiles").read_text(), "/etc/kintsugi/collector.yaml\n")
        for script in ("postinst", "prerm", "postrm"):
            self.assertTrue(os.access(self.folder / "control" / script, os.X_OK), script)
            output_of("sh", "-n", self.folder / "control" / script)
        unit = (root / "usr/lib/systemd/system/kintsugi-collector.service").read_text()
        self.assertIn("ExecStart=/usr/bin/kintsugi-collect --quiet --config /etc/kintsugi/collector.yaml\n", unit)
        collect = root / "usr/bin/kintsugi-collect"
        self.assertIn("--check", output_of(collect, "--help"))
        text = output_of(collect, "--check", "--config", root / "etc/kintsugi/collector.yaml", "--input", f"tum:{WORK / 'small'}",
                         "--log", self.folder / "m.lcm", "--set", "volume.resolution=128", "--set", "volume.voxel_size_m=0.04")
        self.assertRegex(text, r"ok    configuration  .*etc/kintsugi/collector.yaml")


if __name__ == "__main__":
    for program in ("cpack", "dpkg-deb", "dpkg-shlibdeps"):
        if shutil.which(program) is None:
            print(f"skipped: {program} is not installed (Debian packages cmake, dpkg, dpkg-dev)")
            sys.exit(77)
    unittest.main()
