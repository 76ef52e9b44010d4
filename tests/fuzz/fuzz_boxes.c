// The life of a set of boxes, against lists of all boxes and all pairs: adding, moving, removing, wrong ids and bounds,
// both searches for pairs, queries, casts, searches that run out of memory.
#include "fuzz/fuzz.h"

#include <quickcullide/boxes.h>

#include <math.h>
#include <string.h>

enum
{
    qc_maxBoxes = 24,
    qc_maxOperations = 120
};

typedef struct Box
{
    bool isUsed, hasMoved; ///< hasMoved: added or moved since the last search
    bool isTiny;           ///< has subnormal bounds
    double lower[3], upper[3];
} Box;

typedef struct World
{
    FuzzBytes bytes;
    qcBoxes* boxes;
    bool isUnsure; ///< a search ran out of memory: what was known before it is lost
    Box box[qc_maxBoxes];
    bool known[qc_maxBoxes][qc_maxBoxes]; ///< pairs at the last search, a < b
} World;

static size_t s_left = SIZE_MAX; ///< allocations until one fails

static void* Allocate(size_t size, void* context)
{
    (void)context;
    if (s_left == 0)
        return NULL;
    s_left -= s_left != SIZE_MAX;
    return aligned_alloc(64, (size + 63) / 64 * 64);
}

static void Release(void* memory, size_t size, void* context)
{
    (void)size;
    (void)context;
    free(memory);
}

/// Small integers: boxes touch often, and times of casts are fractions.
static double TakeCoordinate(World* w)
{
    return (int8_t)Fuzz_TakeByte(&w->bytes) / 8;
}

/// False: no bounds of a box.
static bool TakeBounds(World* w, double lower[3], double upper[3])
{
    uint8_t way = Fuzz_TakeByte(&w->bytes);
    for (int axis = 0; axis < 3; axis++)
    {
        lower[axis] = TakeCoordinate(w);
        upper[axis] = lower[axis] + (double)Fuzz_TakeBelow(&w->bytes, way < 64 ? 2 : 8);
    }
    int axis = way % 3;
    switch (way)
    {
        case 250: lower[axis] = -INFINITY; return true;
        case 251: upper[axis] = INFINITY; return true;
        case 252: lower[axis] = upper[axis] = 0x1p-1074; return true;
        case 253: lower[axis] = NAN; return false;
        case 254: upper[axis] = NAN; return false;
        case 255: lower[axis] = upper[axis] + 1.0; return false;
        default: return true;
    }
}

static bool Overlap(const double lowerA[3], const double upperA[3], const double lowerB[3], const double upperB[3])
{
    for (int axis = 0; axis < 3; axis++)
        if (!(lowerA[axis] <= upperB[axis] && lowerB[axis] <= upperA[axis]))
            return false;
    return true;
}

static bool PairOverlaps(const World* w, uint32_t a, uint32_t b)
{
    const Box *x = &w->box[a], *y = &w->box[b];
    return x->isUsed && y->isUsed && Overlap(x->lower, x->upper, y->lower, y->upper);
}

//  ---- changes -----------------------------------------------------------------------------------------------------

/// A value that names a box.
static void* DataOf(uint32_t id)
{
    return (void*)((uintptr_t)id + 1);
}

static void Forget(World* w, uint32_t id)
{
    for (uint32_t other = 0; other < qc_maxBoxes; other++)
        w->known[id][other] = w->known[other][id] = false;
}

static bool IsTiny(const double upper[3])
{
    return upper[0] == 0x1p-1074 || upper[1] == 0x1p-1074 || upper[2] == 0x1p-1074;
}

static void Add(World* w)
{
    double lower[3], upper[3];
    uint32_t free = 0, id;
    while (free < qc_maxBoxes && w->box[free].isUsed)
        free++;
    if (free == qc_maxBoxes)
        return;
    bool isGood = TakeBounds(w, lower, upper);
    FUZZ_CHECK(qcBoxes_Add(w->boxes, lower, upper, DataOf(free), &id) == (isGood ? qc_statusOk : qc_statusBadInput));
    if (!isGood)
        return;
    FUZZ_CHECK(id == free);
    w->box[id] = (Box){.isUsed = true, .hasMoved = true};
    memcpy(w->box[id].lower, lower, sizeof lower);
    memcpy(w->box[id].upper, upper, sizeof upper);
    w->box[id].isTiny = IsTiny(upper);
    Forget(w, id);
}

static void Move(World* w, uint32_t id)
{
    Box* box = &w->box[id];
    double lower[3], upper[3];
    bool isGood = TakeBounds(w, lower, upper) && box->isUsed;
    FUZZ_CHECK(qcBoxes_Move(w->boxes, id, lower, upper) == (isGood ? qc_statusOk : qc_statusBadInput));
    if (!isGood)
        return;
    for (int axis = 0; axis < 3; axis++)
        box->hasMoved = box->hasMoved || lower[axis] != box->lower[axis] || upper[axis] != box->upper[axis];
    memcpy(box->lower, lower, sizeof lower);
    memcpy(box->upper, upper, sizeof upper);
    box->isTiny = IsTiny(upper);
}

