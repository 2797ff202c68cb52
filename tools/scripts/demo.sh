#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing, builds, renders a furnished room walked round twice as a depth camera would see it, maps
# it, and measures the result against the truth.
# usage: demo.sh [OUT_DIR]     default out/demo
set -euo pipefail
cd "$(dirname "$0")/../.."

out=${1:-out/demo}
tools/scripts/install_dependencies.sh
cmake --preset release
cmake --build --preset release --target loopsift loopsift-tool
loopsift=build/release/firmware_app/loopsift
tool=build/release/tools/loopsift_tool/loopsift-tool

mkdir -p "$out"
echo "== rendering the sequence"
"$tool" synth room --out "$out/sequence"
echo "== mapping it"
"$loopsift" --source "replay:tum:$out/sequence" --rate max --out "$out"
truth=$out/sequence/groundtruth.txt
echo "== error of the odometry"
"$tool" eval-trajectory --gt "$truth" --est "$out/trajectory_odometry.txt"
echo "== error of the corrected trajectory"
"$tool" eval-trajectory --gt "$truth" --est "$out/trajectory.txt"
echo "== distance of the map from the true surface"
"$tool" eval-surface --gt-mesh "$out/sequence/mesh.ply" --map "$out/map.ply" --trajectory "$out/trajectory.txt" \
  --gt-trajectory "$truth"

cat <<END

The results are in $out:
  map.ply                  the map, for MeshLab or CloudCompare
  trajectory.txt           corrected camera poses (TUM format)
  trajectory_odometry.txt  the poses before any correction
  loops.csv                each proposed loop, its scores, and why it was kept or refused
  run.json                 figures of the run
END
