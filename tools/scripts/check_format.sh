#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Fails when a C++ file is not as clang-format would write it. With --fix, writes it so.
set -euo pipefail
cd "$(dirname "$0")/../.."

mode=(--dry-run --Werror)
[[ ${1:-} == --fix ]] && mode=(-i)
git ls-files -z '*.cpp' '*.hpp' | xargs -0 -r -n 40 -P "$(nproc)" clang-format "${mode[@]}"
echo "format: ok"