static void Remove(World* w, uint32_t id)
{
    bool isGood = w->box[id].isUsed;
    FUZZ_CHECK(qcBoxes_Remove(w->boxes, id) == (isGood ? qc_statusOk : qc_statusBadInput));
    w->box[id].isUsed = false;
    Forget(w, id);
}

static void Clear(World* w)
{
    qcBoxes_Clear(w->boxes);
    memset(w->box, 0, sizeof w->box);
    memset(w->known, 0, sizeof w->known);
    w->isUnsure = false;
}

static void CheckLists(const World* w)
{
    uint32_t count = 0;
    double lower[3], upper[3], all[2][3] = {{0.0}};
    for (uint32_t id = 0; id < qc_maxBoxes; id++)
    {
        const Box* box = &w->box[id];
        qcBoxes_GetBounds(w->boxes, id, lower, upper);
        FUZZ_CHECK(qcBoxes_GetUserData(w->boxes, id) == (box->isUsed ? DataOf(id) : NULL));
        for (int axis = 0; axis < 3; axis++)
        {
            FUZZ_CHECK(lower[axis] == (box->isUsed ? box->lower[axis] : 0.0));
            FUZZ_CHECK(upper[axis] == (box->isUsed ? box->upper[axis] : 0.0));
            if (!box->isUsed)
                continue;
            all[0][axis] = count == 0 ? lower[axis] : fmin(all[0][axis], lower[axis]);
            all[1][axis] = count == 0 ? upper[axis] : fmax(all[1][axis], upper[axis]);
        }
        count += box->isUsed;
    }
    FUZZ_CHECK(qcBoxes_GetCount(w->boxes) == count);
    qcBoxes_GetTotalBounds(w->boxes, lower, upper);
    for (int axis = 0; axis < 3; axis++)
        FUZZ_CHECK(lower[axis] == all[0][axis] && upper[axis] == all[1][axis]);
}

//  ---- searches ----------------------------------------------------------------------------------------------------

static void KeepPairs(World* w)
{
    for (uint32_t a = 0; a < qc_maxBoxes; a++)
    {
        w->box[a].hasMoved = false;
        for (uint32_t b = a + 1; b < qc_maxBoxes; b++)
            w->known[a][b] = PairOverlaps(w, a, b);
    }
    w->isUnsure = false;
}

static void FindMoved(World* w)
{
    const qcBoxPair* pairs;
    size_t count, at = 0;
    if (qcBoxes_FindMovedPairs(w->boxes, &pairs, &count) != qc_statusOk)
    {
        FUZZ_CHECK(s_left == 0);
        w->isUnsure = true;
        return;
    }
    for (uint32_t a = 0; a < qc_maxBoxes; a++)
        for (uint32_t b = a + 1; b < qc_maxBoxes; b++)
        {
            bool isFound = at < count && pairs[at].a == a && pairs[at].b == b;
            bool hasMoved = w->box[a].hasMoved || w->box[b].hasMoved;
            // After a search that failed more than the moved ones may be reported.
            FUZZ_CHECK(isFound ? PairOverlaps(w, a, b) && (hasMoved || w->isUnsure)
                               : !(PairOverlaps(w, a, b) && hasMoved));
            at += isFound;
        }
    FUZZ_CHECK(at == count);
    KeepPairs(w);
}

static void FindChanged(World* w)
{
    qcBoxChanges changes;
    size_t began = 0, ended = 0;
    if (qcBoxes_FindChangedPairs(w->boxes, &changes) != qc_statusOk)
    {
        FUZZ_CHECK(s_left == 0);
        w->isUnsure = true;
        return;
    }
    FUZZ_CHECK(w->isUnsure || !changes.all);
    for (uint32_t a = 0; a < qc_maxBoxes; a++)
        for (uint32_t b = a + 1; b < qc_maxBoxes; b++)
        {
            bool now = PairOverlaps(w, a, b), before = w->known[a][b] && !changes.all;
            bool isNew = began < changes.beganCount && changes.began[began].a == a && changes.began[began].b == b;
            bool isOver = ended < changes.endedCount && changes.ended[ended].a == a && changes.ended[ended].b == b;
            FUZZ_CHECK(isNew == (now && !before));
            FUZZ_CHECK(isOver == (!now && before && w->box[a].isUsed && w->box[b].isUsed));
            began += isNew;
            ended += isOver;
        }
    FUZZ_CHECK(began == changes.beganCount && ended == changes.endedCount);
    KeepPairs(w);
}

/// A search that may run out of memory, and then the next.
static void Find(World* w, uint8_t way)
{
    s_left = way >= 224 ? way % 8 : SIZE_MAX;
    if (way % 2 == 0)
        FindMoved(w);
    else
        FindChanged(w);
    s_left = SIZE_MAX;
    if (w->isUnsure && way % 4 < 2)
        FindChanged(w);
}

