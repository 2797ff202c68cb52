// SPDX-License-Identifier: MIT
// Run-time dispatch: a function marked LOOPSIFT_SIMD is compiled for the base instruction set and once more
// for AVX2 with FMA; the loader picks. LOOPSIFT_WIDE_SIMD is the same with a third form for AVX-512, for
// functions without sums over lanes: their results are those of AVX2. Each form is deterministic on a given
// machine. Off under sanitizers, whose runtimes start after the loader resolves such functions.
#pragma once
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__) && defined(__OPTIMIZE__)
#define LOOPSIFT_SIMD __attribute__((target_clones("arch=x86-64-v3", "default")))
#define LOOPSIFT_WIDE_SIMD __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define LOOPSIFT_SIMD
#define LOOPSIFT_WIDE_SIMD
#endif
