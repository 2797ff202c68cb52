#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that #include lines keep to the layers of the tree. Prints one FILE:LINE per violation; exit 1 if any.

  core/      a part includes only itself and parts to its left: base, geometry, frame, ... (CORE_PARTS)
  drivers/   a driver includes itself, frame_source.hpp, codec (image decoders), core/base and core/geometry; only
             files directly in drivers/ (the list of all drivers) include several drivers
  tools/     everything but firmware_app, of which the settings
  firmware_app is included by itself and its tests alone
  subscriber includes itself and LCM alone
  LCM, Ceres and camera headers stay where LIBRARY_RULES says
"""
import argparse
import pathlib
import re
import sys

CORE_PARTS = ["base", "geometry", "frame", "odometry", "fragment", "proposal", "posegraph", "posterior", "sifter",
              "pipeline"]
TOP_FOLDERS = ["core", "drivers", "firmware_app", "msgs", "subscriber", "tests", "tools"]
SUFFIXES = (".hpp", ".cpp", ".h")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')

# (name, pattern of the header, where it may be included: path prefixes)
LIBRARY_RULES = [
    ("LCM", re.compile(r"^(lcm/|bot_core/|bot_frames/|loopsift/|lcmtypes/|msgs/)"),
     ("firmware_app/publisher", "drivers/lcm/", "msgs/", "subscriber/", "tools/loopsift_tool/bus/", "tests/")),
    ("Ceres", re.compile(r"^ceres/"), ("core/posegraph/",)),
    ("OpenNI2", re.compile(r"^(openni2/|OpenNI\.h|Driver/OniDriver|OniDriver)"),
     ("drivers/openni2/", "tests/support/")),
    ("libcamera", re.compile(r"^libcamera/"),
     ("drivers/libcamera/", "tests/support/", "tests/unit/drivers/libcamera/", "tests/bench/camera_load_libcamera")),
    ("V4L2", re.compile(r"^(linux/videodev2\.h|libv4l2\.h)"), ("drivers/v4l2/", "tests/support/", "tests/system/guest/")),
]
CERES_FILES = 1


def includes(path):
    """(line number, header, quoted) of each #include."""
    for number, line in enumerate(path.read_text(errors="replace").splitlines(), 1):
        match = INCLUDE.match(line)
        if match:
            yield number, match.group(2), match.group(1) == '"'


def core_violation(parts, header_parts):
    if header_parts[0] != "core":
        return "core includes nothing outside core"
    own, other = parts[1], header_parts[1]
    if other not in CORE_PARTS:
        return f"core/{other} is no part that check_layers.py knows"
    if CORE_PARTS.index(other) > CORE_PARTS.index(own):
        return f"core/{own} stands to the left of core/{other}"
    return None


def driver_violation(parts, header_parts):
    if header_parts[0] == "core":
        return None if header_parts[1] in ("base", "geometry") else "drivers include core/base and core/geometry only"
    if header_parts[0] != "drivers":
        return "drivers include nothing outside drivers, core/base and core/geometry"
    lists_drivers = len(parts) == 2
    if lists_drivers or len(header_parts) == 2 or header_parts[1] in (parts[1], "codec"):
        return None
    return f"driver {parts[1]} includes driver {header_parts[1]}"


def project_violation(parts, header_parts):
    """Why a file may not include a header of the project, or None. Both as path components from the root."""
    if parts[0] == "core" and len(parts) > 2:
        return core_violation(parts, header_parts)
    if parts[0] == "drivers":
        return driver_violation(parts, header_parts)
    if parts[0] == "subscriber":
        return "subscriber includes only itself and LCM"
    if header_parts[0] == "firmware_app" and parts[0] not in ("firmware_app", "tests"):
        shared = parts[0] == "tools" and header_parts[1] == "settings.hpp"
        return None if shared else "nobody includes firmware_app; tools its settings.hpp alone"
    if header_parts[0] == "tests" and parts[0] != "tests":
        return "only tests include tests"
    return None


def check(root):
    """All violations of the tree below root, as strings."""
    found, ceres_files = [], set()
    sources = sorted(p for folder in TOP_FOLDERS for p in (root / folder).rglob("*") if p.suffix in SUFFIXES)
    for path in sources:
        name = path.relative_to(root).as_posix()
        for number, header, quoted in includes(path):
            place = f"{name}:{number}: "
            header_parts = header.split("/")
            if quoted and len(header_parts) > 1 and header_parts[0] in TOP_FOLDERS and header_parts[0] != "msgs":
                why = project_violation(name.split("/"), header_parts)
                if why:
                    found.append(f"{place}{header}: {why}")
                continue
            for library, pattern, allowed in LIBRARY_RULES:
                if not pattern.match(header):
                    continue
                if not name.startswith(allowed):
                    found.append(f"{place}{header}: {library} headers belong in {', '.join(allowed)}")
                elif library == "Ceres":
                    ceres_files.add(name)
    if len(ceres_files) > CERES_FILES:
        found.append(f"Ceres headers belong in one file, not in {', '.join(sorted(ceres_files))}")
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=pathlib.Path,
                        default=pathlib.Path(__file__).resolve().parents[2],
                        help="the tree to check (default: this one)")
    found = check(parser.parse_args().root)
    print("\n".join(found) if found else "layers: ok")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
