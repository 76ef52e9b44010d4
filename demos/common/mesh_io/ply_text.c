// Values of a PLY file as text: an element a line.
#include "common/mesh_io/ply.h"

static bool NextWord(qcPlyReader* reader, const char** word, const char** wordEnd)
{
    qcMeshParser* parser = reader->parser;
    const char* p = parser->cursor;
    while (p < parser->end && qcIsBlank(*p))
        ++p;
    *word = p;
    while (p < parser->end && *p != '\n' && !qcIsBlank(*p))
        ++p;
    *wordEnd = p;
    parser->cursor = p;
    if (*word != p)
        return true;
    return qcPly_FailHere(reader, p == parser->end ? "the file ends here" : "the line ends before the last value");
}

static bool Skip(qcPlyReader* reader, const qcPlyType* type)
{
    (void)type;
    const char *word, *wordEnd;
    return NextWord(reader, &word, &wordEnd);
}

static bool NextInteger(qcPlyReader* reader, const qcPlyType* type, int64_t* value)
{
    const char *word, *wordEnd;
    if (!NextWord(reader, &word, &wordEnd))
        return false;
    if (!qcParseInteger(word, wordEnd, value))
        return qcPly_FailWord(reader, word, wordEnd, "is not an integer");
    if (*value < type->lowest || *value > type->highest)
        return qcPly_FailWord(reader, word, wordEnd, "is out of the range of its type");
    return true;
}

static bool NextReal(qcPlyReader* reader, const qcPlyType* type, double* value)
{
    const char *word, *wordEnd;
    if (!NextWord(reader, &word, &wordEnd))
        return false;
    bool isDouble = type->size == sizeof(double);
    return qcMeshParser_ParseCoordinate(reader->parser, isDouble, word, wordEnd, value) ||
           qcPly_FailWord(reader, word, wordEnd, "is not a finite number, or too large for the precision");
}

static void BeginElement(qcPlyReader* reader)
{
    qcMeshParser_SkipEmptyLines(reader->parser);
}

static bool EndElement(qcPlyReader* reader)
{
    qcMeshParser* parser = reader->parser;
    while (parser->cursor < parser->end && qcIsBlank(*parser->cursor))
        ++parser->cursor;
    if (parser->cursor == parser->end || *parser->cursor == '\n')
        return true;
    const char *word, *wordEnd;
    return NextWord(reader, &word, &wordEnd) && qcPly_FailWord(reader, word, wordEnd, "follows the last value");
}

const qcPlyEncoding qcPlyText = {Skip, NextInteger, NextReal, BeginElement, EndElement};
