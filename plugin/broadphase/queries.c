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
#include "broadphase/box_set.h"

#include "base/float_mode.h"

#include <float.h>
#include <math.h>
#include <string.h>

__attribute__((noinline)) static void GetTotalBounds(const qcBoxes* boxes, double lower[3], double upper[3])
{
    bool any = qcBoxes_GetCount(boxes) > 0;
    for (int k = 0; k < 3; k++)
    {
        lower[k] = any ? INFINITY : 0.0;
        upper[k] = any ? -INFINITY : 0.0;
    }
    for (size_t id = 0; any && id < boxes->boxes.count; id++)
    {
        if (!qcBoxes_Box(boxes, (uint32_t)id)->alive)
            continue;
        qcBounds bounds = qcBoxes_Bounds(boxes, (uint32_t)id);
        for (int k = 0; k < 3; k++)
        {
            lower[k] = qcLower(lower[k], bounds.lower[k]);
            upper[k] = qcUpper(upper[k], bounds.upper[k]);
        }
    }
}

void qcBoxes_GetTotalBounds(const qcBoxes* boxes, double lower[3], double upper[3])
{
    qcFloatMode mode = qcFloatMode_Begin();
    GetTotalBounds(boxes, lower, upper);
    qcFloatMode_End(mode);
}

/// The caller's function, which runs in the caller's floating-point environment.
typedef struct Visitor
{
    qcBoxFunction* function;
    void* context;
    qcFloatMode mode;
} Visitor;

static bool Visit(uint32_t id, void* userData, void* context)
{
    Visitor* visitor = context;
    qcFloatMode_End(visitor->mode);
    bool more = visitor->function(id, userData, visitor->context);
    visitor->mode = qcFloatMode_Begin();
    return more;
}

//  ---- all boxes in a box ----------------------------------------------------------------------------

typedef struct Question
{
    const qcBoxes* set;
    qcBounds bounds;
    qcFloatBox box; ///< around the bounds
    bool exact;     ///< the floats are the bounds
    qcBoxFunction* function;
    void* context;
    uint32_t self; ///< left out, and with it what it met at the last search; QC_NO_BOX: none
    bool inForest; ///< asks for boxes whose boxes in the forest meet it
} Question;

/// NaN counts as unbounded.
static Question Ask(const qcBoxes* set, const double lower[3], const double upper[3], qcBoxFunction* function,
                    void* context)
{
    Question question = {.set = set, .function = function, .context = context, .self = QC_NO_BOX};
    for (int k = 0; k < 3; k++)
    {
        question.bounds.lower[k] = isnan(lower[k]) ? -INFINITY : lower[k];
        question.bounds.upper[k] = isnan(upper[k]) ? INFINITY : upper[k];
    }
    question.exact = qcFloatBox_Enclose(&question.box, question.bounds.lower, question.bounds.upper);
    return question;
}

static bool Meets(const Question* question, uint32_t id)
{
    const qcBox* box = qcBoxes_Box(question->set, id);
    bool meet = qcBox_MeetsFloats(box, question->box.lower, question->box.upper);
    if (!meet || (box->exact & question->exact))
        return meet;
    qcBounds bounds = qcBoxes_Bounds(question->set, id);
    return qcBounds_Meet(&bounds, &question->bounds);
}

/// For what meets a box of the set.
static Question AskOf(const qcBoxes* set, uint32_t id, qcBoxFunction* function, void* context)
{
    const qcBox* box = qcBoxes_Box(set, id);
    // One by one: to clear it all first takes longer.
    Question question;
    question.set = set;
    question.bounds = qcBoxes_Bounds(set, id);
    memcpy(question.box.lower, box->lower, sizeof box->lower);
    memcpy(question.box.upper, box->upper, sizeof box->upper);
    question.exact = box->exact;
    question.function = function;
    question.context = context;
    question.self = QC_NO_BOX;
    question.inForest = false;
    return question;
}

/// Returns false if the function wants no more.
static bool Offer(const Question* question, uint32_t id)
{
    if (!question->inForest && !Meets(question, id))
        return true;
    if (question->self != QC_NO_BOX && (id == question->self || qcBoxes_Met(question->set, id, question->self)))
        return true;
    return question->function(id, QC_AT(void*, question->set->userData, id), question->context);
}

static bool OfferLanes(const Question* question, const qcOctet* octet, const uint32_t* ids)
{
    uint32_t lanes = question->set->forest.kernels->meet(octet, &question->box);
    for (; lanes != 0; lanes &= lanes - 1)
        if (!Offer(question, ids[__builtin_ctz(lanes)]))
            return false;
    return true;
}

static bool OfferList(const Question* question)
{
    const qcForest* forest = &question->set->forest;
    for (size_t i = 0; i < forest->listIds.count; i += qc_lanes)
        if (!OfferLanes(question, &QC_AT(qcOctet, forest->listOctets, i / qc_lanes),
                        &QC_AT(uint32_t, forest->listIds, i)))
            return false;
    return true;
}

