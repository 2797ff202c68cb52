#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what subscribers need, builds the examples against it by find_package, and the program in docs/lcm.md by
# pkg-config. usage: installed_subscriber_test.sh CMAKE BUILD_DIR SOURCE_DIR CXX
set -euo pipefail
cmake=$1 build=$2 source=$3 cxx=$4
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

"$cmake" --install "$build" --component subscriber --prefix "$folder/usr" >/dev/null
"$cmake" -S "$folder"/usr/share/doc/loopsift/examples -B "$folder/build" -DCMAKE_PREFIX_PATH="$folder/usr" \
  -DCMAKE_CXX_COMPILER="$cxx" >/dev/null
"$cmake" --build "$folder/build"

package=$(dirname "$(find "$folder/usr" -name loopsift.pc)")
flags=$(PKG_CONFIG_PATH=$package pkg-config --define-variable=prefix="$folder/usr" --cflags loopsift)
awk '/^```cpp/ {on = 1; next} /^```/ {on = 0} on' "$source/docs/lcm.md" >"$folder/documented.cpp"
# shellcheck disable=SC2086 # several flags
"$cxx" -std=c++17 -Wall -Wextra -Werror -fsyntax-only $flags "$folder/documented.cpp"
"$folder"/usr/share/loopsift/python/listen.py --help >/dev/null 2>&1 ||
  python3 "$folder"/usr/share/loopsift/python/listen.py --help >/dev/null
echo "examples and documented program build against the installed package"
