#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing, builds, renders a synthetic room as a recording (drifting odometry and all), maps it, and
# measures the result against the truth.
# usage: demo.sh [OUT_DIR]     default out/demo
set -euo pipefail
cd "$(dirname "$0")/../.."

out=${1:-out/demo}
tools/scripts/install_dependencies.sh
cmake --preset release
cmake --build --preset release --target loopsift loopsift-tool
mkdir -p "$out"
build/release/firmware_app/loopsift --config config/default.toml --source synth:room --rate max --out "$out"

cat <<END

The results are in $out:
  map.ply                  the map, for MeshLab or CloudCompare
  trajectory.txt           corrected poses (TUM format)
  trajectory_odometry.txt  the poses before any correction
  loops.csv                each proposed loop and why it was kept or refused
  run.json                 figures of the run
END