typedef struct Stop
{
    uint32_t level, octet;
} Stop;

static bool OfferTree(const Question* question, const qcBoxTree* tree)
{
    const qcOctetTree* shape = &tree->shape;
    Stop stack[7 * qc_treeLevels + 1];
    uint32_t stops = 1;
    stack[0] = (Stop){shape->levelCount - 1, 0};
    while (stops > 0)
    {
        Stop stop = stack[--stops];
        const qcOctet* octet = &shape->octets[shape->first[stop.level] + stop.octet];
        if (stop.level == 0)
        {
            if (!OfferLanes(question, octet, &QC_AT(uint32_t, tree->ids, qc_lanes * stop.octet)))
                return false;
            continue;
        }
        uint32_t lanes = question->set->forest.kernels->meet(octet, &question->box);
        for (; lanes != 0; lanes &= lanes - 1)
            stack[stops++] = (Stop){stop.level - 1, qc_lanes * stop.octet + (uint32_t)__builtin_ctz(lanes)};
    }
    return true;
}

typedef enum Part
{
    YOUNG = 1, ///< what was put into the forest since the last search
    OLD = 2
} Part;

static void OfferForest(const Question* question, unsigned parts)
{
    const qcForest* forest = &question->set->forest;
    bool more = (parts & YOUNG) == 0 || OfferList(question);
    uint64_t trees = ((parts & YOUNG) != 0 ? forest->young : 0) | ((parts & OLD) != 0 ? forest->old : 0);
    while (more && trees != 0)
        more = OfferTree(question, &forest->trees[qcForest_NextTree(&trees)]);
}

__attribute__((noinline)) static void QueryBox(const qcBoxes* boxes, const double lower[3], const double upper[3],
                                               Visitor* visitor)
{
    Question question = Ask(boxes, lower, upper, Visit, visitor);
    OfferForest(&question, YOUNG | OLD);
}

void qcBoxes_QueryBox(const qcBoxes* boxes, const double lower[3], const double upper[3], qcBoxFunction* function,
                      void* context)
{
    if (qcBoxes_GetCount(boxes) == 0)
        return;
    Visitor visitor = {function, context, qcFloatMode_Begin()};
    QueryBox(boxes, lower, upper, &visitor);
    qcFloatMode_End(visitor.mode);
}

//  ---- neighbours ------------------------------------------------------------------------------------

typedef struct Mover
{
    qcBoxes* set;
    uint32_t id, stamp;
    bool failed;
} Mover;

/// The box found is still, and was at the last search.
static bool KeepStillPair(uint32_t id, void* userData, void* context)
{
    (void)userData;
    const Mover* moving = context;
    const qcBox* box = qcBoxes_Box(moving->set, id);
    if (id == moving->id || !box->still || box->mover != QC_NO_MOVER)
        return true;
    // Without memory the next search begins from nothing.
    moving->set->forgotten = qcOverlapGraph_Join(&moving->set->neighbours, moving->id, id, true) != qc_statusOk;
    return !moving->set->forgotten;
}

void qcBoxes_KeepStillPairs(qcBoxes* set, uint32_t id)
{
    Mover moving = {.set = set, .id = id};
    Question question = AskOf(set, id, KeepStillPair, &moving);
    if (!set->forgotten)
        OfferForest(&question, OLD);
}

uint32_t qcBoxes_StampNeighbours(qcBoxes* set, uint32_t id)
{
    uint32_t* stamps = set->stamps.data;
    if (++set->stamp == 0)
    {
        memset(stamps, 0, set->stamps.count * sizeof *stamps);
        set->stamp = 1;
    }
    uint32_t end = qcOverlapGraph_First(&set->neighbours, id);
    for (; end != QC_NO_EDGE; end = qcOverlapGraph_Next(&set->neighbours, end))
        stamps[qcOverlapGraph_Other(&set->neighbours, end)] = set->stamp;
    return set->stamp;
}

static bool JoinNeighbour(uint32_t id, void* userData, void* context)
{
    (void)userData;
    Mover* moving = context;
    if (id == moving->id || QC_AT(uint32_t, moving->set->stamps, id) == moving->stamp)
        return true;
    moving->failed = qcOverlapGraph_Join(&moving->set->neighbours, moving->id, id, false) != qc_statusOk;
    return !moving->failed;
}

void qcBoxes_Settle(qcBoxes* set, uint32_t id)
{
    qcBox* box = qcBoxes_Box(set, id);
    if (box->at != qc_boxPairsStale || box->still || set->forgotten)
        return;
    Mover moving = {.set = set, .id = id, .stamp = qcBoxes_StampNeighbours(set, id)};
    Question question = AskOf(set, id, JoinNeighbour, &moving);
    question.box = QC_AT(qcFloatBox, set->forest.boxes, id);
    question.inForest = true;
    OfferForest(&question, YOUNG | OLD);
    if (moving.failed)
        return;
    box->at = qc_boxPairsKnown;
    set->lostCount--;
}

