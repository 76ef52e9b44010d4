// Ray and swept-box casts against a set of boxes. Slabs: Kay, Kajiya: Ray tracing complex scenes, 1986.
// Proof that no box is missed: plugin/docs/proofs/box_casts.md.
#include "broadphase/box_query.h"

#include "base/scalar.h"

#include <float.h>
#include <math.h>

/// 16 u, u = 2^-53: see the proof.
#define QC_CAST_TOLERANCE 0x1p-49

typedef struct Cast
{
    double from[3], castLower[3], castUpper[3];
    double pathLower[3], pathUpper[3]; ///< AABB of the whole path
    double inverse[3];                 ///< of the direction; 0: no slab in this axis
    double magnitude[3];               ///< |from| + the larger cast extent: scales the rounding error
    const double* fraction;
    qcFloatCast floats; ///< the same, for the boxes of the forest
} Cast;

/// A float that is at most the number minus the origin; NaN is unbounded. Faster than the largest such float. A number
/// above all floats becomes infinite, as does the upper bound of every box that reaches it.
static float FloatBelow(double number, double origin)
{
    double at = number - origin;
    if (at == INFINITY)
        return INFINITY;
    return isnan(at) ? -INFINITY : (float)(at - 0x1p-22 * fabs(at) - 0x1p-51 * fabs(origin) - (double)FLT_MIN);
}

static float FloatAbove(double number, double origin)
{
    double at = number - origin;
    if (at == -INFINITY)
        return -INFINITY;
    return isnan(at) ? INFINITY : (float)(at + 0x1p-22 * fabs(at) + 0x1p-51 * fabs(origin) + (double)FLT_MIN);
}

static void PrepareFloats(Cast* cast, double origin, int k)
{
    qcFloatCast* floats = &cast->floats;
    floats->path.lower[k] = FloatBelow(cast->pathLower[k], origin);
    floats->path.upper[k] = FloatAbove(cast->pathUpper[k], origin);
    floats->lowerOffset[k] = FloatAbove(cast->from[k] + cast->castUpper[k], origin);
    floats->upperOffset[k] = FloatBelow(cast->from[k] + cast->castLower[k], origin);
    double inverse = fabs(cast->inverse[k]);
    bool isSlab = inverse >= (double)FLT_MIN && inverse <= (double)FLT_MAX && isfinite(floats->lowerOffset[k]) &&
                  isfinite(floats->upperOffset[k]);
    floats->inverse[k] = isSlab ? (float)cast->inverse[k] : 0.0f;
}

__attribute__((noinline)) static void PrepareCast(const qcBoxes* boxes, const double from[3], const double to[3],
                                                  const double castLower[3], const double castUpper[3],
                                                  const double* fraction, Cast* cast)
{
    static const double wholePath = 1.0;
    cast->fraction = fraction != NULL ? fraction : &wholePath;
    for (int k = 0; k < 3; k++)
    {
        cast->from[k] = from[k];
        cast->castLower[k] = castLower[k];
        cast->castUpper[k] = castUpper[k];
        // NaN in both bounds of the path and no slab: then no comparison rejects a box.
        bool unbounded = isnan(from[k]) || isnan(to[k]) || isnan(castLower[k]) || isnan(castUpper[k]);
        cast->pathLower[k] = unbounded ? NAN : qcMin(from[k], to[k]) + castLower[k];
        cast->pathUpper[k] = unbounded ? NAN : qcMax(from[k], to[k]) + castUpper[k];
        double direction = to[k] - from[k], length = fabs(direction);
        bool isSlab = !unbounded && length >= DBL_MIN && length <= 0x1p1021;
        cast->inverse[k] = isSlab ? 1.0 / direction : 0.0;
        cast->magnitude[k] = fabs(from[k]) + qcMax(fabs(castLower[k]), fabs(castUpper[k]));
        PrepareFloats(cast, boxes->origin.at[k], k);
    }
}

/// Slab test. `*entry`: a lower bound of the fraction of the path at which the box is hit.
static bool HitsBounds(const Cast* cast, const double lower[3], const double upper[3], double* entry)
{
    double enter = 0.0, leave = *cast->fraction;
    for (int k = 0; k < 3; k++)
    {
        if (lower[k] > cast->pathUpper[k] || upper[k] < cast->pathLower[k])
            return false;
        double inverse = cast->inverse[k];
        if (inverse == 0.0)
            continue;
        double low = lower[k] - cast->castUpper[k] - cast->from[k] - 0x1p-51 * (fabs(lower[k]) + cast->magnitude[k]);
        double high = upper[k] - cast->castLower[k] - cast->from[k] + 0x1p-51 * (fabs(upper[k]) + cast->magnitude[k]);
        double near = (inverse > 0.0 ? low : high) * inverse, far = (inverse > 0.0 ? high : low) * inverse;
        if (near > enter)
            enter = near;
        if (far < leave)
            leave = far;
    }
    *entry = enter;
    return !(enter > leave + QC_CAST_TOLERANCE);
}

/// A node of a tree, or a box, that the cast hits.
typedef struct CastNode
{
    const qcBoxTree* tree; ///< null: a box
    uint32_t level, octet; ///< a box: its id in `octet`
    double entry;
} CastNode;

