// PLY: a header that declares elements and their properties, then their values as text or in either byte order.
// Turk, The PLY Polygon File Format, 1994. Triangle strips as in the files of Stanford's and Georgia Tech's archives:
// an element tristrips whose list holds strips, separated by -1. Every element but vertex, face and tristrips is
// skipped.
#include "common/mesh_io/mesh_parser.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum
{
    qc_maxElements = 64,
    qc_maxProperties = 512,
    qc_maxHeaderWords = 8
};

typedef enum PlyFormat
{
    ply_ascii,
    ply_littleEndian,
    ply_bigEndian
} PlyFormat;

typedef struct PlyType
{
    const char* name;
    const char* otherName;
    size_t size;
    /// Range of an integer; both 0 for a floating-point type.
    int64_t lowest, highest;
} PlyType;

static const PlyType s_types[] = {
    {"char", "int8", 1, INT8_MIN, INT8_MAX},
    {"uchar", "uint8", 1, 0, UINT8_MAX},
    {"short", "int16", 2, INT16_MIN, INT16_MAX},
    {"ushort", "uint16", 2, 0, UINT16_MAX},
    {"int", "int32", 4, INT32_MIN, INT32_MAX},
    {"uint", "uint32", 4, 0, UINT32_MAX},
    {"float", "float32", 4, 0, 0},
    {"double", "float64", 8, 0, 0},
};

typedef enum PlyRole
{
    ply_passedOver = -1,
    ply_x,
    ply_y,
    ply_z,
    ply_corners,
    ply_strips
} PlyRole;

typedef struct PlyProperty
{
    const PlyType* type;
    const PlyType* countType; ///< of a list, otherwise null
    PlyRole role;
} PlyProperty;

typedef struct PlyElement
{
    char name[40];
    uint64_t count;
    uint64_t line; ///< of its declaration
    size_t firstProperty, propertyCount;
    bool isVertex, isFace, isStrips;
} PlyElement;

typedef struct PlyReader
{
    qcMeshParser* parser;
    PlyFormat format;
    PlyElement elements[qc_maxElements];
    size_t elementCount;
    PlyProperty properties[qc_maxProperties];
    size_t propertyCount;
    uint64_t vertexCount;
    //  Where the reader is, for messages.
    const PlyElement* element;
    uint64_t index;
    int64_t place; ///< in a list of strips, from 1; otherwise 0
} PlyReader;

//  ---- header --------------------------------------------------------------------------------------

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
static bool NextHeaderLine(PlyReader* reader, Word words[qc_maxHeaderWords], size_t* count)
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

static const PlyType* FindType(Word word)
{
    for (size_t i = 0; i < sizeof s_types / sizeof s_types[0]; ++i)
    {
        if (IsWord(word, s_types[i].name) || IsWord(word, s_types[i].otherName))
            return &s_types[i];
    }
    return NULL;
}

static bool IsInteger(const PlyType* type)
{
    return type->highest != 0;
}

static bool DeclareFormat(PlyReader* reader, const Word* words, size_t count)
{
    static const char* names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    char quoted[40];
    if (count != 3 || !IsWord(words[2], "1.0"))
        return qcMeshParser_Fail(reader->parser, "expected 'format ascii|binary_little_endian|binary_big_endian 1.0'");
    for (int i = 0; i < 3; ++i)
    {
        if (IsWord(words[1], names[i]))
        {
            reader->format = (PlyFormat)i;
            return true;
        }
    }
    return qcMeshParser_Fail(reader->parser, "unknown format '%s'",
                             qcQuoteWord(words[1].text, words[1].end, quoted, sizeof quoted));
}

