// Functions that are compiled once for every machine and once for those with wide vectors; which runs is decided when
// the program starts. Either gives the same bits: no sum is reordered, and none fused with a product.
#pragma once

// The sanitizers' own start is too late for such a decision.
#if defined(__x86_64__) && defined(__gnu_linux__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define KILN_VECTORS __attribute__((target_clones("default", "avx2"), flatten))
#else
#define KILN_VECTORS
#endif
