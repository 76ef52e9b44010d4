// Mesh files built byte by byte, and checks of the meshes that readers return for them.
#ifndef QC_TESTS_TOOLS_MESH_BYTES_H
#define QC_TESTS_TOOLS_MESH_BYTES_H

#include "common/mesh_io/mesh_file.h"

#include <check.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum Encoding
{
    encoding_ascii,
    encoding_little,
    encoding_big,
    encoding_count
} Encoding;

static const char* const s_formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};

typedef struct Bytes
{
    char data[1 << 16];
    size_t size;
    Encoding encoding;
} Bytes;

static inline void AddRaw(Bytes* bytes, const void* data, size_t size)
{
    ck_assert_uint_le(bytes->size + size, sizeof bytes->data);
    memcpy(bytes->data + bytes->size, data, size);
    bytes->size += size;
}

__attribute__((format(printf, 2, 3))) static inline void AddText(Bytes* bytes, const char* format, ...)
{
    char text[4096];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    AddRaw(bytes, text, (size_t)length);
}

static inline void AddBits(Bytes* bytes, uint64_t bits, size_t size)
{
    for (size_t i = 0; i < size; ++i)
    {
        size_t place = bytes->encoding == encoding_little ? i : size - 1 - i;
        char byte = (char)(bits >> (8 * place));
        AddRaw(bytes, &byte, 1);
    }
}

/// `type` is one of PLY's names of types.
static inline void AddInteger(Bytes* bytes, const char* type, int64_t value)
{
    size_t size = strstr(type, "char") || strstr(type, "int8")  ? 1
                  : strstr(type, "short") || strstr(type, "16") ? 2
                                                                : 4;
    if (bytes->encoding == encoding_ascii)
        AddText(bytes, "%lld ", (long long)value);
    else
        AddBits(bytes, (uint64_t)value, size);
}

static inline void AddFloat(Bytes* bytes, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    if (bytes->encoding == encoding_ascii)
        AddText(bytes, "%.9g ", value);
    else
        AddBits(bytes, bits, sizeof bits);
}

static inline void AddDouble(Bytes* bytes, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    if (bytes->encoding == encoding_ascii)
        AddText(bytes, "%.17g ", value);
    else
        AddBits(bytes, bits, sizeof bits);
}

static inline void EndElement(Bytes* bytes)
{
    if (bytes->encoding == encoding_ascii)
        AddText(bytes, "\n");
}

static inline void BeginPly(Bytes* bytes, Encoding encoding, const char* declarations)
{
    bytes->size = 0;
    bytes->encoding = encoding;
    AddText(bytes, "ply\nformat %s 1.0\n%send_header\n", s_formats[encoding], declarations);
}

/// Reads from memory of exactly this size: a memory checker finds reads beyond the end.
static inline bool ReadAs(qcMeshPrecision precision, const char* name, const char* data, size_t size, qcMesh* mesh,
                          qcMessage* message)
{
    char* copy = malloc(size == 0 ? 1 : size);
    ck_assert_ptr_nonnull(copy);
    if (size != 0)
        memcpy(copy, data, size);
    bool read = qcMesh_ReadBytes(name, copy, size, precision, mesh, message);
    free(copy);
    return read;
}

static inline bool Read(const char* name, const char* data, size_t size, qcMesh* mesh, qcMessage* message)
{
    return ReadAs(qc_meshAsDeclared, name, data, size, mesh, message);
}

static inline qcMesh MustRead(const char* name, const char* data, size_t size)
{
    qcMesh mesh;
    qcMessage message;
    ck_assert_msg(Read(name, data, size, &mesh, &message), "%s", message.text);
    return mesh;
}

static inline void MustFail(const char* name, const char* data, size_t size, const char* expected)
{
    qcMesh mesh;
    qcMessage message = {""};
    ck_assert_msg(!Read(name, data, size, &mesh, &message), "was read, and not refused with '%s'", expected);
    ck_assert_msg(strstr(message.text, expected) != NULL, "'%s' does not say '%s'", message.text, expected);
    ck_assert_msg(strncmp(message.text, name, strlen(name)) == 0, "'%s' does not name the file", message.text);
    ck_assert_ptr_null(mesh.positions);
    ck_assert_ptr_null(mesh.indices);
}

static inline void AssertIndices(const qcMesh* mesh, size_t count, const uint32_t* indices)
{
    ck_assert_uint_eq(mesh->triangleCount, count);
    for (size_t i = 0; i < 3 * count; ++i)
        ck_assert_uint_eq(mesh->indices[i], indices[i]);
}

#endif