//  ---- queries -----------------------------------------------------------------------------------------------------

typedef struct Visits
{
    bool seen[qc_maxBoxes];
    uint32_t left;
} Visits;

static bool Visit(uint32_t id, void* userData, void* context)
{
    Visits* visits = context;
    FUZZ_CHECK(id < qc_maxBoxes && userData == DataOf(id) && !visits->seen[id] && visits->left > 0);
    visits->seen[id] = true;
    return --visits->left > 0;
}

static void QueryBox(World* w)
{
    double lower[3], upper[3];
    if (!TakeBounds(w, lower, upper))
        return;
    Visits visits = {.left = 1 + Fuzz_TakeBelow(&w->bytes, 32)};
    qcBoxes_QueryBox(w->boxes, lower, upper, Visit, &visits);
    for (uint32_t id = 0; id < qc_maxBoxes; id++)
    {
        const Box* box = &w->box[id];
        bool overlaps = box->isUsed && Overlap(box->lower, box->upper, lower, upper);
        FUZZ_CHECK(visits.seen[id] ? overlaps : !overlaps || visits.left == 0);
    }
}

static void QueryBegun(World* w, uint32_t id)
{
    Visits visits = {.left = UINT32_MAX};
    qcBoxes_QueryBegun(w->boxes, id, Visit, &visits);
    for (uint32_t other = 0; other < qc_maxBoxes && !w->isUnsure; other++)
    {
        uint32_t a = id < other ? id : other, b = id < other ? other : id;
        FUZZ_CHECK(visits.seen[other] == (other != id && PairOverlaps(w, a, b) && !w->known[a][b]));
    }
}

/// Whether a box moved along a way of integers touches another one of integers or infinities: times are fractions with
/// the way as denominator.
static bool IsTouched(const Box* box, const double from[3], const double to[3], const double lower[3],
                      const double upper[3])
{
    // The first and the last time in which all axes overlap so far, as fractions.
    double first = 0.0, firstOf = 1.0, last = 1.0, lastOf = 1.0;
    for (int axis = 0; axis < 3; axis++)
    {
        double way = to[axis] - from[axis], low = box->lower[axis] - (from[axis] + upper[axis]);
        double high = box->upper[axis] - (from[axis] + lower[axis]);
        if (way == 0.0)
        {
            if (low > 0.0 || high < 0.0)
                return false;
            continue;
        }
        double begin = way > 0.0 ? low : -high, end = way > 0.0 ? high : -low;
        if (begin * firstOf > first * fabs(way))
        {
            first = begin;
            firstOf = fabs(way);
        }
        if (end * lastOf < last * fabs(way))
        {
            last = end;
            lastOf = fabs(way);
        }
    }
    return first * lastOf <= last * firstOf;
}

static void CastBox(World* w)
{
    double from[3], to[3], lower[3], upper[3];
    for (int axis = 0; axis < 3; axis++)
    {
        from[axis] = TakeCoordinate(w);
        to[axis] = TakeCoordinate(w);
        lower[axis] = -(double)Fuzz_TakeBelow(&w->bytes, 3);
        upper[axis] = (double)Fuzz_TakeBelow(&w->bytes, 3);
    }
    Visits visits = {.left = 1 + Fuzz_TakeBelow(&w->bytes, 64)};
    qcBoxes_CastBox(w->boxes, from, to, lower, upper, NULL, Visit, &visits);
    for (uint32_t id = 0; id < qc_maxBoxes; id++)
        if (w->box[id].isUsed && !w->box[id].isTiny && IsTouched(&w->box[id], from, to, lower, upper))
            FUZZ_CHECK(visits.seen[id] || visits.left == 0);
}

static void RunOperation(World* w)
{
    uint8_t what = Fuzz_TakeByte(&w->bytes);
    uint32_t id = Fuzz_TakeBelow(&w->bytes, qc_maxBoxes);
    switch (what % 16)
    {
        case 0:
        case 1:
        case 2:
        case 3: Add(w); break;
        case 4:
        case 5:
        case 6:
        case 7: Move(w, id); break;
        case 8: Remove(w, id); break;
        case 9: QueryBox(w); break;
        case 10: QueryBegun(w, id); break;
        case 11: CastBox(w); break;
        case 12: CheckLists(w); break;
        case 13:
            if (what > 240)
                Clear(w);
            break;
        default: Find(w, what);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    static bool isReady;
    if (!isReady)
        FUZZ_CHECK(qcSetAllocator(Allocate, Release, NULL) == qc_statusOk);
    isReady = true;
    World w = {.bytes = {data, size}};
    FUZZ_CHECK(qcBoxes_Create(&w.boxes) == qc_statusOk);
    for (int i = 0; i < qc_maxOperations && w.bytes.size > 0; i++)
        RunOperation(&w);
    CheckLists(&w);
    FindChanged(&w);
    qcBoxes_Destroy(w.boxes);
    FUZZ_CHECK(qcGetByteCount() == 0);
    return 0;
}
