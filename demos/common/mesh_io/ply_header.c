// The header of a PLY file: its format, and the elements with their properties.
#include "common/mesh_io/ply.h"

#include <string.h>

enum
{
    qc_maxHeaderWords = 8
};

static const qcPlyType s_types[] = {
    {"char", "int8", 1, INT8_MIN, INT8_MAX},
    {"uchar", "uint8", 1, 0, UINT8_MAX},
    {"short", "int16", 2, INT16_MIN, INT16_MAX},
    {"ushort", "uint16", 2, 0, UINT16_MAX},
    {"int", "int32", 4, INT32_MIN, INT32_MAX},
    {"uint", "uint32", 4, 0, UINT32_MAX},
    {"float", "float32", 4, 0, 0},
    {"double", "float64", 8, 0, 0},
};

typedef struct Word
{
    const char* text;
    const char* end;
} Word;

static bool IsWord(Word word, const char* text)
{
    size_t length = strlen(text);
    return (size_t)(word.end - word.text) == length && memcmp(word.text, text, length) == 0;
}

/// Splits the line at the cursor and moves behind it. False at the end of the file, where no newline ends the line.
static bool NextHeaderLine(qcPlyReader* reader, Word words[qc_maxHeaderWords], size_t* count)
{
    qcMeshParser* parser = reader->parser;
    *count = 0;
    const char* newline = memchr(parser->cursor, '\n', (size_t)(parser->end - parser->cursor));
    if (newline == NULL)
        return qcMeshParser_Fail(parser, "the file ends inside the header");
    const char* p = parser->cursor;
    for (;;)
    {
        while (p < newline && qcIsBlank(*p))
            ++p;
        if (p == newline || *count == qc_maxHeaderWords)
            break;
        Word word = {p, p};
        while (word.end < newline && !qcIsBlank(*word.end))
            ++word.end;
        words[(*count)++] = word;
        p = word.end;
    }
    parser->cursor = newline + 1;
    return true;
}

static const qcPlyType* FindType(Word word)
{
    for (size_t i = 0; i < sizeof s_types / sizeof s_types[0]; ++i)
    {
        if (IsWord(word, s_types[i].name) || IsWord(word, s_types[i].otherName))
            return &s_types[i];
    }
    return NULL;
}

static bool DeclareFormat(qcPlyReader* reader, const Word* words, size_t count)
{
    static const char* names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    char quoted[40];
    if (count != 3 || !IsWord(words[2], "1.0"))
        return qcMeshParser_Fail(reader->parser, "expected 'format ascii|binary_little_endian|binary_big_endian 1.0'");
    for (int i = 0; i < 3; ++i)
    {
        if (IsWord(words[1], names[i]))
        {
            reader->format = (qcPlyFormat)i;
            return true;
        }
    }
    return qcMeshParser_Fail(reader->parser, "unknown format '%s'",
                             qcQuoteWord(words[1].text, words[1].end, quoted, sizeof quoted));
}

static bool DeclareElement(qcPlyReader* reader, const Word* words, size_t count)
{
    char quoted[40];
    int64_t elementCount;
    if (count != 3)
        return qcMeshParser_Fail(reader->parser, "expected 'element NAME COUNT'");
    if (!qcParseInteger(words[2].text, words[2].end, &elementCount) || elementCount < 0)
        return qcMeshParser_Fail(reader->parser, "'%s' is not a count",
                                 qcQuoteWord(words[2].text, words[2].end, quoted, sizeof quoted));
    if (reader->elementCount == qc_maxElements)
        return qcMeshParser_Fail(reader->parser, "more than %d elements", qc_maxElements);
    qcPlyElement* element = &reader->elements[reader->elementCount];
    *element = (qcPlyElement){.count = (uint64_t)elementCount,
                              .line = reader->parser->line,
                              .firstProperty = reader->propertyCount,
                              .isVertex = IsWord(words[1], "vertex"),
                              .isFace = IsWord(words[1], "face"),
                              .isStrips = IsWord(words[1], "tristrips")};
    qcQuoteWord(words[1].text, words[1].end, element->name, sizeof element->name);
    for (size_t i = 0; i < reader->elementCount; ++i)
    {
        const qcPlyElement* other = &reader->elements[i];
        if ((element->isVertex && other->isVertex) || (element->isFace && other->isFace) ||
            (element->isStrips && other->isStrips))
            return qcMeshParser_Fail(reader->parser, "element %s is declared twice", element->name);
    }
    if (element->isVertex && elementCount > UINT32_MAX)
        return qcMeshParser_Fail(reader->parser, "more than %u vertices", UINT32_MAX);
    if (element->isVertex)
        reader->vertexCount = element->count;
    ++reader->elementCount;
    return true;
}

