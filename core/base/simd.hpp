// SPDX-License-Identifier: MIT
// Run-time dispatch: a function marked LOOPSIFT_SIMD is compiled for the base instruction set and once more
// for AVX2 with FMA; the loader picks. Both forms are deterministic on a given machine. Off under sanitizers,
// whose runtimes start after the loader resolves such functions.
#pragma once
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__) && defined(__OPTIMIZE__)
#define LOOPSIFT_SIMD __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define LOOPSIFT_SIMD
#endif