static bool DeclareElement(PlyReader* reader, const Word* words, size_t count)
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
    PlyElement* element = &reader->elements[reader->elementCount];
    *element = (PlyElement){.count = (uint64_t)elementCount,
                            .line = reader->parser->line,
                            .firstProperty = reader->propertyCount,
                            .isVertex = IsWord(words[1], "vertex"),
                            .isFace = IsWord(words[1], "face"),
                            .isStrips = IsWord(words[1], "tristrips")};
    qcQuoteWord(words[1].text, words[1].end, element->name, sizeof element->name);
    for (size_t i = 0; i < reader->elementCount; ++i)
    {
        const PlyElement* other = &reader->elements[i];
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

static PlyRole FindRole(const PlyElement* element, const PlyProperty* property, Word name)
{
    bool isList = property->countType != NULL;
    if (element->isVertex && !isList)
    {
        static const char* names[] = {"x", "y", "z"};
        for (int axis = 0; axis < 3; ++axis)
        {
            if (IsWord(name, names[axis]))
                return (PlyRole)axis;
        }
    }
    if (isList && (IsWord(name, "vertex_indices") || IsWord(name, "vertex_index")))
        return element->isFace ? ply_corners : element->isStrips ? ply_strips : ply_passedOver;
    return ply_passedOver;
}

static const PlyProperty* FindProperty(const PlyReader* reader, const PlyElement* element, PlyRole role)
{
    for (size_t i = 0; i < element->propertyCount; ++i)
    {
        const PlyProperty* property = &reader->properties[element->firstProperty + i];
        if (property->role == role)
            return property;
    }
    return NULL;
}

static bool DeclareProperty(PlyReader* reader, const Word* words, size_t count)
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

    PlyElement* element = &reader->elements[reader->elementCount - 1];
    PlyProperty property = {FindType(words[count - 2]), isList ? FindType(words[2]) : NULL, ply_passedOver};
    Word name = words[count - 1];
    property.role = FindRole(element, &property, name);
    qcQuoteWord(name.text, name.end, quoted, sizeof quoted);
    if (isList && !IsInteger(property.countType))
        return qcMeshParser_Fail(parser, "the length of list %s is not of an integer type", quoted);
    if (property.role >= ply_corners && !IsInteger(property.type))
        return qcMeshParser_Fail(parser, "list %s is not of an integer type", quoted);
    if (property.role != ply_passedOver && FindProperty(reader, element, property.role) != NULL)
        return qcMeshParser_Fail(parser, "property %s is declared twice", quoted);
    // A float holds only 24 of an integer's bits.
    if (property.role >= ply_x && property.role <= ply_z &&
        (property.type->size == 8 || (property.type->size == 4 && IsInteger(property.type))))
        parser->mesh->isDouble = true;
    reader->properties[reader->propertyCount++] = property;
    ++element->propertyCount;
    return true;
}

static bool ReadHeader(PlyReader* reader)
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

/// The fewest bytes in which the file can hold one element.
static uint64_t GetLeastSize(const PlyReader* reader, const PlyElement* element)
{
    uint64_t size = 0;
    for (size_t i = 0; i < element->propertyCount; ++i)
    {
        const PlyProperty* property = &reader->properties[element->firstProperty + i];
        // Text: a digit and a blank.
        size += reader->format == ply_ascii   ? 2
                : property->countType != NULL ? property->countType->size
                                              : property->type->size;
    }
    return size;
}

static bool CheckHeader(PlyReader* reader)
{
    qcMeshParser* parser = reader->parser;
    const PlyElement *vertices = NULL, *faces = NULL, *strips = NULL;
    uint64_t remaining = (uint64_t)(parser->end - parser->cursor);
    for (size_t i = 0; i < reader->elementCount; ++i)
    {
        const PlyElement* element = &reader->elements[i];
        vertices = element->isVertex ? element : vertices;
        faces = element->isFace ? element : faces;
        strips = element->isStrips ? element : strips;
        uint64_t leastSize = GetLeastSize(reader, element);
        if (leastSize == 0)
            return qcMessage_Fail(parser->message, "%s: line %llu: element %s has no properties", parser->name,
                                  (unsigned long long)element->line, element->name);
        // One more than the file holds: the last blank may be missing.
        if (element->count > (remaining + 1) / leastSize)
            return qcMessage_Fail(parser->message, "%s: line %llu: the file is too short for %llu elements %s",
                                  parser->name, (unsigned long long)element->line, (unsigned long long)element->count,
                                  element->name);
    }
    if (vertices == NULL || FindProperty(reader, vertices, ply_x) == NULL ||
        FindProperty(reader, vertices, ply_y) == NULL || FindProperty(reader, vertices, ply_z) == NULL)
        return qcMeshParser_Fail(parser, "the header declares no element vertex with properties x, y and z");
    bool hasFaces = faces != NULL && FindProperty(reader, faces, ply_corners) != NULL;
    bool hasStrips = strips != NULL && FindProperty(reader, strips, ply_strips) != NULL;
    if (!hasFaces && !hasStrips)
        return qcMeshParser_Fail(
            parser, "the header declares no element face with a list vertex_indices, and no tristrips with one");
    return qcMeshParser_ReserveVertices(parser, (size_t)vertices->count) &&
           qcMeshParser_ReserveTriangles(parser, hasFaces ? (size_t)faces->count : 0);
}

//  ---- values --------------------------------------------------------------------------------------

typedef struct PlyPlace
{
    char text[80];
} PlyPlace;

