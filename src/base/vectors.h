// KILN_VECTORS compiles a function for the baseline machine and for wide vectors; the program selects a version at its
// start. All versions return equal bits: no sum is reordered, and no sum is fused with a product.
#pragma once

// Sanitizers start too late for the selection. GCC knows the names of levels from version 12 on.
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
