// Cells are marked a cell farther than needed, so that bodies may move for some steps.
#include "sweep/bvh/bvh_region.h"

#include "base/four_floats.h"
#include "base/status.h"
#include "mesh/triangle_sample.h"
#include "scene/float_positions.h"

#include <float.h>
#include <math.h>
#include <string.h>

bool qcBvhRegion_Begin(qcBvhRegion* region, const qcBody* body)
{
    *region = (qcBvhRegion){.revision = body->moved};
    double lower[3], upper[3];
    memcpy(lower, body->lower, sizeof lower);
    memcpy(upper, body->upper, sizeof upper);
    qcTriangleSample sample;
    qcTriangleSample_Take(&sample, body->indices, body->triangleCount, body->world);
    // With outliers nearly all triangles lie in one cell.
    if (qcTriangleSample_Trim(&sample, lower, upper))
        return false;
    if (!qcRegionCells_Begin(&region->cells, body->lower, body->upper))
        return false;
    for (int axis = 0; axis < 3; axis++)
        region->rounding = fmax(region->rounding, FLT_EPSILON * fmax(fabs(body->lower[axis]), fabs(body->upper[axis])));
    return true;
}

void qcBvhRegion_Include(qcBvhRegion* region, const qcBody* other, double queryDistance)
{
    qcRegionCells_Mark(&region->cells, other->lower, other->upper, queryDistance + qcRegionCells_Size(&region->cells));
}

qcStatus qcBvhRegion_SetReference(qcBvhRegion* region, const qcBody* body)
{
    size_t count = 3 * (size_t)body->vertexCount;
    QC_TRY(qcArray_Resize(&region->reference, count, sizeof(float), "positions of a BVH"));
    float* reference = region->reference.data;
    for (size_t i = 0; i < count; i++)
        reference[i] = (float)body->world[i];
    return qc_statusOk;
}

/// The largest difference of two rows of floats.
static double FindFloatDifference(const float* a, const float* b, size_t count)
{
    qcFourFloats low = {0.0f, 0.0f, 0.0f, 0.0f}, high = low;
    size_t i = 0;
    for (; i + 4 <= count; i += 4)
    {
        qcFourFloats difference = qcFourFloats_Load(a + i) - qcFourFloats_Load(b + i);
        low = qcFourFloats_Min(difference, low);
        high = qcFourFloats_Max(difference, high);
    }
    double max = 0.0;
    for (int k = 0; k < 4; k++)
        max = fmax(max, (double)fmaxf(-low[k], high[k]));
    for (; i < count; i++)
        max = fmax(max, fabs((double)a[i] - (double)b[i]));
    // Each difference is rounded.
    return max * (1.0 + (double)FLT_EPSILON);
}

static double FindDifference(const double* a, const float* b, size_t count)
{
    double max = 0.0;
    for (size_t i = 0; i < count; i++)
        max = fmax(max, fabs(a[i] - (double)b[i]));
    return max * (1.0 + DBL_EPSILON);
}

void qcBvhRegion_Follow(qcBvhRegion* region, const qcBody* body)
{
    const float* reference = region->reference.data;
    if (region->revision == body->moved)
        return;
    region->revision = body->moved;
    region->displacement = qcBody_IsInFloats(body)
                               ? FindFloatDifference(body->floats->at, reference, region->reference.count)
                               : FindDifference(body->world, reference, region->reference.count);
}

bool qcBvhRegion_Covers(const qcBvhRegion* region, const qcBody* other, double queryDistance)
{
    return qcRegionCells_AreMarked(&region->cells, other->lower, other->upper,
                                   queryDistance + region->displacement + region->rounding);
}

void qcBvhRegion_Delete(qcBvhRegion* region)
{
    if (region == NULL)
        return;
    qcArray_Free(&region->reference);
    qcFree(region, sizeof *region);
}