typedef struct Begun
{
    uint32_t ids[32], count;
} Begun;

/// From an end of its list on, neighbours of a box that may meet it and did not at the last search. Returns where to go
/// on.
static uint32_t CollectBegun(const qcBoxes* set, uint32_t id, uint32_t end, Begun* begun)
{
    const qcEdge* edges = set->neighbours.edges.data;
    const qcBox *boxes = set->boxes.data, *box = &boxes[id];
    uint32_t count = 0;
    // Without branches: whether two boxes meet, and met, cannot be foreseen.
    for (; end != QC_NO_EDGE && count < 32; end = qcOverlapGraph_Next(&set->neighbours, end))
    {
        const qcEdge* edge = &edges[end / 2];
        uint32_t other = edge->box[1 - end % 2] & ~QC_EDGE_MARK;
        begun->ids[count] = other;
        count += ((edge->box[0] & QC_EDGE_MARK) == 0) & qcBox_MeetsFloats(box, boxes[other].lower, boxes[other].upper);
    }
    begun->count = count;
    return end;
}

/// Of the neighbours that are kept; but not the young ones, if those are asked otherwise.
static bool OfferBegun(const qcBoxes* set, uint32_t id, bool young, Visitor* visitor)
{
    Begun begun;
    for (uint32_t end = qcOverlapGraph_First(&set->neighbours, id); end != QC_NO_EDGE;)
    {
        end = CollectBegun(set, id, end, &begun);
        // Most find nothing.
        if (begun.count == 0)
            continue;
        Question question = AskOf(set, id, Visit, visitor);
        question.self = id;
        for (uint32_t i = 0; i < begun.count; i++)
            if ((young || !qcForest_IsYoung(&set->forest, begun.ids[i])) && !Offer(&question, begun.ids[i]))
                return false;
    }
    return true;
}

__attribute__((noinline)) static void QueryBegun(qcBoxes* boxes, uint32_t id, Visitor* visitor)
{
    qcBoxes_Settle(boxes, id);
    // A still box has neighbours that are not kept.
    const qcBox* box = qcBoxes_Box(boxes, id);
    bool known = !box->still && !boxes->forgotten && box->at != qc_boxPairsStale;
    // Others may have come since.
    bool others = boxes->putCount != (box->at != qc_boxInTree);
    if ((known && !OfferBegun(boxes, id, !others, visitor)) || (known && !others))
        return;
    Question question = AskOf(boxes, id, Visit, visitor);
    question.self = id;
    OfferForest(&question, known ? YOUNG : YOUNG | OLD);
}

void qcBoxes_QueryBegun(qcBoxes* boxes, uint32_t id, qcBoxFunction* function, void* context)
{
    if (boxes == NULL || id >= boxes->boxes.count || !qcBoxes_Box(boxes, id)->alive)
        return;
    Visitor visitor = {function, context, qcFloatMode_Begin()};
    QueryBegun(boxes, id, &visitor);
    qcFloatMode_End(visitor.mode);
}

//  ---- all boxes on a way ----------------------------------------------------------------------------

/// 16 u (see the file's head).
#define QC_CAST_TOLERANCE 0x1p-49

