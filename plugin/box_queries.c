// Questions to a set of boxes: all boxes in a box, all boxes on a way, the box around all.
// Slabs: Kay, Kajiya: Ray tracing complex scenes, 1986.
//
// Why a cast never misses. On the way from p to q, a box of the set, [lower, upper], is met when p + t (q - p) is in
// [L, U] = [lower - castUpper, upper - castLower] for a t in [0, fraction].
// - The box around the whole way: sums and comparisons only, rounding is monotone, so what meets stays meeting.
// - The slabs: with u = 2^-53, the rounding errors of L - p are within 3 u (|lower| + |castUpper| + |p|), and planes
//   are moved outwards by 4 u of that. What is left is relative: within 5 u of t, so within 5 u where t <= 1 matters.
//   Entry and exit, each within that, are compared with a tolerance of 16 u.
// - A slab is left out where it says nothing: a direction that is zero, or too small or too large for its inverse.
// - NaN (of infinities that cancel) fails every comparison, and every comparison is written so that failing it keeps
//   the box.
#include "box_set.h"

#include <float.h>
#include <math.h>

void qcBoxes_GetTotalBounds(const qcBoxes* boxes, double lower[3], double upper[3])
{
    uint32_t stack[qc_treeStack], count = 0;
    bool any = boxes != NULL && boxes->tree.root != QC_NO_NODE;
    for (int k = 0; k < 3; k++)
    {
        lower[k] = any ? INFINITY : 0.0;
        upper[k] = any ? -INFINITY : 0.0;
    }
    if (any)
        stack[count++] = boxes->tree.root;
    while (count > 0)
    {
        const qcTreeNode* node = qcBoxTree_Node(&boxes->tree, stack[--count]);
        if (qcBounds_Contain(lower, upper, node->lower, node->upper))
            continue;
        if (node->height != 0)
        {
            stack[count++] = node->child[0];
            stack[count++] = node->child[1];
            continue;
        }
        const qcBox* box = &QC_AT(qcBox, boxes->boxes, node->child[0]);
        for (int k = 0; k < 3; k++)
        {
            lower[k] = qcLower(lower[k], box->lower[k]);
            upper[k] = qcUpper(upper[k], box->upper[k]);
        }
    }
}

void qcBoxes_QueryBox(const qcBoxes* boxes, const double lower[3], const double upper[3], qcBoxFunction* function,
                      void* context)
{
    uint32_t stack[qc_treeStack], count = 0;
    if (boxes != NULL && boxes->tree.root != QC_NO_NODE)
        stack[count++] = boxes->tree.root;
    while (count > 0)
    {
        const qcTreeNode* node = qcBoxTree_Node(&boxes->tree, stack[--count]);
        if (!qcBounds_Meet(node->lower, node->upper, lower, upper))
            continue;
        if (node->height != 0)
        {
            stack[count++] = node->child[0];
            stack[count++] = node->child[1];
            continue;
        }
        const qcBox* box = &QC_AT(qcBox, boxes->boxes, node->child[0]);
        if (qcBounds_Meet(box->lower, box->upper, lower, upper) &&
            !function(node->child[0], QC_AT(void*, boxes->userData, node->child[0]), context))
            return;
    }
}

/// 16 u (see the file's head).
#define QC_CAST_TOLERANCE 0x1p-49

typedef struct Cast
{
    double from[3], castLower[3], castUpper[3];
    double wayLower[3], wayUpper[3]; ///< the box around the whole way
    double inverse[3];               ///< of the direction; 0: no slab in this axis
    double reach[3];                 ///< |from| + the larger cast extent
    const double* fraction;
} Cast;

/// NaN when one of them is: then no comparison turns a box away.
static double LowerOrNan(double a, double b)
{
    return a < b ? a : b <= a ? b : NAN;
}

static double UpperOrNan(double a, double b)
{
    return a > b ? a : b >= a ? b : NAN;
}

