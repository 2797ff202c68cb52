#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The layer check finds each kind of violation, and passes what is allowed."""
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "tools" / "scripts"))
import check_layers  # noqa: E402


def violations(files):
    """What the check says about a tree of {path: include}."""
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, header in files.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(f"// a file\n#include {header}\n")
        return check_layers.check(root)


class CheckLayersTest(unittest.TestCase):
    def assert_violation(self, name, header, text):
        found = violations({name: header})
        self.assertEqual(len(found), 1, found)
        self.assertIn(f"{name}:2:", found[0])
        self.assertIn(text, found[0])

    def assert_allowed(self, name, header):
        self.assertEqual(violations({name: header}), [])

    def test_core_looks_left_only(self):
        self.assert_allowed("core/sifter/a.cpp", '"core/posterior/b.hpp"')
        self.assert_allowed("core/sifter/a.cpp", '"core/sifter/b.hpp"')
        self.assert_violation("core/posterior/a.cpp", '"core/sifter/b.hpp"', "to the left of core/sifter")
        self.assert_violation("core/base/a.hpp", '"core/geometry/b.hpp"', "to the left of core/geometry")
        self.assert_violation("core/base/a.hpp", '"core/unheard_of/b.hpp"', "no part")

    def test_core_stays_in_core(self):
        for header in ('"drivers/frame_source.hpp"', '"firmware_app/main.hpp"', '"tools/t.hpp"'):
            self.assert_violation("core/pipeline/a.hpp", header, "nothing outside core")

    def test_drivers_know_base_geometry_and_themselves(self):
        self.assert_allowed("drivers/replay/a.cpp", '"core/geometry/se3.hpp"')
        self.assert_allowed("drivers/replay/a.cpp", '"drivers/frame_source.hpp"')
        self.assert_allowed("drivers/open_source.cpp", '"drivers/replay/a.hpp"')
        self.assert_violation("drivers/replay/a.cpp", '"core/frame/f.hpp"', "core/base and core/geometry only")
        self.assert_violation("drivers/replay/a.cpp", '"drivers/synth/s.hpp"', "driver replay includes driver synth")
        self.assert_violation("drivers/replay/a.cpp", '"tools/t.hpp"', "nothing outside drivers")

    def test_nobody_includes_firmware_app(self):
        self.assert_allowed("firmware_app/main.cpp", '"firmware_app/threads.hpp"')
        self.assert_allowed("tests/unit/firmware_app/a.cpp", '"firmware_app/threads.hpp"')
        self.assert_violation("tools/loopsift_tool/a.cpp", '"firmware_app/threads.hpp"', "nobody includes firmware_app")
        self.assert_allowed("tools/loopsift_tool/a.cpp", '"firmware_app/settings.hpp"')
        self.assert_violation("core/pipeline/a.cpp", '"firmware_app/settings.hpp"', "core includes nothing outside core")

    def test_only_tests_include_tests(self):
        self.assert_violation("tools/loopsift_tool/a.cpp", '"tests/support/s.hpp"', "only tests include tests")

    def test_libraries_stay_in_their_place(self):
        self.assert_allowed("firmware_app/publisher.cpp", "<lcm/lcm.h>")
        self.assert_violation("core/pipeline/a.cpp", "<lcm/lcm.h>", "LCM headers")
        self.assert_violation("firmware_app/main.cpp", '"bot_core/pose_t.hpp"', "LCM headers")
        self.assert_violation("drivers/replay/a.cpp", "<OpenNI.h>", "OpenNI2 headers")
        self.assert_violation("drivers/openni2/a.cpp", "<libcamera/camera.h>", "libcamera headers")
        self.assert_violation("core/base/a.cpp", "<linux/videodev2.h>", "V4L2 headers")
        self.assert_violation("core/sifter/a.cpp", "<ceres/ceres.h>", "Ceres headers")

    def test_ceres_in_one_file(self):
        one = {"core/posegraph/a.cpp": "<ceres/ceres.h>"}
        self.assertEqual(violations(one), [])
        found = violations({**one, "core/posegraph/b.cpp": "<ceres/problem.h>"})
        self.assertEqual(len(found), 1)
        self.assertIn("in one file", found[0])


if __name__ == "__main__":
    unittest.main()