static qcPlyRole FindRole(const qcPlyElement* element, const qcPlyProperty* property, Word name)
{
    bool isList = property->countType != NULL;
    if (element->isVertex && !isList)
    {
        static const char* names[] = {"x", "y", "z"};
        for (int axis = 0; axis < 3; ++axis)
        {
            if (IsWord(name, names[axis]))
                return (qcPlyRole)axis;
        }
    }
    if (isList && (IsWord(name, "vertex_indices") || IsWord(name, "vertex_index")))
        return element->isFace ? qc_plyCorners : element->isStrips ? qc_plyStrips : qc_plySkipped;
    return qc_plySkipped;
}

static const qcPlyProperty* FindProperty(const qcPlyReader* reader, const qcPlyElement* element, qcPlyRole role)
{
    for (size_t i = 0; i < element->propertyCount; ++i)
    {
        const qcPlyProperty* property = &reader->properties[element->firstProperty + i];
        if (property->role == role)
            return property;
    }
    return NULL;
}

static bool DeclareProperty(qcPlyReader* reader, const Word* words, size_t count)
{
    qcMeshParser* parser = reader->parser;
    char quoted[40];
    bool isList = count > 1 && IsWord(words[1], "list");
    if (count != (isList ? 5 : 3))
        return qcMeshParser_Fail(parser, "expected 'property TYPE NAME' or 'property list TYPE TYPE NAME'");
    if (reader->elementCount == 0)
        return qcMeshParser_Fail(parser, "a property before the first element");
    if (reader->propertyCount == qc_maxProperties)
        return qcMeshParser_Fail(parser, "more than %d properties", qc_maxProperties);
    for (size_t i = isList ? 2 : 1; i < count - 1; ++i)
    {
        if (FindType(words[i]) == NULL)
            return qcMeshParser_Fail(parser, "unknown type '%s'",
                                     qcQuoteWord(words[i].text, words[i].end, quoted, sizeof quoted));
    }

    qcPlyElement* element = &reader->elements[reader->elementCount - 1];
    qcPlyProperty property = {FindType(words[count - 2]), isList ? FindType(words[2]) : NULL, qc_plySkipped};
    Word name = words[count - 1];
    property.role = FindRole(element, &property, name);
    qcQuoteWord(name.text, name.end, quoted, sizeof quoted);
    if (isList && !qcPlyType_IsInteger(property.countType))
        return qcMeshParser_Fail(parser, "the length of list %s is not of an integer type", quoted);
    if (property.role >= qc_plyCorners && !qcPlyType_IsInteger(property.type))
        return qcMeshParser_Fail(parser, "list %s is not of an integer type", quoted);
    if (property.role != qc_plySkipped && FindProperty(reader, element, property.role) != NULL)
        return qcMeshParser_Fail(parser, "property %s is declared twice", quoted);
    // A float holds only 24 of an integer's bits.
    if (property.role >= qc_plyX && property.role <= qc_plyZ &&
        (property.type->size == 8 || (property.type->size == 4 && qcPlyType_IsInteger(property.type))))
        parser->mesh->isDouble = true;
    reader->properties[reader->propertyCount++] = property;
    ++element->propertyCount;
    return true;
}

