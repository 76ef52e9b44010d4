// Reads a whole file, picks the reader for it, and grows the mesh that the readers fill.
#include "common/mesh_io/mesh_file.h"

#include "common/mesh_io/mesh_parser.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

bool qcMeshParser_Fail(qcMeshParser* parser, const char* format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (parser->line == 0)
        return qcMessage_Fail(parser->message, "%s: %s", parser->name, text);
    return qcMessage_Fail(parser->message, "%s: line %llu: %s", parser->name, (unsigned long long)parser->line, text);
}

const char* qcQuoteWord(const char* word, const char* end, char* buffer, size_t size)
{
    size_t length = (size_t)(end - word) < size - 1 ? (size_t)(end - word) : size - 1;
    for (size_t i = 0; i < length; ++i)
        buffer[i] = (unsigned char)word[i] < ' ' || (unsigned char)word[i] == 0x7f ? '?' : word[i];
    buffer[length] = 0;
    return buffer;
}

static bool Grow(qcMeshParser* parser, void** data, size_t* capacity, size_t count, size_t elementSize,
                 const char* name)
{
    if (count <= *capacity)
        return true;
    // Indices have 32 bits.
    if (count > UINT32_MAX)
        return qcMeshParser_Fail(parser, "more than %u %s", UINT32_MAX, name);
    size_t newCapacity = *capacity + *capacity / 2;
    if (newCapacity < count)
        newCapacity = count;
    void* grown = realloc(*data, newCapacity * elementSize);
    if (grown == NULL)
        return qcMeshParser_Fail(parser, "out of memory: %zu bytes for %s", newCapacity * elementSize, name);
    *data = grown;
    *capacity = newCapacity;
    return true;
}

bool qcMeshParser_ReserveVertices(qcMeshParser* parser, size_t count)
{
    qcMesh* mesh = parser->mesh;
    size_t size = 3 * (mesh->isDouble ? sizeof(double) : sizeof(float));
    return Grow(parser, &mesh->positions, &parser->vertexCapacity, count, size, "vertices");
}

bool qcMeshParser_ReserveTriangles(qcMeshParser* parser, size_t count)
{
    void* indices = parser->mesh->indices;
    bool grown = Grow(parser, &indices, &parser->triangleCapacity, count, 3 * sizeof(uint32_t), "triangles");
    parser->mesh->indices = indices;
    return grown;
}

bool qcMeshParser_PushVertex(qcMeshParser* parser, const double position[3])
{
    qcMesh* mesh = parser->mesh;
    if (!qcMeshParser_ReserveVertices(parser, (size_t)mesh->vertexCount + 1))
        return false;
    size_t first = 3 * (size_t)mesh->vertexCount;
    for (size_t axis = 0; axis < 3; ++axis)
    {
        if (mesh->isDouble)
            ((double*)mesh->positions)[first + axis] = position[axis];
        else
            ((float*)mesh->positions)[first + axis] = (float)position[axis];
    }
    ++mesh->vertexCount;
    return true;
}

bool qcMeshParser_PushTriangle(qcMeshParser* parser, uint32_t a, uint32_t b, uint32_t c)
{
    qcMesh* mesh = parser->mesh;
    if (!qcMeshParser_ReserveTriangles(parser, (size_t)mesh->triangleCount + 1))
        return false;
    uint32_t* corner = mesh->indices + 3 * (size_t)mesh->triangleCount;
    corner[0] = a;
    corner[1] = b;
    corner[2] = c;
    ++mesh->triangleCount;
    return true;
}

bool qcMeshParser_ParseCoordinate(const qcMeshParser* parser, bool isDouble, const char* text, const char* end,
                                  double* value)
{
    if (isDouble || parser->precision == qc_meshDouble)
        return qcParseDouble(text, end, value) && isfinite(*value);
    float single;
    if (!qcParseFloat(text, end, &single))
        return false;
    *value = single;
    return isfinite(single);
}

void qcMeshParser_SkipEmptyLines(qcMeshParser* parser)
{
    for (; parser->cursor < parser->end && (qcIsBlank(*parser->cursor) || *parser->cursor == '\n'); ++parser->cursor)
        parser->line += parser->line != 0 && *parser->cursor == '\n';
}

static bool HasEnding(const char* name, const char* ending)
{
    size_t length = strlen(name), endingLength = strlen(ending);
    return length >= endingLength && strcasecmp(name + length - endingLength, ending) == 0;
}

bool qcMesh_ReadBytes(const char* name, const char* bytes, size_t size, qcMeshPrecision precision, qcMesh* mesh,
                      qcMessage* message)
{
    *mesh = (qcMesh){.isDouble = precision == qc_meshDouble};
    qcMeshParser parser = {name, bytes, bytes + size, 1, precision, mesh, 0, 0, message};
    bool isPly = size >= 4 && memcmp(bytes, "ply", 3) == 0 && (bytes[3] == '\n' || bytes[3] == '\r');
    bool read;
    if (isPly || HasEnding(name, ".ply"))
        read = qcReadPly(&parser);
    else if (HasEnding(name, ".obj"))
        read = qcReadObj(&parser);
    else
        read = qcMessage_Fail(message, "%s: not a mesh: it does not start as a PLY file, and is not named .obj", name);
    if (!read)
        qcMesh_Free(mesh);
    return read;
}

/// The whole stream; the caller frees `*bytes`, also after a failure.
static bool ReadStream(FILE* stream, char** bytes, size_t* size)
{
    size_t capacity = 0;
    do
    {
        capacity = capacity == 0 ? 1 << 16 : 2 * capacity;
        char* grown = realloc(*bytes, capacity);
        if (grown == NULL)
            return false;
        *bytes = grown;
        *size += fread(*bytes + *size, 1, capacity - *size, stream);
    } while (*size == capacity);
    return ferror(stream) == 0;
}

bool qcMesh_ReadFile(const char* path, qcMeshPrecision precision, qcMesh* mesh, qcMessage* message)
{
    *mesh = (qcMesh){0};
    FILE* stream = fopen(path, "rb");
    if (stream == NULL)
        return qcMessage_Fail(message, "%s: %s", path, strerror(errno));
    char* bytes = NULL;
    size_t size = 0;
    bool read = ReadStream(stream, &bytes, &size);
    if (!read)
        qcMessage_Fail(message, "%s: %s", path, strerror(errno));
    fclose(stream);
    read = read && qcMesh_ReadBytes(path, bytes, size, precision, mesh, message);
    free(bytes);
    return read;
}

void qcMesh_Free(qcMesh* mesh)
{
    free(mesh->positions);
    free(mesh->indices);
    *mesh = (qcMesh){0};
}