static Cast PrepareCast(const double from[3], const double to[3], const double castLower[3], const double castUpper[3],
                        const double* fraction)
{
    static const double wholeWay = 1.0;
    Cast cast = {.fraction = fraction != NULL ? fraction : &wholeWay};
    for (int k = 0; k < 3; k++)
    {
        cast.from[k] = from[k];
        cast.castLower[k] = castLower[k];
        cast.castUpper[k] = castUpper[k];
        cast.wayLower[k] = LowerOrNan(from[k], to[k]) + castLower[k];
        cast.wayUpper[k] = UpperOrNan(from[k], to[k]) + castUpper[k];
        double direction = to[k] - from[k], length = fabs(direction);
        cast.inverse[k] = length >= DBL_MIN && length <= 0x1p1021 ? 1.0 / direction : 0.0;
        cast.reach[k] = fabs(from[k]) + qcUpper(fabs(castLower[k]), fabs(castUpper[k]));
    }
    return cast;
}

/// `*entry`: where on the way, as a fraction, the box is met at the earliest.
static bool CastMeets(const Cast* cast, const double lower[3], const double upper[3], double* entry)
{
    double enter = 0.0, leave = *cast->fraction;
    for (int k = 0; k < 3; k++)
    {
        if (lower[k] > cast->wayUpper[k] || upper[k] < cast->wayLower[k])
            return false;
        double inverse = cast->inverse[k];
        if (inverse == 0.0)
            continue;
        double low = lower[k] - cast->castUpper[k] - cast->from[k] - 0x1p-51 * (fabs(lower[k]) + cast->reach[k]);
        double high = upper[k] - cast->castLower[k] - cast->from[k] + 0x1p-51 * (fabs(upper[k]) + cast->reach[k]);
        double near = (inverse > 0.0 ? low : high) * inverse, far = (inverse > 0.0 ? high : low) * inverse;
        if (near > enter)
            enter = near;
        if (far < leave)
            leave = far;
    }
    *entry = enter;
    return !(enter > leave + QC_CAST_TOLERANCE);
}

typedef struct CastStop
{
    uint32_t node;
    double entry;
} CastStop;

void qcBoxes_CastBox(const qcBoxes* boxes, const double from[3], const double to[3], const double castLower[3],
                     const double castUpper[3], const double* fraction, qcBoxFunction* function, void* context)
{
    Cast cast = PrepareCast(from, to, castLower, castUpper, fraction);
    CastStop stack[qc_treeStack];
    uint32_t count = 0;
    if (boxes != NULL && boxes->tree.root != QC_NO_NODE)
        stack[count++] = (CastStop){boxes->tree.root, 0.0};
    while (count > 0)
    {
        CastStop stop = stack[--count];
        // The fraction may have been lowered since.
        if (stop.entry > *cast.fraction + QC_CAST_TOLERANCE)
            continue;
        const qcTreeNode* node = qcBoxTree_Node(&boxes->tree, stop.node);
        if (node->height == 0)
        {
            const qcBox* box = &QC_AT(qcBox, boxes->boxes, node->child[0]);
            if (CastMeets(&cast, box->lower, box->upper, &stop.entry) &&
                !function(node->child[0], QC_AT(void*, boxes->userData, node->child[0]), context))
                return;
            continue;
        }
        CastStop hit[2];
        int hits = 0;
        for (int i = 0; i < 2; i++)
        {
            const qcTreeNode* child = qcBoxTree_Node(&boxes->tree, node->child[i]);
            hit[hits].node = node->child[i];
            hits += CastMeets(&cast, child->lower, child->upper, &hit[hits].entry);
        }
        if (hits == 2 && hit[0].entry < hit[1].entry)
        {
            CastStop nearer = hit[0];
            hit[0] = hit[1];
            hit[1] = nearer;
        }
        for (int i = 0; i < hits; i++)
            stack[count++] = hit[i];
    }
}
