// Shared by the fuzzers: values from bytes, and a check that ends the program, so that libFuzzer keeps the input.
#ifndef QC_TESTS_FUZZ_FUZZ_H
#define QC_TESTS_FUZZ_FUZZ_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Runs one input. 0: it may join the corpus.
int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

#ifdef __cplusplus
}
#endif

/// Ends the program with the place of a broken claim.
#define FUZZ_CHECK(claim)                                                                                              \
    do                                                                                                                 \
    {                                                                                                                  \
        if (!(claim))                                                                                                  \
        {                                                                                                              \
            fprintf(stderr, "%s:%d: does not hold: %s\n", __FILE__, __LINE__, #claim);                                 \
            abort();                                                                                                   \
        }                                                                                                              \
    } while (0)

/// The rest of an input. Beyond its end all bytes are 0.
typedef struct FuzzBytes
{
    const uint8_t* data;
    size_t size;
} FuzzBytes;

static inline uint8_t Fuzz_TakeByte(FuzzBytes* bytes)
{
    if (bytes->size == 0)
        return 0;
    bytes->size--;
    return *bytes->data++;
}

/// A number below `count`, 1 to 256; one byte.
static inline uint32_t Fuzz_TakeBelow(FuzzBytes* bytes, uint32_t count)
{
    return Fuzz_TakeByte(bytes) % count;
}

/// `count` bytes, at most 8, little-endian.
static inline uint64_t Fuzz_TakeBits(FuzzBytes* bytes, int count)
{
    uint64_t bits = 0;
    for (int i = 0; i < count; i++)
        bits |= (uint64_t)Fuzz_TakeByte(bytes) << 8 * i;
    return bits;
}

#endif
