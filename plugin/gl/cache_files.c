// A file: a header with a checksum, the key, the value. It is written beside its place and renamed.
#define _POSIX_C_SOURCE 200809L
#include "gl/cache_files.h"

#include "quickcullide/hash.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum
{
    qc_maxCachePath = qc_maxCacheFolder + 64,
    qc_maxCacheFile = 1 << 26 ///< bytes
};

typedef struct Header
{
    char magic[8];
    uint64_t checksum; ///< of all that follows
    uint32_t keySize, valueSize, tag, unused;
} Header;

static const char s_magic[sizeof((Header*)NULL)->magic] = "qccache";

//  ---- the folder --------------------------------------------------------------------------------------------------

static void Join(char folder[qc_maxCacheFolder], const char* first, const char* second)
{
    int length = snprintf(folder, qc_maxCacheFolder, "%s%s", first, second);
    if (length < 0 || length >= qc_maxCacheFolder)
        folder[0] = 0;
}

void qcCacheFiles_FindFolder(const char* given, char folder[qc_maxCacheFolder])
{
    const char *chosen = getenv("QC_PROGRAM_CACHE"), *caches = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    folder[0] = 0;
    if (given != NULL)
        Join(folder, given, "");
    else if (getuid() != geteuid() || getgid() != getegid())
        return; // the environment is another user's
    else if (chosen != NULL)
        Join(folder, chosen[0] == '/' ? chosen : "", "");
    // XDG Base Directory Specification: a relative path is ignored.
    else if (caches != NULL && caches[0] == '/')
        Join(folder, caches, "/quickcullide");
    else if (home != NULL && home[0] == '/')
        Join(folder, home, "/.cache/quickcullide");
}

/// Makes a folder and those above it, for this user alone.
static void MakeFolder(const char* folder)
{
    char path[qc_maxCacheFolder];
    snprintf(path, sizeof path, "%s", folder);
    for (char* at = path + 1; *at != 0; at++)
    {
        if (*at != '/')
            continue;
        *at = 0;
        (void)mkdir(path, 0700);
        *at = '/';
    }
    (void)mkdir(path, 0700);
}

static void NameFile(char path[qc_maxCachePath], const char* folder, qcBytes key)
{
    snprintf(path, qc_maxCachePath, "%s/%016" PRIx64, folder, qcXxh64(key.data, key.size, 0));
}

//  ---- reading -----------------------------------------------------------------------------------------------------

static bool ReadAll(int file, char* data, size_t size)
{
    size_t at = 0;
    while (at < size)
    {
        ssize_t got = read(file, data + at, size - at);
        if (got == 0 || (got < 0 && errno != EINTR))
            return false;
        at += got > 0 ? (size_t)got : 0;
    }
    return true;
}

/// Reads a file as it is.
static bool ReadFile(const char* path, qcArray* content)
{
    // O_NONBLOCK: a pipe in its place must not block.
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    struct stat info;
    if (file < 0)
        return false;
    bool read = fstat(file, &info) == 0 && S_ISREG(info.st_mode) && info.st_size >= (off_t)sizeof(Header) &&
                info.st_size <= qc_maxCacheFile &&
                qcArray_Resize(content, (size_t)info.st_size, 1, "a file of the cache") == qc_statusOk &&
                ReadAll(file, content->data, content->count);
    close(file);
    return read;
}

static uint64_t ChecksumOf(const char* data, size_t size)
{
    const size_t first = offsetof(Header, keySize);
    return qcXxh64(data + first, size - first, 0);
}

bool qcCacheFiles_Read(const char* folder, qcBytes key, qcArray* file, qcCacheValue* value)
{
    char path[qc_maxCachePath];
    Header header;
    NameFile(path, folder, key);
    if (!ReadFile(path, file))
        return false;
    const char* data = file->data;
    memcpy(&header, data, sizeof header);
    if (memcmp(header.magic, s_magic, sizeof s_magic) != 0 || header.keySize != key.size ||
        file->count != sizeof header + (size_t)header.keySize + header.valueSize ||
        header.checksum != ChecksumOf(data, file->count) || memcmp(data + sizeof header, key.data, key.size) != 0)
        return false;
    *value = (qcCacheValue){header.tag, {data + sizeof header + key.size, header.valueSize}};
    return true;
}

//  ---- writing -----------------------------------------------------------------------------------------------------

static bool WriteAll(int file, const char* data, size_t size)
{
    size_t at = 0;
    while (at < size)
    {
        ssize_t done = write(file, data + at, size - at);
        if (done == 0 || (done < 0 && errno != EINTR))
            return false;
        at += done > 0 ? (size_t)done : 0;
    }
    return true;
}

/// Writes beside `path`, and renames.
static void WriteFile(const char* path, const char* data, size_t size)
{
    static atomic_uint s_number;
    char temporary[qc_maxCachePath + 48];
    snprintf(temporary, sizeof temporary, "%s.%ld-%u.tmp", path, (long)getpid(), atomic_fetch_add(&s_number, 1));
    int file = open(temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (file < 0)
        return;
    bool written = WriteAll(file, data, size);
    written = close(file) == 0 && written;
    if (!written || rename(temporary, path) != 0)
        (void)unlink(temporary);
}

void qcCacheFiles_Write(const char* folder, qcBytes key, const qcCacheValue* value)
{
    char path[qc_maxCachePath];
    Header header = {.tag = value->tag};
    size_t size = sizeof header + key.size + value->bytes.size;
    if (size > qc_maxCacheFile)
        return;
    char* data = qcAllocate(size);
    if (data == NULL)
        return;
    memcpy(header.magic, s_magic, sizeof s_magic);
    header.keySize = (uint32_t)key.size;
    header.valueSize = (uint32_t)value->bytes.size;
    memcpy(data, &header, sizeof header);
    memcpy(data + sizeof header, key.data, key.size);
    memcpy(data + sizeof header + key.size, value->bytes.data, value->bytes.size);
    header.checksum = ChecksumOf(data, size);
    memcpy(data, &header, sizeof header);
    NameFile(path, folder, key);
    MakeFolder(folder);
    WriteFile(path, data, size);
    qcFree(data, size);
}