static PlyPlace PlaceOf(const PlyReader* reader)
{
    PlyPlace place;
    int length =
        snprintf(place.text, sizeof place.text, "%s %llu", reader->element->name, (unsigned long long)reader->index);
    if (reader->place != 0)
        snprintf(place.text + length, sizeof place.text - (size_t)length, ": value %lld", (long long)reader->place);
    return place;
}

static bool FailHere(PlyReader* reader, const char* text)
{
    return qcMeshParser_Fail(reader->parser, "%s: %s", PlaceOf(reader).text, text);
}

static bool FailWord(PlyReader* reader, Word word, const char* text)
{
    char quoted[40];
    return qcMeshParser_Fail(reader->parser, "%s: '%s' %s", PlaceOf(reader).text,
                             qcQuoteWord(word.text, word.end, quoted, sizeof quoted), text);
}

static bool NextWord(PlyReader* reader, Word* word)
{
    qcMeshParser* parser = reader->parser;
    const char* p = parser->cursor;
    while (p < parser->end && qcIsBlank(*p))
        ++p;
    word->text = p;
    while (p < parser->end && *p != '\n' && !qcIsBlank(*p))
        ++p;
    word->end = p;
    parser->cursor = p;
    if (word->text != p)
        return true;
    return FailHere(reader, p == parser->end ? "the file ends here" : "the line ends before the last value");
}

static bool NextBits(PlyReader* reader, const PlyType* type, uint64_t* bits)
{
    qcMeshParser* parser = reader->parser;
    if ((size_t)(parser->end - parser->cursor) < type->size)
        return FailHere(reader, "the file ends here");
    const unsigned char* bytes = (const unsigned char*)parser->cursor;
    *bits = 0;
    for (size_t i = 0; i < type->size; ++i)
    {
        size_t place = reader->format == ply_littleEndian ? i : type->size - 1 - i;
        *bits |= (uint64_t)bytes[i] << (8 * place);
    }
    parser->cursor += type->size;
    return true;
}

static bool PassOver(PlyReader* reader, const PlyType* type)
{
    Word word;
    uint64_t bits = 0;
    return reader->format == ply_ascii ? NextWord(reader, &word) : NextBits(reader, type, &bits);
}

static bool NextInteger(PlyReader* reader, const PlyType* type, int64_t* value)
{
    if (reader->format == ply_ascii)
    {
        Word word;
        if (!NextWord(reader, &word))
            return false;
        if (!qcParseInteger(word.text, word.end, value))
            return FailWord(reader, word, "is not an integer");
        if (*value < type->lowest || *value > type->highest)
            return FailWord(reader, word, "is out of the range of its type");
        return true;
    }
    uint64_t bits = 0;
    if (!NextBits(reader, type, &bits))
        return false;
    // Wraps a two's complement number of the type's size.
    *value = (int64_t)bits;
    if (*value > type->highest)
        *value -= INT64_C(1) << (8 * type->size);
    return true;
}

static bool NextReal(PlyReader* reader, const PlyType* type, double* value)
{
    if (IsInteger(type))
    {
        int64_t integer = 0;
        if (!NextInteger(reader, type, &integer))
            return false;
        *value = (double)integer;
        return true;
    }
    bool isDouble = type->size == sizeof(double);
    if (reader->format == ply_ascii)
    {
        Word word;
        if (!NextWord(reader, &word))
            return false;
        bool parsed = qcMeshParser_ParseCoordinate(reader->parser, isDouble, word.text, word.end, value);
        return parsed || FailWord(reader, word, "is not a finite number");
    }
    uint64_t bits = 0;
    if (!NextBits(reader, type, &bits))
        return false;
    if (isDouble)
        memcpy(value, &bits, sizeof *value);
    else
    {
        float single;
        uint32_t singleBits = (uint32_t)bits;
        memcpy(&single, &singleBits, sizeof single);
        *value = single;
    }
    return isfinite(*value) || FailHere(reader, "a coordinate is not finite");
}

//  ---- elements ------------------------------------------------------------------------------------

static bool CheckVertex(PlyReader* reader, int64_t vertex)
{
    if (vertex >= 0 && vertex < (int64_t)reader->vertexCount)
        return true;
    return qcMeshParser_Fail(reader->parser, "%s: there is no vertex %lld: the last is %lld", PlaceOf(reader).text,
                             (long long)vertex, (long long)reader->vertexCount - 1);
}