typedef struct Cast
{
    double from[3], castLower[3], castUpper[3];
    double wayLower[3], wayUpper[3]; ///< the box around the whole way
    qcFloatBox wayBox;               ///< around that
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

__attribute__((noinline)) static Cast PrepareCast(const double from[3], const double to[3], const double castLower[3],
                                                  const double castUpper[3], const double* fraction)
{
    static const double wholeWay = 1.0;
    Cast cast = {.fraction = fraction != NULL ? fraction : &wholeWay};
    qcBounds unbounded; ///< the way, but NaN turns no box away
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
        unbounded.lower[k] = isnan(cast.wayLower[k]) ? -INFINITY : cast.wayLower[k];
        unbounded.upper[k] = isnan(cast.wayUpper[k]) ? INFINITY : cast.wayUpper[k];
    }
    (void)qcFloatBox_Enclose(&cast.wayBox, unbounded.lower, unbounded.upper);
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

/// A node of a tree, or a box, that is met on the way.
typedef struct CastStop
{
    const qcBoxTree* tree; ///< null: a box
    uint32_t level, octet; ///< a box: its id in `octet`
    double entry;
} CastStop;

enum
{
    // Of the list, so many boxes are brought into order at a time.
    qc_listStep = 64,
    qc_castStack = 7 * qc_treeLevels + qc_forestTrees + qc_listStep + qc_lanes
};

typedef struct CastStack
{
    CastStop stops[qc_castStack];
    uint32_t count;
} CastStack;

/// Brings the stops from `first` on into order: the nearest is taken first.
static void NearestLast(CastStack* stack, uint32_t first)
{
    for (uint32_t i = first + 1; i < stack->count; i++)
    {
        CastStop stop = stack->stops[i];
        uint32_t at = i;
        for (; at > first && stack->stops[at - 1].entry < stop.entry; at--)
            stack->stops[at] = stack->stops[at - 1];
        stack->stops[at] = stop;
    }
}

/// A box of the forest contains the box itself, but where that is may be further along the way.
static void PushBox(const qcBoxes* boxes, const Cast* cast, CastStack* stack, uint32_t id)
{
    qcBounds bounds = qcBoxes_Bounds(boxes, id);
    CastStop stop = {NULL, 0, id, 0.0};
    if (CastMeets(cast, bounds.lower, bounds.upper, &stop.entry))
        stack->stops[stack->count++] = stop;
}

/// Pushes what is met of one octet.
static void PushLanes(const qcBoxes* boxes, const Cast* cast, CastStack* stack, const CastStop* at)
{
    const qcOctetTree* shape = &at->tree->shape;
    const qcOctet* octet = &shape->octets[shape->first[at->level] + at->octet];
    uint32_t lanes = boxes->forest.kernels->meet(octet, &cast->wayBox), first = stack->count;
    for (; lanes != 0; lanes &= lanes - 1)
    {
        uint32_t lane = (uint32_t)__builtin_ctz(lanes), below = qc_lanes * at->octet + lane;
        if (at->level == 0)
        {
            PushBox(boxes, cast, stack, QC_AT(uint32_t, at->tree->ids, below));
            continue;
        }
        double lower[3], upper[3];
        for (int k = 0; k < 3; k++)
        {
            lower[k] = (double)octet->lower[k][lane];
            upper[k] = (double)octet->upper[k][lane];
        }
        CastStop stop = {at->tree, at->level - 1, below, 0.0};
        if (CastMeets(cast, lower, upper, &stop.entry))
            stack->stops[stack->count++] = stop;
    }
    NearestLast(stack, first);
}

/// Visits what is on the stack. Returns false if the function wants no more.
static bool VisitStack(const qcBoxes* boxes, const Cast* cast, CastStack* stack, Visitor* visitor)
{
    while (stack->count > 0)
    {
        CastStop stop = stack->stops[--stack->count];
        // The fraction may have been lowered since.
        if (stop.entry > *cast->fraction + QC_CAST_TOLERANCE)
            continue;
        if (stop.tree != NULL)
            PushLanes(boxes, cast, stack, &stop);
        else if (!Visit(stop.octet, QC_AT(void*, boxes->userData, stop.octet), visitor))
            return false;
    }
    return true;
}

__attribute__((noinline)) static void CastBox(const qcBoxes* boxes, const Cast* cast, Visitor* visitor)
{
    const qcForest* forest = &boxes->forest;
    CastStack stack;
    stack.count = 0;
    for (uint64_t trees = forest->old | forest->young; trees != 0;)
    {
        const qcBoxTree* tree = &forest->trees[qcForest_NextTree(&trees)];
        CastStop stop = {tree, tree->shape.levelCount - 1, 0, 0.0};
        qcFloatBox around = qcOctet_Around(&tree->shape.octets[tree->shape.first[stop.level]]);
        double lower[3] = {(double)around.lower[0], (double)around.lower[1], (double)around.lower[2]};
        double upper[3] = {(double)around.upper[0], (double)around.upper[1], (double)around.upper[2]};
        if (CastMeets(cast, lower, upper, &stop.entry))
            stack.stops[stack.count++] = stop;
    }
    NearestLast(&stack, 0);
    bool more = VisitStack(boxes, cast, &stack, visitor);
    for (size_t i = 0; more && i < forest->listIds.count; i++)
    {
        PushBox(boxes, cast, &stack, QC_AT(uint32_t, forest->listIds, i));
        if ((i + 1) % qc_listStep != 0 && i + 1 < forest->listIds.count)
            continue;
        NearestLast(&stack, 0);
        more = VisitStack(boxes, cast, &stack, visitor);
    }
}

void qcBoxes_CastBox(const qcBoxes* boxes, const double from[3], const double to[3], const double castLower[3],
                     const double castUpper[3], const double* fraction, qcBoxFunction* function, void* context)
{
    if (qcBoxes_GetCount(boxes) == 0)
        return;
    Visitor visitor = {function, context, qcFloatMode_Begin()};
    Cast cast = PrepareCast(from, to, castLower, castUpper, fraction);
    CastBox(boxes, &cast, &visitor);
    qcFloatMode_End(visitor.mode);
}
