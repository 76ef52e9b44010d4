// Lattices for the two ends of a motion, and the transforms of BVHs to them.
#include "sweep/bvh/motion_bvhs.h"

#include "base/aabb.h"
#include "sweep/bvh/bvh_lattice.h"
#include "sweep/bvh/lattice_map.h"

#include <math.h>
#include <string.h>

/// A body at one end of a motion.
typedef struct MotionEnd
{
    const qcBody* body;
    const qcTriangleBvh* bvh;
    const qcBvhFit* fit;
    const qcTransform* transform;
    const double *lower, *upper;
} MotionEnd;

static MotionEnd EndOf(const qcBvhOfBody* of, int t)
{
    const qcBody* body = of->body;
    if (t == 1 || !body->start.differs)
        return (MotionEnd){body, of->bvh, &of->bvh->fit, &body->transform, body->lower, body->upper};
    return (MotionEnd){body,
                       of->bvh,
                       qcTriangleBvh_StartFit(of->bvh, body),
                       &body->start.transform,
                       body->start.lower,
                       body->start.upper};
}

/// The box in the world around a body, or around its lattice if that has outliers.
static void GetWorldBox(const MotionEnd* end, double lower[3], double upper[3])
{
    memcpy(lower, end->lower, 3 * sizeof(double));
    memcpy(upper, end->upper, 3 * sizeof(double));
    if (!end->fit->lattice.hasOutliers)
        return;
    const double* extent = end->fit->latticeExtent;
    double centre[3], at[3];
    for (int axis = 0; axis < 3; axis++)
        centre[axis] = end->fit->lattice.origin[axis] + 0.5 * extent[axis];
    qcTransform_Apply(end->transform, false, centre, at);
    for (int axis = 0; axis < 3; axis++)
    {
        const double* row = end->transform->linear + 3 * axis;
        double half = 0.5 * (fabs(row[0]) * extent[0] + fabs(row[1]) * extent[1] + fabs(row[2]) * extent[2]);
        lower[axis] = at[axis] - half;
        upper[axis] = at[axis] + half;
    }
}

/// A lattice with world axes around a body with a local fit.
static qcLatticeTransform LatticeAround(const MotionEnd* end)
{
    qcLatticeTransform lattice = {.hasOutliers = end->fit->lattice.hasOutliers};
    double lower[3], upper[3];
    GetWorldBox(end, lower, upper);
    double widest = qcBounds_Widest(lower, upper);
    memcpy(lattice.origin, lower, sizeof lower);
    int exponent = 0;
    if (widest > 0.0 && isfinite(widest))
        frexp(widest, &exponent);
    for (int axis = 0; axis < 3; axis++)
    {
        lattice.unit[axis] = ldexp(1.0, -exponent);
        lattice.scale[axis] = ldexp(qc_lastLevel, -exponent);
    }
    return lattice;
}

/// Maps one end of a body to the reference lattice.
static bool MapEnd(const MotionEnd* end, const qcLatticeTransform* reference, qcTransformedBvh* at,
                   qcDistanceThresholds* frame)
{
    qcRigidTransform world = {.transform = qcIdentityTransform()}, own = world;
    memcpy(world.lower, end->lower, sizeof world.lower);
    memcpy(world.upper, end->upper, sizeof world.upper);
    memcpy(own.lower, end->fit->isLocal ? end->body->localLower : end->lower, sizeof own.lower);
    memcpy(own.upper, end->fit->isLocal ? end->body->localUpper : end->upper, sizeof own.upper);
    own.transform = end->fit->isLocal ? *end->transform : world.transform;
    // World coordinates aren't rounded, and errors of outliers are larger in proportion.
    if (end->fit->lattice.hasOutliers)
    {
        memset(world.lower, 0, sizeof world.lower);
        memset(world.upper, 0, sizeof world.upper);
        qcBvhLattice_GetBox(&end->fit->lattice, own.lower, own.upper);
    }
    qcRelativeTransform relative = qcRelativeTransform_Find(&world, &own);
    const qcLatticeMap map = {.to = reference,
                              .from = &end->fit->lattice,
                              .relative = &relative,
                              .fromPointError = (double)end->fit->pointError,
                              .rounds = end->fit->isLocal,
                              .transformed = at,
                              .thresholds = frame};
    frame->isTransformed = true;
    return qcLatticeMap_Find(&map);
}

/// Fills both BVHs at one end.
static bool FindEnd(const qcBvhOfBody bvhs[2], bool isOne, int t, qcMotionBvh motions[2])
{
    MotionEnd first = EndOf(&bvhs[0], t);
    qcLatticeTransform reference = first.fit->isLocal ? LatticeAround(&first) : first.fit->lattice;
    float pointError = first.fit->pointError;
    bool hasOutliers = first.fit->lattice.hasOutliers || EndOf(&bvhs[1], t).fit->lattice.hasOutliers;
    bool isExact = true;
    for (int side = 0; side < 2; side++)
    {
        MotionEnd end = EndOf(&bvhs[side], t);
        qcMotionBvh* motion = &motions[side];
        motion->isTransformed = side == 0 ? end.fit->isLocal : !isOne;
        motion->at[t].boxes = qcTriangleBvh_Boxes(end.bvh, end.fit);
        motion->at[t].triangles = (qcIndexedTriangles){end.bvh->corners.data, end.fit->points.data};
        motion->frames[t] = (qcDistanceThresholds){.pointError = end.fit->pointError};
        if (motion->isTransformed)
            isExact = MapEnd(&end, &reference, &motion->at[t], &motion->frames[t]) && isExact;
        pointError = fmaxf(pointError, motion->frames[t].pointError);
    }
    for (int side = 0; side < 2; side++)
    {
        motions[side].frames[t].pointError = pointError;
        motions[side].frames[t].hasOutliers = hasOutliers;
    }
    return isExact;
}

bool qcMotionBvhs_Find(const qcBvhOfBody bvhs[2], bool isOne, qcMotionBvh motions[2])
{
    bool isExact = FindEnd(bvhs, isOne, 0, motions);
    return FindEnd(bvhs, isOne, 1, motions) && isExact;
}
