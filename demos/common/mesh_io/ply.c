// PLY: a header that declares elements and their properties, then their values.
// Turk, The PLY Polygon File Format, 1994. Triangle strips as in the files of Stanford's and Georgia Tech's archives:
// an element tristrips whose list holds strips, separated by -1. Elements other than vertex, face and tristrips are
// skipped.
#include "common/mesh_io/ply.h"

#include <stdio.h>

typedef struct Location
{
    char text[80];
} Location;

static Location GetLocation(const qcPlyReader* reader)
{
    Location location;
    int length = snprintf(location.text, sizeof location.text, "%s %llu", reader->element->name,
                          (unsigned long long)reader->index);
    if (reader->valueIndex != 0)
        snprintf(location.text + length, sizeof location.text - (size_t)length, ": value %lld",
                 (long long)reader->valueIndex);
    return location;
}

bool qcPly_FailHere(qcPlyReader* reader, const char* text)
{
    return qcMeshParser_Fail(reader->parser, "%s: %s", GetLocation(reader).text, text);
}

bool qcPly_FailWord(qcPlyReader* reader, const char* word, const char* wordEnd, const char* text)
{
    char quoted[40];
    return qcMeshParser_Fail(reader->parser, "%s: '%s' %s", GetLocation(reader).text,
                             qcQuoteWord(word, wordEnd, quoted, sizeof quoted), text);
}

static bool CheckVertex(qcPlyReader* reader, int64_t vertex)
{
    if (vertex >= 0 && vertex < (int64_t)reader->vertexCount)
        return true;
    return qcMeshParser_Fail(reader->parser, "%s: there is no vertex %lld: the last is %lld", GetLocation(reader).text,
                             (long long)vertex, (long long)reader->vertexCount - 1);
}

static bool ReadCorners(qcPlyReader* reader, const qcPlyType* type, int64_t count)
{
    uint32_t first = 0, last = 0;
    if (count < 3)
        return qcPly_FailHere(reader, "fewer than 3 corners");
    for (int64_t i = 0; i < count; ++i)
    {
        int64_t corner = 0;
        if (!reader->encoding->nextInteger(reader, type, &corner) || !CheckVertex(reader, corner))
            return false;
        if (i == 0)
            first = (uint32_t)corner;
        else if (i > 1 && !qcMeshParser_PushTriangle(reader->parser, first, last, (uint32_t)corner))
            return false;
        last = (uint32_t)corner;
    }
    return true;
}

/// Adds the last three vertices of a strip as a triangle. Every second triangle is wound the other way. A triangle that
/// names a vertex twice only joins two runs of the strip and is dropped.
static bool PushStripTriangle(qcPlyReader* reader, const uint32_t v[3], int64_t length)
{
    if (length < 3 || v[0] == v[1] || v[1] == v[2] || v[2] == v[0])
        return true;
    bool turned = length % 2 == 0;
    return qcMeshParser_PushTriangle(reader->parser, v[turned ? 1 : 0], v[turned ? 0 : 1], v[2]);
}

/// A list may be empty, end with a separator, or have two in a row.
static bool EndStrip(qcPlyReader* reader, int64_t length)
{
    return length == 0 || length >= 3 || qcPly_FailHere(reader, "a strip of fewer than 3 vertices ends here");
}

static bool ReadStrips(qcPlyReader* reader, const qcPlyType* type, int64_t count)
{
    uint32_t last[3] = {0, 0, 0};
    int64_t length = 0;
    for (int64_t i = 0; i < count; ++i)
    {
        int64_t vertex = 0;
        reader->valueIndex = i + 1;
        if (!reader->encoding->nextInteger(reader, type, &vertex))
            return false;
        if (vertex == -1)
        {
            if (!EndStrip(reader, length))
                return false;
            length = 0;
            continue;
        }
        if (!CheckVertex(reader, vertex))
            return false;
        last[0] = last[1];
        last[1] = last[2];
        last[2] = (uint32_t)vertex;
        if (!PushStripTriangle(reader, last, ++length))
            return false;
    }
    if (!EndStrip(reader, length))
        return false;
    reader->valueIndex = 0;
    return true;
}

static bool ReadList(qcPlyReader* reader, const qcPlyProperty* property)
{
    int64_t count = 0;
    if (!reader->encoding->nextInteger(reader, property->countType, &count))
        return false;
    if (property->role == qc_plyCorners)
        return ReadCorners(reader, property->type, count);
    if (count < 0)
        return qcPly_FailHere(reader, "a list of negative length");
    if (property->role == qc_plyStrips)
        return ReadStrips(reader, property->type, count);
    for (int64_t i = 0; i < count; ++i)
    {
        if (!reader->encoding->skip(reader, property->type))
            return false;
    }
    return true;
}

static bool ReadCoordinate(qcPlyReader* reader, const qcPlyType* type, double* value)
{
    if (!qcPlyType_IsInteger(type))
        return reader->encoding->nextReal(reader, type, value);
    int64_t integer = 0;
    if (!reader->encoding->nextInteger(reader, type, &integer))
        return false;
    *value = (double)integer;
    return true;
}

static bool ReadElement(qcPlyReader* reader)
{
    const qcPlyElement* element = reader->element;
    double position[3] = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < element->propertyCount; ++i)
    {
        const qcPlyProperty* property = &reader->properties[element->firstProperty + i];
        bool read;
        if (property->countType != NULL)
            read = ReadList(reader, property);
        else if (property->role != qc_plySkipped)
            read = ReadCoordinate(reader, property->type, &position[property->role]);
        else
            read = reader->encoding->skip(reader, property->type);
        if (!read)
            return false;
    }
    return !element->isVertex || qcMeshParser_PushVertex(reader->parser, position);
}

static bool ReadElements(qcPlyReader* reader)
{
    qcMeshParser* parser = reader->parser;
    bool isText = reader->format == qc_plyAscii;
    reader->encoding = isText ? &qcPlyText : &qcPlyBinary;
    parser->line = isText ? parser->line + 1 : 0;
    for (size_t i = 0; i < reader->elementCount; ++i)
    {
        reader->element = &reader->elements[i];
        for (reader->index = 0; reader->index < reader->element->count; ++reader->index)
        {
            reader->encoding->beginElement(reader);
            if (!ReadElement(reader) || !reader->encoding->endElement(reader))
                return false;
        }
    }
    // Further data means that the header does not fit the data: the values read may be wrong too.
    qcMeshParser_SkipEmptyLines(parser);
    return parser->cursor == parser->end || qcMeshParser_Fail(parser, "more data than the header declares");
}

bool qcReadPly(qcMeshParser* parser)
{
    // Zero but for the parser; large, but not too large for a stack.
    qcPlyReader reader = {.parser = parser};
    return qcPly_ReadHeader(&reader) && ReadElements(&reader);
}
