// Files of a cache: each holds one value and the whole key that it belongs to. Damaged files count as missing.
#ifndef QC_GL_CACHE_FILES_H
#define QC_GL_CACHE_FILES_H

#include "base/memory.h"

enum
{
    qc_maxCacheFolder = 1024 ///< bytes of its path, with the final 0
};

/// A run of bytes.
typedef struct qcBytes
{
    const char* data;
    size_t size;
} qcBytes;

/// A value, and a number for its reader's use.
typedef struct qcCacheValue
{
    uint32_t tag;
    qcBytes bytes;
} qcCacheValue;

/// The folder of the cache: `given`, or, where that is null, the environment's. Empty: there is none.
void qcCacheFiles_FindFolder(const char* given, char folder[qc_maxCacheFolder]);

/// Reads the value of a key. False: there is none. `value` lies in `file`, which the caller frees in any case.
bool qcCacheFiles_Read(const char* folder, qcBytes key, qcArray* file, qcCacheValue* value);
/// Stores a value; other processes find the previous one or this one. Makes the folder. Nothing happens where the disk
/// refuses it.
void qcCacheFiles_Write(const char* folder, qcBytes key, const qcCacheValue* value);

#endif
