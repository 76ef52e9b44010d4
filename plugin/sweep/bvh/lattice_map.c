// Transforms between lattices, in double; rounded to floats for the kernels. Proof: plugin/docs/proofs/bvh_pairs.md.
#include "sweep/bvh/lattice_map.h"

#include <math.h>

/// The error of a transform in levels. Floats round each number and each operation by 2^-24 of the operands, at most
/// eight times; this allows 16 times, and 2^-4 of a level for levels as the kernels compute them.
static float FindGrowth(double sizes, double error)
{
    double grow = 0x1p-20 * sizes + 0x1p-4 + error;
    // Numbers that are too large for floats, or whose products may overflow, make boxes that overlap everything.
    return grow < 0x1p80 ? nextafterf((float)grow, INFINITY) : INFINITY;
}

/// Row i: back to coordinates of the first, then to coordinates of the second, then to its lattice and frame.
/// Coordinates of points, in units of their frame, are 1 at most. False: the result is too inexact for the filter.
static bool FindTransformRow(const qcLatticeMap* map, int i)
{
    const qcLatticeTransform *to = map->to, *from = map->from;
    const qcRelativeTransform* r = map->relative;
    qcBoxTransform *levels = &map->transformed->levels, *points = &map->transformed->points;
    const double half = 32768.0;
    double origin = r->shift[i] - to->origin[i], level = 0.0, levelSizes = 0.0, pointSizes = 0.0, ratios = 0.0;
    for (int k = 0; k < 3; k++)
        origin += r->linear[i][k] * from->origin[k];
    for (int k = 0; k < 3; k++)
    {
        double scale = to->scale[i] * r->linear[i][k] / from->scale[k];
        double pointScale = to->scale[i] * r->linear[i][k] / from->unit[k];
        double ratio = to->unit[i] * r->linear[i][k] / from->unit[k];
        levels->linear[i][k] = (float)scale;
        points->linear[i][k] = (float)pointScale;
        map->thresholds->linear[i][k] = (float)ratio;
        level += half * scale;
        levelSizes += 2.0 * half * fabs(scale);
        pointSizes += fabs(pointScale);
        ratios += fabs(ratio);
    }
    double offset = origin * to->scale[i], at = origin * to->unit[i];
    double rounding = map->rounds ? r->error[i] : 0.0;
    double margin = map->query * r->reach[i] * (1.0 + 1e-8);
    levels->shift[i] = (float)(offset + level);
    levels->grow[i] =
        FindGrowth(fabs(offset) + levelSizes, to->scale[i] * (rounding + (map->growsBoxes ? margin : 0.0)));
    points->shift[i] = (float)offset;
    points->grow[i] =
        FindGrowth(fabs(offset) + pointSizes, to->scale[i] * (rounding + margin) + pointSizes * map->fromPointError);
    map->thresholds->shift[i] = (float)at;
    double error = (12.0 * ratios + 6.0 * fabs(at)) * 0x1p-24 + rounding * to->unit[i];
    map->thresholds->pointError = fmaxf(map->thresholds->pointError, nextafterf((float)error, INFINITY));
    return error < 1e6;
}

bool qcLatticeMap_Find(const qcLatticeMap* map)
{
    bool isExact = true;
    map->transformed->levels.isDiagonal = map->transformed->points.isDiagonal = !map->rounds;
    map->transformed->levels.hasOutliers = map->transformed->points.hasOutliers = map->from->hasOutliers;
    map->thresholds->hasOutliers |= map->from->hasOutliers;
    for (int i = 0; i < 3; i++)
        isExact = FindTransformRow(map, i) && isExact;
    return isExact;
}
