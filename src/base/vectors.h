// Functions that are compiled once for every machine and once for those with wide vectors; which runs is decided when
// the program starts. Either gives the same bits: no sum is reordered, and none fused with a product.
#pragma once

// The sanitizers' own start is too late for such a decision. Names of levels are known from GCC 12 on.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#if __GNUC__ >= 12
#define KILN_WIDE_VECTORS "avx2", "arch=x86-64-v4"
#else
#define KILN_WIDE_VECTORS "avx2"
#endif
#define KILN_VECTORS __attribute__((target_clones("default", KILN_WIDE_VECTORS), flatten))
#else
#define KILN_VECTORS
#endif
