// Shared by the PLY and the OBJ reader: a cursor with its line, and a mesh that grows.
#ifndef QC_DEMOS_COMMON_MESH_IO_MESH_PARSER_H
#define QC_DEMOS_COMMON_MESH_IO_MESH_PARSER_H

#include "common/mesh_io/mesh_file.h"

typedef struct qcMeshParser
{
    const char* name;
    const char* cursor;
    const char* end;
    uint64_t line; ///< of the cursor, from 1; 0 in binary data
    qcMeshPrecision precision;
    qcMesh* mesh;
    size_t vertexCapacity, triangleCapacity;
    qcMessage* message;
} qcMeshParser;

/// Keeps "name: line 12: ..." (without the line in binary data). Returns false.
__attribute__((format(printf, 2, 3))) bool qcMeshParser_Fail(qcMeshParser* parser, const char* format, ...);

/// Makes room for as many vertices or triangles in all; false: out of memory, with a message.
bool qcMeshParser_ReserveVertices(qcMeshParser* parser, size_t count);
bool qcMeshParser_ReserveTriangles(qcMeshParser* parser, size_t count);
bool qcMeshParser_PushVertex(qcMeshParser* parser, const double position[3]);
bool qcMeshParser_PushTriangle(qcMeshParser* parser, uint32_t a, uint32_t b, uint32_t c);

/// A number that fills [text, end), as a double if it is declared as one or the precision is qc_meshDouble,
/// otherwise as a float.
/// False: something else, or not finite.
bool qcMeshParser_ParseCoordinate(const qcMeshParser* parser, bool isDouble, const char* text, const char* end,
                                  double* value);

bool qcReadPly(qcMeshParser* parser);
bool qcReadObj(qcMeshParser* parser);

/// True for characters that separate words; a line end is not among them.
static inline bool qcIsBlank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

/// Moves over blanks and line ends; binary data has no lines to count.
void qcMeshParser_SkipEmptyLines(qcMeshParser* parser);

/// A word of the file, for messages: at most `size` - 1 bytes, unprintable ones as '?'. Returns `buffer`.
const char* qcQuoteWord(const char* word, const char* end, char* buffer, size_t size);

/// A decimal number that fills [text, end), rounded to nearest; infinite if too large. False: something else.
bool qcParseFloat(const char* text, const char* end, float* value);
bool qcParseDouble(const char* text, const char* end, double* value);
/// A decimal integer of at most 18 digits that fills [text, end).
bool qcParseInteger(const char* text, const char* end, int64_t* value);

#endif
