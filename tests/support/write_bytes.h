// Writes a file of bytes, for tests that damage one again and again.
#ifndef QC_TESTS_SUPPORT_WRITE_BYTES_H
#define QC_TESTS_SUPPORT_WRITE_BYTES_H

#include <check.h>
#include <stdio.h>

static inline void WriteBytes(const char* path, const void* bytes, size_t size)
{
    // ext4 waits for the disk when a file that was cut to nothing is closed, but not for a new file.
    remove(path);
    FILE* file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    if (size != 0) // fwrite takes no null pointer
        ck_assert_uint_eq(fwrite(bytes, 1, size, file), size);
    ck_assert_int_eq(fclose(file), 0);
}

#endif
