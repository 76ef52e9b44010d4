/// @file
/// The hash of this library's files.
#ifndef QUICKCULLIDE_HASH_H
#define QUICKCULLIDE_HASH_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

/// XXH64 of `size` bytes (Yann Collet, xxHash fast digest algorithm, version 0.1.1). `data` may be null if size is 0.
/// Equal on all little-endian machines. O(size). Thread-safety: any thread.
QC_API uint64_t qcXxh64(const void* data, size_t size, uint64_t seed);

#ifdef __cplusplus
}
#endif

#endif