static bool ReadCorners(PlyReader* reader, const PlyType* type, int64_t count)
{
    uint32_t first = 0, last = 0;
    if (count < 3)
        return FailHere(reader, "fewer than 3 corners");
    for (int64_t i = 0; i < count; ++i)
    {
        int64_t corner = 0;
        if (!NextInteger(reader, type, &corner) || !CheckVertex(reader, corner))
            return false;
        if (i == 0)
            first = (uint32_t)corner;
        else if (i > 1 && !qcMeshParser_PushTriangle(reader->parser, first, last, (uint32_t)corner))
            return false;
        last = (uint32_t)corner;
    }
    return true;
}

/// The last three vertices of a strip. Every second triangle is wound the other way. One that names a vertex twice only
/// joins two runs of the strip: it is no triangle of the mesh.
static bool PushStripTriangle(PlyReader* reader, const uint32_t v[3], int64_t length)
{
    if (length < 3 || v[0] == v[1] || v[1] == v[2] || v[2] == v[0])
        return true;
    bool turned = length % 2 == 0;
    return qcMeshParser_PushTriangle(reader->parser, v[turned ? 1 : 0], v[turned ? 0 : 1], v[2]);
}

/// A list may be empty, end with a separator, or have two in a row.
static bool EndStrip(PlyReader* reader, int64_t length)
{
    return length == 0 || length >= 3 || FailHere(reader, "a strip of fewer than 3 vertices ends here");
}

static bool ReadStrips(PlyReader* reader, const PlyType* type, int64_t count)
{
    uint32_t last[3] = {0, 0, 0};
    int64_t length = 0;
    for (int64_t i = 0; i < count; ++i)
    {
        int64_t vertex = 0;
        reader->place = i + 1;
        if (!NextInteger(reader, type, &vertex))
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
    reader->place = 0;
    return true;
}

static bool ReadList(PlyReader* reader, const PlyProperty* property)
{
    int64_t count = 0;
    if (!NextInteger(reader, property->countType, &count))
        return false;
    if (property->role == ply_corners)
        return ReadCorners(reader, property->type, count);
    if (count < 0)
        return FailHere(reader, "a list of negative length");
    if (property->role == ply_strips)
        return ReadStrips(reader, property->type, count);
    for (int64_t i = 0; i < count; ++i)
    {
        if (!PassOver(reader, property->type))
            return false;
    }
    return true;
}

static bool ReadElement(PlyReader* reader)
{
    const PlyElement* element = reader->element;
    double position[3] = {0.0, 0.0, 0.0};
    for (size_t i = 0; i < element->propertyCount; ++i)
    {
        const PlyProperty* property = &reader->properties[element->firstProperty + i];
        bool read;
        if (property->countType != NULL)
            read = ReadList(reader, property);
        else if (property->role != ply_passedOver)
            read = NextReal(reader, property->type, &position[property->role]);
        else
            read = PassOver(reader, property->type);
        if (!read)
            return false;
    }
    return !element->isVertex || qcMeshParser_PushVertex(reader->parser, position);
}

/// Moves over blanks and line ends; there are no lines to count in binary data.
static void SkipEmptyLines(qcMeshParser* parser)
{
    for (; parser->cursor < parser->end && (qcIsBlank(*parser->cursor) || *parser->cursor == '\n'); ++parser->cursor)
        parser->line += parser->line != 0 && *parser->cursor == '\n';
}

/// Makes sure that an element's line holds nothing else.
static bool EndLine(PlyReader* reader)
{
    qcMeshParser* parser = reader->parser;
    while (parser->cursor < parser->end && qcIsBlank(*parser->cursor))
        ++parser->cursor;
    if (parser->cursor == parser->end || *parser->cursor == '\n')
        return true;
    Word word;
    return NextWord(reader, &word) && FailWord(reader, word, "follows the last value");
}

static bool ReadElements(PlyReader* reader)
{
    qcMeshParser* parser = reader->parser;
    bool isText = reader->format == ply_ascii;
    parser->line = isText ? parser->line + 1 : 0;
    for (size_t i = 0; i < reader->elementCount; ++i)
    {
        reader->element = &reader->elements[i];
        for (reader->index = 0; reader->index < reader->element->count; ++reader->index)
        {
            if (isText)
                SkipEmptyLines(parser);
            if (!ReadElement(reader) || (isText && !EndLine(reader)))
                return false;
        }
    }
    // More of it means that the header does not fit the data: what was read may be wrong too.
    SkipEmptyLines(parser);
    return parser->cursor == parser->end || qcMeshParser_Fail(parser, "more data than the header declares");
}

bool qcReadPly(qcMeshParser* parser)
{
    // Zero but for the parser; large, but not too large for a stack.
    PlyReader reader = {.parser = parser};
    return ReadHeader(&reader) && CheckHeader(&reader) && ReadElements(&reader);
}
