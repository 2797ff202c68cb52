#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing, builds with warnings as errors and runs all tests.
# usage: test.sh [CTEST_ARGUMENTS...]     e.g. test.sh -R odometry
set -euo pipefail
cd "$(dirname "$0")/../.."

tools/scripts/install_dependencies.sh
cmake --preset strict
cmake --build --preset strict
ctest --preset strict -j "$(nproc)" "$@"
