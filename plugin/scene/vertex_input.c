// A number is finite unless all bits of its exponent are set. Integer tests on the bits let the compiler vectorise.
#include "scene/vertex_input.h"

#include "base/aabb.h"
#include "base/four_floats.h"
#include "base/parallel_for.h"
#include "base/scalar.h"
#include "base/status.h"

#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <string.h>

static size_t SizeOf(qcPositionType type)
{
    return type == qc_positionF64 ? 3 * sizeof(double) : 3 * sizeof(float);
}

static size_t StrideOf(const qcVertexInput* p)
{
    return p->stride != 0 ? p->stride : SizeOf(p->type);
}

static bool IsFinite(const qcVertexInput* p, uint32_t vertex)
{
    const char* at = (const char*)p->data + StrideOf(p) * vertex;
    float single[3];
    double position[3];
    if (p->type == qc_positionF64)
        memcpy(position, at, sizeof position);
    else
    {
        memcpy(single, at, sizeof single);
        for (int axis = 0; axis < 3; axis++)
            position[axis] = (double)single[axis];
    }
    return isfinite(position[0]) && isfinite(position[1]) && isfinite(position[2]);
}

static bool AreFloatsFinite(const char* at, size_t count)
{
    const uint32_t exponent = 0x7f800000u;
    uint32_t bad = 0;
    for (size_t i = 0; i < count; i++)
    {
        uint32_t bits;
        memcpy(&bits, at + 4 * i, sizeof bits);
        bad |= (bits & exponent) == exponent;
    }
    return bad == 0;
}

static bool AreDoublesFinite(const char* at, size_t count)
{
    // The upper half of a double has its exponent.
    const uint64_t exponent = UINT64_C(0x7ff0000000000000);
    uint64_t bad = 0;
    for (size_t i = 0; i < count; i++)
    {
        uint64_t bits;
        memcpy(&bits, at + 8 * i, sizeof bits);
        bad |= (bits & exponent) == exponent;
    }
    return bad == 0;
}

/// A vertex, and the four bytes behind it.
typedef float FourFloats __attribute__((vector_size(16)));
typedef double FourDoubles __attribute__((vector_size(32)));

/// All vertices but the last, behind which the caller's memory may end.
static bool AreSpacedFloatsFinite(const char* at, size_t stride, size_t count)
{
    const qcFourWords exponent = {0x7f800000u, 0x7f800000u, 0x7f800000u, 0};
    qcFourWords bad = {0, 0, 0, 0};
    for (size_t v = 0; v + 1 < count; v++)
    {
        qcFourWords bits;
        memcpy(&bits, at + stride * v, sizeof bits);
        bad |= (qcFourWords)((bits & exponent) == exponent);
    }
    return (bad[0] | bad[1] | bad[2]) == 0;
}

static bool AreAllFinite(const qcVertexInput* p)
{
    if (StrideOf(p) == SizeOf(p->type))
        return p->type == qc_positionF64 ? AreDoublesFinite(p->data, 3 * (size_t)p->count)
                                         : AreFloatsFinite(p->data, 3 * (size_t)p->count);
    if (p->type == qc_positionF32 && StrideOf(p) >= sizeof(qcFourWords))
        return AreSpacedFloatsFinite(p->data, StrideOf(p), p->count) && IsFinite(p, p->count - 1);
    for (uint32_t v = 0; v < p->count; v++)
        if (!IsFinite(p, v))
            return false;
    return true;
}

qcVertexInput qcVertexInput_Block(const qcVertexInput* p, size_t block)
{
    qcVertexInput part = *p;
    size_t first = block * qc_inputBlock, left = p->count - first;
    part.data = (const char*)p->data + StrideOf(p) * first;
    part.count = left < qc_inputBlock ? (uint32_t)left : qc_inputBlock;
    return part;
}

typedef struct Check
{
    const qcVertexInput* input;
    atomic_bool failed;
} Check;

static void CheckBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    Check* check = context;
    const qcVertexInput part = qcVertexInput_Block(check->input, block);
    if (!AreAllFinite(&part))
        atomic_store(&check->failed, true);
}

qcStatus qcVertexInput_CheckLayout(const qcVertexInput* p, uint32_t slot)
{
    if (p->type != qc_positionF32 && p->type != qc_positionF64)
        return qcFail(qc_statusBadInput, "body %u: unknown position type %d", slot, (int)p->type);
    if (p->data == NULL && p->count != 0)
        return qcFail(qc_statusBadInput, "body %u: positions is null", slot);
    if (StrideOf(p) < SizeOf(p->type))
        return qcFail(qc_statusBadInput, "body %u: a stride of %zu bytes is less than a position's %zu", slot,
                      p->stride, SizeOf(p->type));
    return qc_statusOk;
}

qcStatus qcVertexInput_FailNotFinite(const qcVertexInput* p, uint32_t slot)
{
    uint32_t vertex = 0;
    while (IsFinite(p, vertex))
        vertex++;
    return qcFail(qc_statusBadInput, "vertex %u of body %u is not finite", vertex, slot);
}