static bool ReadHeader(qcPlyReader* reader)
{
    qcMeshParser* parser = reader->parser;
    Word words[qc_maxHeaderWords];
    size_t count;
    if (parser->cursor == parser->end)
        return qcMessage_Fail(parser->message, "%s: the file is empty", parser->name);
    if (!NextHeaderLine(reader, words, &count))
        return false;
    if (count != 1 || !IsWord(words[0], "ply"))
        return qcMeshParser_Fail(parser, "expected 'ply'");
    bool hasFormat = false;
    for (;;)
    {
        ++parser->line;
        if (!NextHeaderLine(reader, words, &count))
            return false;
        bool read = true;
        char quoted[40];
        if (count == 0 || IsWord(words[0], "comment") || IsWord(words[0], "obj_info"))
            continue;
        if (IsWord(words[0], "end_header"))
            break;
        if (IsWord(words[0], "format"))
        {
            read = DeclareFormat(reader, words, count);
            hasFormat = true;
        }
        else if (IsWord(words[0], "element"))
            read = DeclareElement(reader, words, count);
        else if (IsWord(words[0], "property"))
            read = DeclareProperty(reader, words, count);
        else
            read = qcMeshParser_Fail(parser, "unknown word '%s' in the header",
                                     qcQuoteWord(words[0].text, words[0].end, quoted, sizeof quoted));
        if (!read)
            return false;
    }
    return hasFormat || qcMeshParser_Fail(parser, "the header names no format");
}

/// The minimum size of an element in the file, in bytes.
static uint64_t GetMinSize(const qcPlyReader* reader, const qcPlyElement* element)
{
    uint64_t size = 0;
    for (size_t i = 0; i < element->propertyCount; ++i)
    {
        const qcPlyProperty* property = &reader->properties[element->firstProperty + i];
        // Text: a digit and a blank.
        size += reader->format == qc_plyAscii ? 2
                : property->countType != NULL ? property->countType->size
                                              : property->type->size;
    }
    return size;
}

static bool CheckHeader(qcPlyReader* reader)
{
    qcMeshParser* parser = reader->parser;
    const qcPlyElement *vertices = NULL, *faces = NULL, *strips = NULL;
    uint64_t remaining = (uint64_t)(parser->end - parser->cursor);
    for (size_t i = 0; i < reader->elementCount; ++i)
    {
        const qcPlyElement* element = &reader->elements[i];
        vertices = element->isVertex ? element : vertices;
        faces = element->isFace ? element : faces;
        strips = element->isStrips ? element : strips;
        uint64_t minSize = GetMinSize(reader, element);
        if (minSize == 0)
            return qcMessage_Fail(parser->message, "%s: line %llu: element %s has no properties", parser->name,
                                  (unsigned long long)element->line, element->name);
        // One more than the file holds: the last blank may be missing.
        if (element->count > (remaining + 1) / minSize)
            return qcMessage_Fail(parser->message, "%s: line %llu: the file is too short for %llu elements %s",
                                  parser->name, (unsigned long long)element->line, (unsigned long long)element->count,
                                  element->name);
    }
    if (vertices == NULL || FindProperty(reader, vertices, qc_plyX) == NULL ||
        FindProperty(reader, vertices, qc_plyY) == NULL || FindProperty(reader, vertices, qc_plyZ) == NULL)
        return qcMeshParser_Fail(parser, "the header declares no element vertex with properties x, y and z");
    bool hasFaces = faces != NULL && FindProperty(reader, faces, qc_plyCorners) != NULL;
    bool hasStrips = strips != NULL && FindProperty(reader, strips, qc_plyStrips) != NULL;
    if (!hasFaces && !hasStrips)
        return qcMeshParser_Fail(
            parser, "the header declares no element face with a list vertex_indices, and no tristrips with one");
    return qcMeshParser_ReserveVertices(parser, (size_t)vertices->count) &&
           qcMeshParser_ReserveTriangles(parser, hasFaces ? (size_t)faces->count : 0);
}

bool qcPly_ReadHeader(qcPlyReader* reader)
{
    return ReadHeader(reader) && CheckHeader(reader);
}
