// The order in which a visibility pass is drawn: tile by tile, and within a tile in batches of tests, each followed by
// one draw. Results equal those of the steps one by one, with far fewer changes of GL state.
#ifndef QC_GL_VISIBILITY_TILE_SCHEDULE_H
#define QC_GL_VISIBILITY_TILE_SCHEDULE_H

#include "gl/visibility/occlusion_queries.h"
#include "base/memory.h"

typedef struct qcSchedulePolygon
{
    uint32_t triangle, step;
    uint32_t isCounted; ///< 1: tested as it is rendered, by counting; else 0
} qcSchedulePolygon;

/// One query: a run of the index list.
typedef struct qcScheduleTest
{
    uint32_t step;
    uint32_t polygonCount;
    size_t firstPolygon; ///< in the index list
} qcScheduleTest;

/// Tests with the same depth buffer as in step order, then the polygons drawn after them. Those that overlap are drawn
/// in step order.
typedef struct qcScheduleBatch
{
    size_t firstTest, testCount;
    size_t firstTested, testedCount;   ///< polygons of all tests, in the index list
    size_t firstPolygon, polygonCount; ///< to draw, in the index list
} qcScheduleBatch;

typedef struct qcScheduleTile
{
    uint32_t x, y; ///< first pixel in the image
    size_t firstBatch, batchCount;
    size_t firstTest, testCount;
    size_t firstPolygon, polygonCount, countedCount; ///< of all its batches
} qcScheduleTile;

/// All zero at first; keeps its memory between passes.
typedef struct qcTileSchedule
{
    qcArray indices;  ///< uint32_t: a fan of triangles a polygon
    qcArray polygons; ///< qcSchedulePolygon: those of the index list
    qcArray tests, batches, tiles;
    qcArray tileFirst, entries, runs, order, keys, cells; // scratch
} qcTileSchedule;

/// The triangles and their image.
typedef struct qcScheduleView
{
    const float* corners;    ///< nine floats a triangle, within [-1, 1]
    uint32_t resolution;     ///< pixels on a side of the image
    uint32_t tileSize;       ///< pixels on a side of a tile
    int axis;                ///< of view; the image's x is the next axis in cyclic order
    float dilation[2];       ///< pixels by which a triangle's fragments may lie beyond it, in the image's x and y
    uint32_t polygonCorners; ///< of the polygon drawn for a triangle, consecutive in memory: 3 or more
    /// A triangle that is a step of its own, tested and rendered, is tested by rendering it: in a draw each fragment
    /// meets the depths of the polygons before it. Such tests aren't among those of a batch.
    bool counts;
} qcScheduleView;

/// Indices of a polygon drawn as triangles.
static inline size_t qcTileSchedule_GetIndexCount(uint32_t polygonCorners)
{
    return 3 * ((size_t)polygonCorners - 2);
}

/// Builds the order of a pass. O(triangles times tiles that each covers), plus O(runs times cells that each covers).
qcStatus qcTileSchedule_Build(qcTileSchedule* schedule, const qcScheduleView* view, const qcVisibilityStep* steps,
                              uint32_t stepCount);
void qcTileSchedule_Free(qcTileSchedule* schedule);

#endif
