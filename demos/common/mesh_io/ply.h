// Shared by the parts of the PLY reader: the declared elements, and values as text or in either byte order.
#ifndef QC_DEMOS_COMMON_MESH_IO_PLY_H
#define QC_DEMOS_COMMON_MESH_IO_PLY_H

#include "common/mesh_io/mesh_parser.h"

enum
{
    qc_maxElements = 64,
    qc_maxProperties = 512
};

typedef enum qcPlyFormat
{
    qc_plyAscii,
    qc_plyLittleEndian,
    qc_plyBigEndian
} qcPlyFormat;

typedef struct qcPlyType
{
    const char* name;
    const char* otherName;
    size_t size;
    /// Range of an integer; both 0 for a floating-point type.
    int64_t lowest, highest;
} qcPlyType;

typedef enum qcPlyRole
{
    qc_plySkipped = -1,
    qc_plyX,
    qc_plyY,
    qc_plyZ,
    qc_plyCorners,
    qc_plyStrips
} qcPlyRole;

typedef struct qcPlyProperty
{
    const qcPlyType* type;
    const qcPlyType* countType; ///< of a list, otherwise null
    qcPlyRole role;
} qcPlyProperty;

typedef struct qcPlyElement
{
    char name[40];
    uint64_t count;
    uint64_t line; ///< of its declaration
    size_t firstProperty, propertyCount;
    bool isVertex, isFace, isStrips;
} qcPlyElement;

typedef struct qcPlyReader
{
    qcMeshParser* parser;
    qcPlyFormat format;
    const struct qcPlyEncoding* encoding;
    qcPlyElement elements[qc_maxElements];
    size_t elementCount;
    qcPlyProperty properties[qc_maxProperties];
    size_t propertyCount;
    uint64_t vertexCount;
    // The position of the reader, for messages.
    const qcPlyElement* element;
    uint64_t index;
    int64_t valueIndex; ///< in a list of strips, from 1; otherwise 0
} qcPlyReader;

static inline bool qcPlyType_IsInteger(const qcPlyType* type)
{
    return type->highest != 0;
}

/// Reads the header and checks it against the size of the file; the cursor is then behind it.
bool qcPly_ReadHeader(qcPlyReader* reader);

//  ---- values --------------------------------------------------------------------------------------

/// "name: line 12: vertex 3: text".
bool qcPly_FailHere(qcPlyReader* reader, const char* text);
bool qcPly_FailWord(qcPlyReader* reader, const char* word, const char* wordEnd, const char* text);

/// Reads the next value. False with a message: it is missing, or not of its type.
typedef struct qcPlyEncoding
{
    bool (*skip)(qcPlyReader* reader, const qcPlyType* type);
    bool (*nextInteger)(qcPlyReader* reader, const qcPlyType* type, int64_t* value);
    /// For floating-point types; finite.
    bool (*nextReal)(qcPlyReader* reader, const qcPlyType* type, double* value);
    /// Moves to the next element's values.
    void (*beginElement)(qcPlyReader* reader);
    /// Makes sure that an element's line holds nothing else.
    bool (*endElement)(qcPlyReader* reader);
} qcPlyEncoding;

extern const qcPlyEncoding qcPlyText, qcPlyBinary;

#endif
