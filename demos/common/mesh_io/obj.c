// Wavefront OBJ: vertices and faces; every other statement is skipped.
// Wavefront Technologies, Advanced Visualizer Manual, appendix B1, Object Files.
#include "common/mesh_io/mesh_parser.h"

#include <string.h>

typedef struct ObjReader
{
    qcMeshParser* parser;
    uint64_t faceCount;
    /// The largest vertex number in a face so far. Its vertex may follow later, so the range is checked last.
    int64_t largest;
    uint64_t largestFace, largestLine;
} ObjReader;

/// Length of a backslash that joins the next line to this one, with its line end; 0: no such join here.
static size_t GetJointLength(const char* p, const char* end)
{
    if (end - p >= 2 && p[0] == '\\' && p[1] == '\n')
        return 2;
    return end - p >= 3 && p[0] == '\\' && p[1] == '\r' && p[2] == '\n' ? 3 : 0;
}

/// Moves to the next word of a statement. False at a line end or a comment, which end the statement.
static bool NextWord(qcMeshParser* parser, const char** word, const char** wordEnd)
{
    const char* p = parser->cursor;
    size_t joint = 0;
    while (p < parser->end && (qcIsBlank(*p) || (joint = GetJointLength(p, parser->end)) != 0))
    {
        parser->line += joint != 0;
        p += joint != 0 ? joint : 1;
        joint = 0;
    }
    *word = p;
    if (p < parser->end && *p != '#')
    {
        while (p < parser->end && *p != '\n' && !qcIsBlank(*p) && GetJointLength(p, parser->end) == 0)
            ++p;
    }
    *wordEnd = p;
    parser->cursor = p;
    return *word != p;
}

static bool FailWord(qcMeshParser* parser, const char* word, const char* wordEnd, const char* text)
{
    char quoted[40];
    return qcMeshParser_Fail(parser, "'%s' %s", qcQuoteWord(word, wordEnd, quoted, sizeof quoted), text);
}

static bool ReadVertex(qcMeshParser* parser)
{
    const char *word, *wordEnd;
    double position[3];
    int count = 0;
    // A weight or a colour may follow the position; what is no number at all is a damaged line.
    for (; NextWord(parser, &word, &wordEnd); ++count)
    {
        double value;
        if (!qcMeshParser_ParseCoordinate(parser, false, word, wordEnd, &value))
            return FailWord(parser, word, wordEnd, "is not a finite number, or too large for the precision");
        if (count < 3)
            position[count] = value;
    }
    if (count < 3)
        return qcMeshParser_Fail(parser, "a vertex with fewer than 3 coordinates");
    return qcMeshParser_PushVertex(parser, position);
}

/// Parses v, v/vt, v//vn or v/vt/vn. The text behind a slash may be missing; otherwise it must be a number.
static bool ParseCorner(const char* word, const char* wordEnd, int64_t* vertex)
{
    for (int part = 0; part < 3; ++part)
    {
        const char* slash = memchr(word, '/', (size_t)(wordEnd - word));
        const char* partEnd = slash != NULL ? slash : wordEnd;
        int64_t number = 0;
        if ((part == 0 || word != partEnd) && !qcParseInteger(word, partEnd, &number))
            return false;
        if (part == 0)
            *vertex = number;
        if (slash == NULL)
            return true;
        word = slash + 1;
    }
    return false;
}

static bool ReadCorner(ObjReader* reader, const char* word, const char* wordEnd, uint32_t* index)
{
    qcMeshParser* parser = reader->parser;
    int64_t vertex, vertexCount = parser->mesh->vertexCount;
    if (!ParseCorner(word, wordEnd, &vertex))
        return FailWord(parser, word, wordEnd, "is not a corner of a face");
    if (vertex == 0)
        return FailWord(parser, word, wordEnd, "names vertex 0: the first is 1");
    if (vertex < -vertexCount || vertex > UINT32_MAX)
        return FailWord(parser, word, wordEnd, "names a vertex that does not exist");
    if (vertex > reader->largest)
    {
        reader->largest = vertex;
        reader->largestFace = reader->faceCount;
        reader->largestLine = parser->line;
    }
    *index = (uint32_t)(vertex > 0 ? vertex - 1 : vertexCount + vertex);
    return true;
}

static bool ReadFace(ObjReader* reader)
{
    qcMeshParser* parser = reader->parser;
    const char *word, *wordEnd;
    uint32_t first = 0, last = 0;
    int64_t count = 0;
    ++reader->faceCount;
    for (; NextWord(parser, &word, &wordEnd); ++count)
    {
        uint32_t corner = 0;
        if (!ReadCorner(reader, word, wordEnd, &corner))
            return false;
        if (count == 0)
            first = corner;
        else if (count > 1 && !qcMeshParser_PushTriangle(parser, first, last, corner))
            return false;
        last = corner;
    }
    return count >= 3 || qcMeshParser_Fail(parser, "a face with fewer than 3 corners");
}

/// Moves to the next line. A backslash at the end of a comment is just text and joins nothing.
static void EndStatement(qcMeshParser* parser)
{
    const char *word, *wordEnd;
    while (NextWord(parser, &word, &wordEnd))
        continue;
    const char* newline = memchr(parser->cursor, '\n', (size_t)(parser->end - parser->cursor));
    parser->cursor = newline != NULL ? newline + 1 : parser->end;
    parser->line += newline != NULL;
}

/// A block of zeros, as a disk that fails leaves them, would hide the statements behind it in its line. True: none is
/// here; false: the message names the line of the first one.
static bool CheckZeros(qcMeshParser* parser)
{
    const char* zero = memchr(parser->cursor, 0, (size_t)(parser->end - parser->cursor));
    if (zero == NULL)
        return true;
    for (const char* p = parser->cursor; p < zero; ++p)
        parser->line += *p == '\n';
    return qcMeshParser_Fail(parser, "a byte of 0: the file is damaged, or no text");
}

bool qcReadObj(qcMeshParser* parser)
{
    static const char byteOrderMark[] = "\xef\xbb\xbf";
    if (parser->end - parser->cursor >= 3 && memcmp(parser->cursor, byteOrderMark, 3) == 0)
        parser->cursor += 3;
    if (parser->cursor < parser->end && !CheckZeros(parser))
        return false;
    ObjReader reader = {parser, 0, 0, 0, 0};
    for (; parser->cursor < parser->end; EndStatement(parser))
    {
        const char *word, *wordEnd;
        if (!NextWord(parser, &word, &wordEnd) || wordEnd - word != 1)
            continue;
        if (*word == 'v' && !ReadVertex(parser))
            return false;
        if (*word == 'f' && !ReadFace(&reader))
            return false;
    }
    if (reader.faceCount == 0)
        return qcMessage_Fail(parser->message, "%s: no face in the file", parser->name);
    if (reader.largest > (int64_t)parser->mesh->vertexCount)
    {
        parser->line = reader.largestLine;
        return qcMeshParser_Fail(parser, "face %llu: there is no vertex %lld: the last is %u",
                                 (unsigned long long)reader.largestFace, (long long)reader.largest,
                                 parser->mesh->vertexCount);
    }
    return true;
}
