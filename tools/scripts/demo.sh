#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing, builds, maps a furnished room that a rendered depth camera is carried round twice, measures
# the result against the truth and draws the map.
# usage: demo.sh [OUT_DIR]     default out/demo
set -euo pipefail
cd "$(dirname "$0")/../.."

out=${1:-out/demo}
scene=room
tools/scripts/install_dependencies.sh
echo "== building (log: build/release/demo.log)"
mkdir -p build/release
{ cmake --preset release && cmake --build --preset release --target loopsift loopsift-tool; } \
  >build/release/demo.log 2>&1 || { tail -n 40 build/release/demo.log; exit 1; }
loopsift=build/release/firmware_app/loopsift
tool=build/release/tools/loopsift_tool/loopsift-tool

mkdir -p "$out"
echo "== mapping synth:$scene"
"$loopsift" --source "synth:$scene" --rate max --out "$out"
"$tool" synth "$scene" --no-images --out "$out/truth" >/dev/null
truth=$out/truth/groundtruth.txt
for name in trajectory_odometry trajectory; do
  echo "== error of $name.txt"
  "$tool" eval-trajectory --gt "$truth" --est "$out/$name.txt" --json "$out/$name.error.json"
done
echo "== distance of map.ply from the true surface"
"$tool" eval-surface --gt-mesh "$out/truth/mesh.ply" --map "$out/map.ply" --trajectory "$out/trajectory.txt" \
  --gt-trajectory "$truth" --json "$out/surface.error.json"
tools/scripts/render_map.py "$out/map.ply" "$out/map" --cut 0.3 --trajectory "$out/trajectory.txt" >/dev/null

cat <<END

Done in $SECONDS s. The results are in $out:
  map_view.png, map_top.png   pictures of the map and the camera's way
  map.ply                     the map itself, for MeshLab or CloudCompare
  trajectory.txt              corrected camera poses (TUM format); trajectory_odometry.txt: before any correction
  loops.csv                   each proposed loop, its scores, and why it was kept or refused
  run.json, *.error.json      figures of the run, and the errors shown above
END
