// FNV-1a, 64 bits, over values without padding, and the random numbers of the golden programs (splitmix64).
#ifndef QC_GOLDEN_HASH_H
#define QC_GOLDEN_HASH_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/// A hash of `count` elements.
typedef struct qcHash
{
    uint64_t value;
    uint64_t count;
} qcHash;

static inline qcHash qcHash_Start(void)
{
    qcHash hash = {0xcbf29ce484222325u, 0};
    return hash;
}

static inline void qcHash_Add(qcHash* hash, const void* data, size_t size)
{
    const unsigned char* bytes = (const unsigned char*)data;
    for (size_t i = 0; i < size; i++)
        hash->value = (hash->value ^ bytes[i]) * 0x100000001b3u;
}

/// A number of 4 or 8 bytes, the low byte first on every machine.
static inline void qcHash_AddNumber(qcHash* hash, const void* number, size_t size)
{
    uint64_t value;
    uint32_t half;
    if (size == sizeof value)
        memcpy(&value, number, sizeof value);
    else
    {
        memcpy(&half, number, sizeof half);
        value = half;
    }
    for (size_t i = 0; i < size; i++)
        hash->value = (hash->value ^ (value >> 8 * i & 255)) * 0x100000001b3u;
}

/// The count is hashed too, so that steps don't run into each other.
static inline void qcHash_AddCount(qcHash* hash, uint64_t count)
{
    hash->count += count;
    qcHash_AddNumber(hash, &count, sizeof count);
}

/// `count` elements without padding; `fields` has a digit for each number of an element, in order: its size, 4 or 8.
/// Machines of either byte order give equal hashes.
static inline void qcHash_AddFields(qcHash* hash, const void* data, size_t count, const char* fields)
{
    qcHash_AddCount(hash, count);
    const char* number = (const char*)data;
    for (size_t i = 0; i < count; i++)
        for (const char* field = fields; *field != '\0'; field++)
        {
            size_t size = (size_t)(*field - '0');
            qcHash_AddNumber(hash, number, size);
            number += size;
        }
}

/// `count` elements of `size` bytes, byte for byte.
static inline void qcHash_AddArray(qcHash* hash, const void* data, size_t count, size_t size)
{
    qcHash_AddCount(hash, count);
    if (count != 0)
        qcHash_Add(hash, data, count * size);
}

typedef struct qcRandom
{
    uint64_t state;
} qcRandom;

static inline uint64_t qcRandom_Next(qcRandom* random)
{
    uint64_t z = random->state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/// A number in 0 .. bound - 1; bound > 0.
static inline uint32_t qcRandom_Below(qcRandom* random, uint32_t bound)
{
    return (uint32_t)((qcRandom_Next(random) >> 32) * bound >> 32);
}

static inline double qcRandom_Uniform(qcRandom* random, double lower, double upper)
{
    return lower + (double)(qcRandom_Next(random) >> 11) * 0x1p-53 * (upper - lower);
}

#endif
