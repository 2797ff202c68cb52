#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing, builds with warnings as errors and runs all tests.
# usage: test.sh [CTEST_ARGUMENTS...]     e.g. test.sh -R odometry
set -euo pipefail
cd "$(dirname "$0")/../.."

tools/scripts/install_dependencies.sh
cmake --preset strict
cmake --build --preset strict
# A test gets a second try where a machine gave its threads no processor; ctest shows both. One that needs it
# again and again is wrong.
ctest --preset strict -j "$(nproc)" --repeat until-pass:2 "$@"