enum
{
    // Octets of the list whose boxes are sorted together, by entry.
    qc_listStep = 8,
    // A popped node pushes at most eight of the level below; or boxes of the list lie there.
    qc_castStack = 7 * qc_treeLevels + 1 + qc_lanes * qc_listStep
};

typedef struct CastStack
{
    CastNode nodes[qc_castStack];
    uint32_t count;
} CastStack;

/// Insertion sort of the nodes from `first` on: the nearest is popped first.
static void SortNearestLast(CastStack* stack, uint32_t first)
{
    for (uint32_t i = first + 1; i < stack->count; i++)
    {
        CastNode node = stack->nodes[i];
        uint32_t at = i;
        for (; at > first && stack->nodes[at - 1].entry < node.entry; at--)
            stack->nodes[at] = stack->nodes[at - 1];
        stack->nodes[at] = node;
    }
}

/// Pushes a box if it is hit. Its entry is tested anew: the AABB in the forest may be larger and hit earlier.
static void PushBox(const qcBoxes* boxes, const Cast* cast, CastStack* stack, uint32_t id)
{
    qcBounds bounds = qcBoxes_Bounds(boxes, id);
    CastNode node = {NULL, 0, id, 0.0};
    if (HitsBounds(cast, bounds.lower, bounds.upper, &node.entry))
        stack->nodes[stack->count++] = node;
}

/// The lanes of an octet that may be hit, and when.
static uint32_t CastOctet(const qcBoxes* boxes, const Cast* cast, const qcOctet* octet, float entries[qc_lanes])
{
    // Rounding to nearest is within the tolerance.
    return boxes->forest.kernels->cast(octet, &cast->floats, (float)*cast->fraction, entries);
}

/// Pushes the children of a node that are hit.
static void PushChildren(const qcBoxes* boxes, const Cast* cast, CastStack* stack, const CastNode* parent)
{
    const qcOctetTree* shape = &parent->tree->shape;
    uint32_t first = stack->count;
    float entries[qc_lanes];
    uint32_t lanes = CastOctet(boxes, cast, &shape->octets[shape->first[parent->level] + parent->octet], entries);
    for (; lanes != 0; lanes &= lanes - 1)
    {
        uint32_t lane = (uint32_t)__builtin_ctz(lanes), below = qc_lanes * parent->octet + lane;
        if (parent->level == 0)
            PushBox(boxes, cast, stack, QC_AT(uint32_t, parent->tree->ids, below));
        else
            stack->nodes[stack->count++] = (CastNode){parent->tree, parent->level - 1, below, (double)entries[lane]};
    }
    SortNearestLast(stack, first);
}

/// Pushes the boxes of an octet of the list that are hit.
static void PushListed(const qcBoxes* boxes, const Cast* cast, CastStack* stack, size_t octet)
{
    const qcForest* forest = &boxes->forest;
    float entries[qc_lanes];
    uint32_t lanes = CastOctet(boxes, cast, &QC_AT(qcOctet, forest->listOctets, octet), entries);
    for (; lanes != 0; lanes &= lanes - 1)
        PushBox(boxes, cast, stack, QC_AT(uint32_t, forest->listIds, qc_lanes * octet + (size_t)__builtin_ctz(lanes)));
}

/// Pops until the stack is empty. Returns false if the function stops the query.
static bool VisitStack(const qcBoxes* boxes, const Cast* cast, CastStack* stack, qcHostFunction* host)
{
    while (stack->count > 0)
    {
        CastNode node = stack->nodes[--stack->count];
        // The fraction may have been lowered since the node was pushed.
        if (node.entry > *cast->fraction + QC_CAST_TOLERANCE)
            continue;
        if (node.tree != NULL)
            PushChildren(boxes, cast, stack, &node);
        else if (!qcHostFunction_Call(node.octet, QC_AT(void*, boxes->userData, node.octet), host))
            return false;
    }
    return true;
}

__attribute__((noinline)) static void CastBox(const qcBoxes* boxes, const Cast* cast, qcHostFunction* host)
{
    const qcForest* forest = &boxes->forest;
    CastStack stack;
    stack.count = 0;
    bool more = true;
    for (uint64_t trees = forest->staticTrees | forest->dynamicTrees; more && trees != 0;)
    {
        const qcBoxTree* tree = &forest->trees[qcForest_NextTree(&trees)];
        stack.nodes[stack.count++] = (CastNode){tree, tree->shape.levelCount - 1, 0, 0.0};
        more = VisitStack(boxes, cast, &stack, host);
    }
    size_t octets = (forest->listIds.count + qc_lanes - 1) / qc_lanes;
    for (size_t i = 0; more && i < octets; i++)
    {
        PushListed(boxes, cast, &stack, i);
        if ((i + 1) % qc_listStep != 0 && i + 1 < octets)
            continue;
        SortNearestLast(&stack, 0);
        more = VisitStack(boxes, cast, &stack, host);
    }
}

void qcBoxes_CastBox(const qcBoxes* boxes, const double from[3], const double to[3], const double castLower[3],
                     const double castUpper[3], const double* fraction, qcBoxFunction* function, void* context)
{
    if (qcBoxes_GetCount(boxes) == 0)
        return;
    qcHostFunction host = {function, context, qcFloatMode_Begin()};
    Cast cast;
    PrepareCast(boxes, from, to, castLower, castUpper, fraction, &cast);
    CastBox(boxes, &cast, &host);
    qcFloatMode_End(host.mode);
}
