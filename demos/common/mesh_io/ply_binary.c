// Values of a PLY file in binary, in either byte order.
#include "common/mesh_io/ply.h"

#include <math.h>
#include <string.h>

static bool NextBits(qcPlyReader* reader, const qcPlyType* type, uint64_t* bits)
{
    qcMeshParser* parser = reader->parser;
    if ((size_t)(parser->end - parser->cursor) < type->size)
        return qcPly_FailHere(reader, "the file ends here");
    const unsigned char* bytes = (const unsigned char*)parser->cursor;
    *bits = 0;
    for (size_t i = 0; i < type->size; ++i)
    {
        size_t significance = reader->format == qc_plyLittleEndian ? i : type->size - 1 - i;
        *bits |= (uint64_t)bytes[i] << (8 * significance);
    }
    parser->cursor += type->size;
    return true;
}

static bool Skip(qcPlyReader* reader, const qcPlyType* type)
{
    uint64_t bits = 0;
    return NextBits(reader, type, &bits);
}

static bool NextInteger(qcPlyReader* reader, const qcPlyType* type, int64_t* value)
{
    uint64_t bits = 0;
    if (!NextBits(reader, type, &bits))
        return false;
    // Wraps a two's complement number of the type's size.
    *value = (int64_t)bits;
    if (*value > type->highest)
        *value -= INT64_C(1) << (8 * type->size);
    return true;
}

static bool NextReal(qcPlyReader* reader, const qcPlyType* type, double* value)
{
    uint64_t bits = 0;
    if (!NextBits(reader, type, &bits))
        return false;
    if (type->size == sizeof(double))
        memcpy(value, &bits, sizeof *value);
    else
    {
        float single;
        uint32_t singleBits = (uint32_t)bits;
        memcpy(&single, &singleBits, sizeof single);
        *value = single;
    }
    return isfinite(*value) || qcPly_FailHere(reader, "a coordinate is not finite");
}

static void BeginElement(qcPlyReader* reader)
{
    (void)reader;
}

static bool EndElement(qcPlyReader* reader)
{
    (void)reader;
    return true;
}

const qcPlyEncoding qcPlyBinary = {Skip, NextInteger, NextReal, BeginElement, EndElement};
