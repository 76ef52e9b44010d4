// Lattices for the two ends of a motion, and the transforms of BVHs to them.
#include "sweep/bvh/motion_bvhs.h"

#include "base/aabb.h"
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

/// A lattice with world axes around the box of a body.
static qcLatticeTransform LatticeAround(const MotionEnd* end)
{
    qcLatticeTransform lattice = {.origin = {0.0}};
    double widest = qcBounds_Widest(end->lower, end->upper);
    memcpy(lattice.origin, end->lower, 3 * sizeof(double));
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
        motions[side].frames[t].pointError = pointError;
    return isExact;
}

bool qcMotionBvhs_Find(const qcBvhOfBody bvhs[2], bool isOne, qcMotionBvh motions[2])
{
    bool isExact = FindEnd(bvhs, isOne, 0, motions);
    return FindEnd(bvhs, isOne, 1, motions) && isExact;
}
