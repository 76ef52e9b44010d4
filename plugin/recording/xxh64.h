// XXH64, a hash of bytes: Yann Collet, xxHash fast digest algorithm, version 0.1.1.
#ifndef QC_RECORDING_XXH64_H
#define QC_RECORDING_XXH64_H

#include <stddef.h>
#include <stdint.h>

/// `data` may be null if size is 0. Equal on all little-endian machines.
uint64_t qcXxh64(const void* data, size_t size, uint64_t seed);

#endif