qcStatus qcVertexInput_Check(const qcVertexInput* p, uint32_t slot, uint32_t threads)
{
    QC_TRY(qcVertexInput_CheckLayout(p, slot));
    Check check = {.input = p};
    qcParallel_For(threads, qcVertexInput_BlockCount(p), qc_minInputBlocks, CheckBlock, &check);
    return atomic_load(&check.failed) ? qcVertexInput_FailNotFinite(p, slot) : qc_statusOk;
}

/// Writes four numbers a vertex; the next vertex overwrites the fourth.
static void ReadSpacedFloats(const char* at, size_t stride, size_t count, double* out)
{
    size_t v = 0;
    for (; v + 1 < count && stride >= sizeof(FourFloats); v++)
    {
        FourFloats x;
        memcpy(&x, at + stride * v, sizeof x);
        FourDoubles wide = __builtin_convertvector(x, FourDoubles);
        memcpy(out + 3 * v, &wide, sizeof wide);
    }
    for (; v < count; v++)
    {
        float x[3];
        memcpy(x, at + stride * v, sizeof x);
        for (size_t axis = 0; axis < 3; axis++)
            out[3 * v + axis] = (double)x[axis];
    }
}

void qcVertexInput_Read(const qcVertexInput* p, double* out)
{
    size_t stride = StrideOf(p);
    const char* at = p->data;
    if (p->count == 0)
        return;
    // Tightly packed: one run of numbers.
    if (p->type == qc_positionF32 && stride == 3 * sizeof(float))
        for (size_t i = 0; i < 3 * (size_t)p->count; i++)
        {
            float x;
            memcpy(&x, at + 4 * i, sizeof x);
            out[i] = (double)x;
        }
    else if (p->type == qc_positionF32)
        ReadSpacedFloats(at, stride, p->count, out);
    else if (stride == 3 * sizeof(double))
        memcpy(out, at, stride * p->count);
    else
        for (size_t v = 0; v < p->count; v++)
            memcpy(out + 3 * v, at + stride * v, 3 * sizeof(double));
}

/// Eight vertices at a time, in one pass over memory. Returns how many vertices are done.
static size_t CopyEights(const char* from, size_t count, float* out, double lower[3], double upper[3], bool* finite)
{
    qcFourFloats low[3], high[3];
    qcFourWords unordered = {0, 0, 0, 0};
    const size_t eights = count / 8;
    for (int k = 0; k < 3; k++)
    {
        low[k] = FLT_MAX - (qcFourFloats){0};
        high[k] = -low[k];
    }
    for (size_t i = 0; i < eights; i++)
        for (size_t k = 0; k < 3; k++)
        {
            qcFourFloats x = qcFourFloats_Load(from + 16 * (6 * i + k));
            qcFourFloats y = qcFourFloats_Load(from + 16 * (6 * i + 3 + k));
            unordered |= qcFourFloats_AreUnordered(x, y);
            low[k] = qcFourFloats_Min(qcFourFloats_Min(low[k], x), y);
            high[k] = qcFourFloats_Max(qcFourFloats_Max(high[k], x), y);
            qcFourFloats_Store(x, out + 4 * (6 * i + k));
            qcFourFloats_Store(y, out + 4 * (6 * i + 3 + k));
        }
    *finite = (unordered[0] | unordered[1] | unordered[2] | unordered[3]) == 0;
    double lowest[3] = {FLT_MAX, FLT_MAX, FLT_MAX}, highest[3] = {-FLT_MAX, -FLT_MAX, -FLT_MAX};
    for (int k = 0; k < 12; k++)
    {
        lowest[k % 3] = qcMin((double)low[k / 4][k % 4], lowest[k % 3]);
        highest[k % 3] = qcMax((double)high[k / 4][k % 4], highest[k % 3]);
    }
    // Where all are numbers, an infinite one is among the bounds.
    for (int axis = 0; axis < 3; axis++)
        *finite = *finite && isfinite(lowest[axis]) && isfinite(highest[axis]);
    if (eights != 0)
        qcBounds_IncludeBox(lowest, highest, lower, upper);
    return 8 * eights;
}

bool qcVertexInput_ReadFloats(const qcVertexInput* p, float* out, double lower[3], double upper[3])
{
    const size_t stride = StrideOf(p);
    bool finite = true;
    size_t v = stride == SizeOf(p->type) ? CopyEights(p->data, p->count, out, lower, upper, &finite) : 0;
    const size_t done = v;
    for (; v < p->count; v++)
        memcpy(out + 3 * v, (const char*)p->data + stride * v, 3 * sizeof(float));
    qcBounds_IncludeFloats(out + 3 * done, p->count - done, lower, upper);
    return AreFloatsFinite((const char*)(out + 3 * done), 3 * (p->count - done)) && finite;
}
