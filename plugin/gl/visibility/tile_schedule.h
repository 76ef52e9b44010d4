// The order in which a visibility pass is drawn: tile by tile, and within a tile in batches of tests that may go
// together, each followed by one draw. Same answers as the steps one by one, far fewer changes of GL state.
#ifndef QC_GL_VISIBILITY_TILE_SCHEDULE_H
#define QC_GL_VISIBILITY_TILE_SCHEDULE_H

#include "gl/visibility/occlusion_queries.h"
#include "base/memory.h"

/// One query: a run of the index list.
typedef struct qcScheduleTest
{
    uint32_t step;
    uint32_t polygonCount;
    size_t firstPolygon; ///< in the index list
} qcScheduleTest;

/// Tests that see the same depth buffer as in their turn, then what is drawn after them.
typedef struct qcScheduleBatch
{
    size_t firstTest, testCount;
    size_t firstPolygon, polygonCount; ///< in the index list
} qcScheduleBatch;

typedef struct qcScheduleTile
{
    uint32_t x, y; ///< of its first pixel in the image
    size_t firstBatch, batchCount;
    size_t firstTest, testCount;
} qcScheduleTile;

/// All zero at first; keeps its memory between passes.
typedef struct qcSchedule
{
    qcArray indices; ///< uint32_t: a fan of triangles a polygon
    qcArray tests, batches, tiles;
    qcArray tileFirst, entries, runs, order, keys, cells; // scratch
} qcSchedule;

/// Where the triangles are, and the image they are seen in.
typedef struct qcScheduleView
{
    const float* corners; ///< nine floats a triangle, within [-1, 1]
    uint32_t resolution;  ///< pixels on a side of the image
    uint32_t tileSize;    ///< pixels on a side of a tile
    int axis;             ///< looked along; the image's x is the next axis in cyclic order
    float reach[2];       ///< pixels by which a triangle's fragments may lie beyond it, in the image's x and y
    /// What is drawn for a triangle is a polygon of this many corners, which lie together: 3 or more.
    uint32_t polygonCorners;
} qcScheduleView;

/// Indices of a polygon drawn as triangles.
static inline size_t qcSchedule_GetIndexCount(uint32_t polygonCorners)
{
    return 3 * ((size_t)polygonCorners - 2);
}

/// O(triangles times tiles that each touches), plus O(runs times cells that each touches).
qcStatus qcSchedule_Build(qcSchedule* schedule, const qcScheduleView* view, const qcVisibilityStep* steps,
                          uint32_t stepCount);
void qcSchedule_Free(qcSchedule* schedule);

#endif
