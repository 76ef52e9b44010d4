// The life of a scene: bodies are added, removed, bent, moved, switched and named wrongly, with numbers from NaN to
// subnormal, between steps of every kind. Each step has, to the last bit, the result of brute force in a new scene of
// the same bodies.
#include "fuzz/fuzz.h"

#include <quickcullide/quickcullide.h>

#include <float.h>
#include <math.h>
#include <string.h>

enum
{
    qc_slots = 4,
    qc_usualSide = 5, ///< of a sheet, in squares: one leaf of a BVH
    qc_largeSide = 9, ///< of one sheet in a scene, since brute force takes a step of each
    qc_maxSide = 23,  ///< without pairs of its own: 1024 triangles and more, whose BVH may be limited
    qc_maxVertices = (qc_maxSide + 1) * (qc_maxSide + 1),
    qc_maxTriangles = 2 * qc_maxSide * qc_maxSide,
    qc_maxFreeVertices = 12, ///< of a body whose coordinates are in the input
    qc_maxFreeTriangles = 10,
    qc_maxOperations = 40
};

/// A body as it should be; positions are those that the scene holds.
typedef struct Body
{
    bool isUsed, hasStart; ///< hasStart: it was there when motion was marked
    qcBodyId id;
    qcBodyDef def;
    double positions[3 * qc_maxVertices], startPositions[3 * qc_maxVertices];
    qcTransform startTransform;
    uint32_t indices[3 * qc_maxTriangles];
} Body;

typedef struct World
{
    FuzzBytes bytes;
    qcScene* scene;
    qcBodyId stale; ///< of a removed body, or of none
    bool isWild;    ///< has lengths whose squares are not normal: no contacts
    bool hasLarge;  ///< had a sheet with more squares than are usual
    int exponent;   ///< the unit of coordinates is this power of two
    Body body[qc_slots];
} World;

//  ---- memory that fails -------------------------------------------------------------------------------------------

static size_t s_left = SIZE_MAX; ///< allocations until one fails

static void* Allocate(size_t size, void* context)
{
    (void)context;
    return __atomic_fetch_sub(&s_left, 1, __ATOMIC_RELAXED) == 0 ? NULL : aligned_alloc(64, (size + 63) / 64 * 64);
}

static void Release(void* memory, size_t size, void* context)
{
    (void)size;
    (void)context;
    free(memory);
}

//  ---- values from bytes -------------------------------------------------------------------------------------------

static double TakeCoordinate(World* w)
{
    static const double special[] = {NAN, INFINITY, -INFINITY, 0x1p-1074, -0x1p-1030, DBL_MAX, -0.0, 0x1p-1022};
    uint8_t way = Fuzz_TakeByte(&w->bytes);
    if (way < 250)
        return ldexp((way % 25) / 4.0 - 3.0, w->exponent);
    if (way < 254)
        return ldexp((double)(int16_t)(uint16_t)Fuzz_TakeBits(&w->bytes, 2) / 8192.0, w->exponent);
    w->isWild = true;
    return special[Fuzz_TakeBelow(&w->bytes, 8)];
}

static bool AreFinite(const double* numbers, int count)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(numbers[i]))
            return false;
    return true;
}

static qcTransform TakeTransform(World* w)
{
    qcTransform transform = qcIdentityTransform();
    for (uint32_t i = Fuzz_TakeBelow(&w->bytes, 4); i > 0; i--)
    {
        double value = ldexp(TakeCoordinate(w), -w->exponent);
        transform.linear[Fuzz_TakeBelow(&w->bytes, 9)] = value;
    }
    for (int axis = 0; axis < 3; axis++)
        transform.translation[axis] = TakeCoordinate(w);
    return transform;
}

static double TakeMargin(World* w)
{
    uint32_t way = Fuzz_TakeBelow(&w->bytes, 4);
    return way == 0 ? INFINITY : way == 1 ? 0.0 : fabs(TakeCoordinate(w));
}

/// Positions in a type. False: the type does not hold one of them.
static bool Pack(const double* positions, uint32_t count, qcPositionType type, double packed[3 * qc_maxVertices])
{
    if (type == qc_positionF64)
    {
        memcpy(packed, positions, 3 * count * sizeof *packed);
        return AreFinite(positions, 3 * (int)count);
    }
    bool isFinite = true;
    for (uint32_t i = 0; i < 3 * count; i++)
    {
        float x = fabs(positions[i]) <= (double)FLT_MAX || isnan(positions[i]) ? (float)positions[i] : INFINITY;
        isFinite = isFinite && isfinite(x);
        memcpy((char*)packed + i * sizeof x, &x, sizeof x);
    }
    return isFinite;
}

/// Packed positions with a gap behind each.
static void Spread(const double* packed, uint32_t count, qcPositionType type, double spread[5 * qc_maxVertices])
{
    size_t size = type == qc_positionF64 ? 3 * sizeof(double) : 3 * sizeof(float);
    for (uint32_t v = 0; v < count; v++)
        memcpy((char*)spread + (size + sizeof(double)) * v, (const char*)packed + size * v, size);
}

/// What the scene holds of positions that it was given in a type.
static void Round(double* positions, uint32_t count, qcPositionType type)
{
    for (uint32_t i = 0; i < 3 * count && type == qc_positionF32; i++)
        positions[i] = (double)(float)positions[i];
}

//  ---- shapes ------------------------------------------------------------------------------------------------------

/// A rough sheet, at a place of the input. Lengths are multiples of an eighth of the unit.
static void MakeSheet(World* w, Body* body)
{
    uint8_t way = Fuzz_TakeByte(&w->bytes);
    bool isLarge = way >= 240 && !w->hasLarge;
    w->hasLarge = w->hasLarge || isLarge;
    uint32_t largest = body->def.selfCollision ? qc_largeSide - way % 4u : qc_maxSide;
    uint32_t side = isLarge ? largest : 1u + way % qc_usualSide;
    uint32_t across = side + 1, noise = Fuzz_TakeByte(&w->bytes);
    uint32_t most = 1 + Fuzz_TakeBelow(&w->bytes, 8);
    double at[3];
    for (int axis = 0; axis < 3; axis++)
        at[axis] = TakeCoordinate(w);
    for (uint32_t v = 0; v < across * across; v++)
    {
        noise = noise * 1664525u + 1013904223u;
        const double place[3] = {(double)(v % across), (double)((noise >> 24) % most) / 4.0, (double)(v / across)};
        for (int axis = 0; axis < 3; axis++)
            body->positions[3 * v + (uint32_t)axis] = at[axis] + ldexp(place[axis] / 2.0, w->exponent);
    }
    for (uint32_t square = 0; square < side * side; square++)
    {
        uint32_t v = square / side * across + square % side;
        const uint32_t corners[6] = {v, v + 1, v + across, v + 1, v + across + 1, v + across};
        memcpy(body->indices + 6 * (size_t)square, corners, sizeof corners);
    }
    body->def.vertexCount = across * across;
    body->def.triangleCount = 2 * side * side;
}

/// Any triangles. False: an index is out of range.
static bool MakeSoup(World* w, Body* body)
{
    qcBodyDef* def = &body->def;
    bool isGood = true;
    def->vertexCount = Fuzz_TakeBelow(&w->bytes, qc_maxFreeVertices + 1);
    def->triangleCount = Fuzz_TakeBelow(&w->bytes, qc_maxFreeTriangles + 1);
    for (uint32_t i = 0; i < 3 * def->vertexCount; i++)
        body->positions[i] = TakeCoordinate(w);
    for (uint32_t i = 0; i < 3 * def->triangleCount; i++)
    {
        // Strips mostly; indices out of range seldom.
        uint8_t way = Fuzz_TakeByte(&w->bytes);
        body->indices[i] = way < 128 ? i / 3 + i % 3 : way % (def->vertexCount + 1);
        isGood = isGood && body->indices[i] < def->vertexCount;
    }
    return isGood;
}

/// Other positions: single coordinates, anywhere or by little, or all at once, by a bend across one axis.
static void ChangePositions(World* w, double* positions, uint32_t count)
{
    uint8_t way = Fuzz_TakeByte(&w->bytes);
    uint32_t axis = way >> 4 & 3u;
    bool byLittle = (way & 8) != 0;
    if (axis < 3 && !byLittle)
    {
        double most = TakeCoordinate(w) / 8.0;
        uint32_t period = 1 + Fuzz_TakeBelow(&w->bytes, 16);
        for (uint32_t v = 0; v < count; v++)
            positions[3 * v + axis] += v % period == 0 ? most : 0.0;
    }
    for (uint32_t i = way % 8; i > 0 && count > 0; i--)
    {
        uint32_t at = Fuzz_TakeBelow(&w->bytes, 3 * count);
        positions[at] = byLittle ? positions[at] + TakeCoordinate(w) / 8.0 : TakeCoordinate(w);
    }
}

//  ---- operations --------------------------------------------------------------------------------------------------

static void AddBody(World* w)
{
    Body body = {.isUsed = true, .def = qcDefaultBodyDef()};
    qcBodyDef* def = &body.def;
    uint8_t flags = Fuzz_TakeByte(&w->bytes);
    def->deforming = (flags & 1) != 0;
    def->positionType = (flags & 2) != 0 ? qc_positionF32 : qc_positionF64;
    def->selfCollision = (flags & 12) != 0;
    def->owner = flags >> 4 & 1;
    def->margin = (flags & 32) != 0 ? TakeMargin(w) : INFINITY;
    bool isGood = !isnan(def->margin);
    if ((flags & 128) != 0)
        MakeSheet(w, &body);
    else
        isGood = MakeSoup(w, &body) && isGood;
    if (!def->deforming && (flags & 64) != 0)
        def->transform = TakeTransform(w);
    double packed[3 * qc_maxVertices];
    isGood = Pack(body.positions, def->vertexCount, def->positionType, packed) && isGood;
    isGood = isGood && AreFinite(def->transform.linear, 9) && AreFinite(def->transform.translation, 3);
    def->positions = packed;
    def->indices = body.indices;
    qcStatus status = qcScene_AddBody(w->scene, def, &body.id);
    uint32_t count = 0;
    for (int slot = 0; slot < qc_slots; slot++)
        count += w->body[slot].isUsed;
    if (status == qc_statusOk && count == qc_slots)
    {
        // The model is full.
        FUZZ_CHECK(qcScene_RemoveBody(w->scene, body.id) == qc_statusOk);
        w->stale = body.id;
        return;
    }
    FUZZ_CHECK(status == qc_statusOk ? isGood : status == qc_statusBadInput);
    // Positions may be finite and leave the range of doubles in the world.
    FUZZ_CHECK(status == qc_statusOk || !isGood || w->isWild);
    if (status != qc_statusOk)
        return;
    FUZZ_CHECK(body.id.slot < qc_slots && !w->body[body.id.slot].isUsed);
    Round(body.positions, def->vertexCount, def->positionType);
    w->body[body.id.slot] = body;
}

static void SetVertices(World* w, Body* body)
{
    double positions[3 * qc_maxVertices], packed[3 * qc_maxVertices], spread[5 * qc_maxVertices] = {0};
    memcpy(positions, body->positions, sizeof positions);
    uint32_t way = Fuzz_TakeBelow(&w->bytes, 4);
    qcPositionType type = way % 2 == 0 ? qc_positionF32 : qc_positionF64;
    size_t stride =
        way < 2 ? 0 : (type == qc_positionF64 ? 4 : 5) * (type == qc_positionF64 ? sizeof(double) : sizeof(float));
    uint32_t count = body->def.vertexCount;
    ChangePositions(w, positions, count);
    bool isGood = Pack(positions, count, type, packed) && body->def.deforming;
    Spread(packed, count, type, spread);
    qcStatus status = qcScene_SetVertices(w->scene, body->id, stride == 0 ? packed : spread, type, stride);
    FUZZ_CHECK(status == (isGood ? qc_statusOk : qc_statusBadInput));
    if (!isGood)
        return;
    Round(positions, count, type);
    memcpy(body->positions, positions, sizeof positions);
}

static void SetTransform(World* w, Body* body)
{
    qcTransform transform = TakeTransform(w);
    bool isGood = !body->def.deforming && AreFinite(transform.linear, 9) && AreFinite(transform.translation, 3);
    qcStatus status = qcScene_SetTransform(w->scene, body->id, &transform);
    FUZZ_CHECK(status == qc_statusOk ? isGood : status == qc_statusBadInput);
    FUZZ_CHECK(status == qc_statusOk || !isGood || w->isWild);
    if (status == qc_statusOk)
        body->def.transform = transform;
}

static void Switch(World* w, Body* body)
{
    qcBodyDef* def = &body->def;
    switch (Fuzz_TakeBelow(&w->bytes, 4))
    {
        case 0:
            def->activity = (qcActivity)Fuzz_TakeBelow(&w->bytes, 3);
            FUZZ_CHECK(qcScene_SetActivity(w->scene, body->id, def->activity) == qc_statusOk);
            break;
        case 1:
            // Brute force would take long for the pairs of the largest sheet.
            def->selfCollision = !def->selfCollision && def->vertexCount <= (qc_largeSide + 1) * (qc_largeSide + 1);
            FUZZ_CHECK(qcScene_SetSelfCollision(w->scene, body->id, def->selfCollision) == qc_statusOk);
            break;
        case 2:
        {
            double margin = TakeMargin(w);
            qcStatus status = qcScene_SetMargin(w->scene, body->id, margin);
            FUZZ_CHECK(status == (isnan(margin) ? qc_statusBadInput : qc_statusOk));
            def->margin = status == qc_statusOk ? margin : def->margin;
            break;
        }
        default:
            def->group = Fuzz_TakeBelow(&w->bytes, 4);
            def->mask = Fuzz_TakeBelow(&w->bytes, 4);
            FUZZ_CHECK(qcScene_SetFilter(w->scene, body->id, def->group, def->mask) == qc_statusOk);
    }
}

static void MarkStart(World* w)
{
    FUZZ_CHECK(qcScene_MarkStart(w->scene) == qc_statusOk);
    for (int slot = 0; slot < qc_slots; slot++)
    {
        Body* body = &w->body[slot];
        body->hasStart = body->isUsed;
        body->startTransform = body->def.transform;
        memcpy(body->startPositions, body->positions, sizeof body->positions);
    }
}

static void RemoveBody(World* w, Body* body)
{
    w->stale = body->id;
    FUZZ_CHECK(qcScene_RemoveBody(w->scene, body->id) == qc_statusOk);
    FUZZ_CHECK(qcScene_RemoveBody(w->scene, body->id) == qc_statusBadInput);
    body->isUsed = false;
}

static void UseWrongId(World* w)
{
    qcBodyId id = w->stale;
    if (Fuzz_TakeBelow(&w->bytes, 2) == 0)
        id = (qcBodyId){(uint32_t)Fuzz_TakeBits(&w->bytes, 4), (uint32_t)Fuzz_TakeBits(&w->bytes, 4)};
    for (int slot = 0; slot < qc_slots; slot++)
        if (w->body[slot].isUsed && memcmp(&w->body[slot].id, &id, sizeof id) == 0)
            return;
    const double position[3] = {0, 0, 0};
    qcTransform transform = qcIdentityTransform();
    FUZZ_CHECK(!qcScene_IsValid(w->scene, id));
    FUZZ_CHECK(qcScene_RemoveBody(w->scene, id) == qc_statusBadInput);
    FUZZ_CHECK(qcScene_SetTransform(w->scene, id, &transform) == qc_statusBadInput);
    FUZZ_CHECK(qcScene_SetVertices(w->scene, id, position, qc_positionF64, 0) == qc_statusBadInput);
    FUZZ_CHECK(qcScene_SetActivity(w->scene, id, qc_activityStatic) == qc_statusBadInput);
    FUZZ_CHECK(qcScene_SetFilter(w->scene, id, 1, 1) == qc_statusBadInput);
    FUZZ_CHECK(qcScene_SetSelfCollision(w->scene, id, false) == qc_statusBadInput);
    FUZZ_CHECK(qcScene_SetMargin(w->scene, id, 0.0) == qc_statusBadInput);
}

static void EnterStage(const char* stage)
{
    FUZZ_CHECK(stage[0] != '\0');
}

static void LeaveStage(void)
{
}

/// Definitions that no scene accepts.
static void UseWrongDefinition(World* w)
{
    qcDetectDef def = qcDefaultDetectDef();
    const qcResult* result;
    switch (Fuzz_TakeBelow(&w->bytes, 12))
    {
        case 0: def.method = (qcMethod)99; break;
        case 1: def.enterStage = EnterStage; break;
        case 2: def.margin = -1.0; break;
        case 3: def.contactMargin = INFINITY; break;
        case 4: def.spacing = NAN; break;
        case 5: def.layerColumns = 5000; break;
        case 6: def.layerDepthAxis = 'w'; break;
        case 7: def.motion = def.segments = true; break;
        case 8: def.margin = def.motion = true; break;
        case 9: def.structSize = 3; break;
        case 10:
            def.method = qc_methodQuick;
            def.resolution = 0;
            break;
        default: def.method = qc_methodCullide; memcpy(def.views, "xx", 3);
    }
    FUZZ_CHECK(qcScene_Detect(w->scene, &def, &result) == qc_statusBadInput);
    FUZZ_CHECK(qcLastMessage()[0] != '\0');
}

//  ---- steps -------------------------------------------------------------------------------------------------------

static bool FilterPairs(void* context, uint32_t slotA, uint32_t slotB)
{
    (void)context;
    return (slotA + slotB) % 2 == 0;
}

static qcDetectDef TakeRequest(World* w)
{
    static const qcMethod methods[] = {qc_methodSweep, qc_methodAuto, qc_methodLayers, qc_methodBrute};
    qcDetectDef def = qcDefaultDetectDef();
    uint8_t flags = Fuzz_TakeByte(&w->bytes), more = Fuzz_TakeByte(&w->bytes);
    def.method = methods[(flags & 3) == 3 ? more % 4 : 0];
    def.threads = (flags & 0x1c) == 0x1c ? 2 : 1;
    def.touching = (flags & 32) != 0;
    def.neighbours = (flags & 64) != 0;
    def.margin = (flags & 128) != 0 ? TakeMargin(w) : 0.0;
    def.segments = (more & 4) != 0;
    def.proximities = (more & 8) != 0;
    def.manifolds = (more & 16) != 0;
    def.motion = (more & 96) == 96;
    def.pairFilter = (more & 128) != 0 ? FilterPairs : NULL;
    uint8_t rest = Fuzz_TakeByte(&w->bytes);
    if ((rest & 3) == 3 && !w->isWild && abs(w->exponent) < 150)
    {
        def.contactMargin = fabs(TakeCoordinate(w));
        def.nearestContacts = (rest & 4) != 0;
    }
    if ((rest & 24) == 24)
        def.spacing = ldexp(rest >> 5, w->exponent);
    if ((flags & 3) != 2)
        return def;
    uint8_t reports = Fuzz_TakeByte(&w->bytes);
    def.candidates = (reports & 1) != 0;
    def.unoriented = (reports & 2) != 0;
    def.sets = (reports & 4) != 0;
    def.enterStage = (reports & 8) != 0 ? EnterStage : NULL;
    def.leaveStage = (reports & 8) != 0 ? LeaveStage : NULL;
    return def;
}

/// A new scene of the bodies, in the same slots, with the same motion.
static qcScene* MakeReference(const World* w, bool moves)
{
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcScene* scene;
    FUZZ_CHECK(qcScene_Create(&sceneDef, &scene) == qc_statusOk);
    qcBodyId ids[qc_slots];
    for (int slot = 0; slot < qc_slots; slot++)
    {
        const Body* body = &w->body[slot];
        qcBodyDef def = body->isUsed ? body->def : qcDefaultBodyDef();
        bool fromStart = moves && body->hasStart;
        def.positions = fromStart ? body->startPositions : body->positions;
        def.positionType = qc_positionF64;
        def.indices = body->indices;
        if (fromStart)
            def.transform = body->startTransform;
        FUZZ_CHECK(qcScene_AddBody(scene, &def, &ids[slot]) == qc_statusOk);
    }
    FUZZ_CHECK(!moves || qcScene_MarkStart(scene) == qc_statusOk);
    for (int slot = 0; slot < qc_slots; slot++)
    {
        const Body* body = &w->body[slot];
        if (!body->isUsed)
            FUZZ_CHECK(qcScene_RemoveBody(scene, ids[slot]) == qc_statusOk);
        else if (moves && body->def.deforming)
            FUZZ_CHECK(qcScene_SetVertices(scene, ids[slot], body->positions, qc_positionF64, 0) == qc_statusOk);
        else if (moves)
            FUZZ_CHECK(qcScene_SetTransform(scene, ids[slot], &body->def.transform) == qc_statusOk);
    }
    return scene;
}

#define CHECK_SAME(array, countField)                                                                                  \
    do                                                                                                                 \
    {                                                                                                                  \
        FUZZ_CHECK(found->countField == expected->countField);                                                         \
        if (found->countField != 0 && expected->array != NULL)                                                         \
            FUZZ_CHECK(memcmp(found->array, expected->array, found->countField * sizeof *found->array) == 0);          \
    } while (0)

/// The sweep proves more pairs of a motion apart than brute force.
static void CheckSubset(const qcResult* found, const qcResult* expected)
{
    size_t at = 0;
    for (size_t i = 0; i < found->pairCount; i++, at++)
    {
        while (at < expected->pairCount && memcmp(&expected->pairs[at], &found->pairs[i], sizeof *found->pairs) != 0)
            at++;
        FUZZ_CHECK(at < expected->pairCount);
    }
}

static int CompareCandidates(const qcCandidate* a, const qcCandidate* b)
{
    const uint32_t x[4] = {a->bodyA, a->triangleA, a->bodyB, a->triangleB};
    const uint32_t y[4] = {b->bodyA, b->triangleA, b->bodyB, b->triangleB};
    int i = 0;
    while (i < 3 && x[i] == y[i])
        i++;
    return (x[i] > y[i]) - (x[i] < y[i]);
}

/// Candidates ascend, and each pair is one of them.
static void CheckCandidates(const qcResult* found)
{
    size_t at = 0;
    for (size_t i = 1; i < found->candidateCount; i++)
        FUZZ_CHECK(CompareCandidates(&found->candidates[i - 1], &found->candidates[i]) < 0);
    for (size_t i = 0; i < found->pairCount; i++)
    {
        const qcPair* pair = &found->pairs[i];
        const qcCandidate candidate = {pair->bodyA, pair->triangleA, pair->bodyB, pair->triangleB};
        while (at < found->candidateCount && CompareCandidates(&found->candidates[at], &candidate) < 0)
            at++;
        FUZZ_CHECK(at < found->candidateCount && CompareCandidates(&found->candidates[at], &candidate) == 0);
    }
}

static void CompareResults(const qcDetectDef* def, const qcResult* found, const qcResult* expected)
{
    if (def->motion && def->method != qc_methodBrute)
    {
        CheckSubset(found, expected);
        return;
    }
    CHECK_SAME(pairs, pairCount);
    CHECK_SAME(segments, pairCount);
    CHECK_SAME(proximities, pairCount);
    CHECK_SAME(contacts, contactCount);
    CHECK_SAME(manifolds, manifoldCount);
    CHECK_SAME(manifoldPoints, manifoldPointCount);
}

static qcStatus DetectLater(World* w, const qcDetectDef* def, const qcResult** result)
{
    qcStatus status = qcScene_DetectBegin(w->scene, def);
    if (status != qc_statusOk)
        return status;
    FUZZ_CHECK(qcScene_MarkStart(w->scene) == qc_statusBadInput);
    FUZZ_CHECK(qcScene_DetectBegin(w->scene, def) == qc_statusBadInput);
    return qcScene_DetectEnd(w->scene, result);
}

static void Detect(World* w)
{
    qcDetectDef def = TakeRequest(w);
    const qcResult *found = NULL, *expected = NULL;
    uint8_t way = Fuzz_TakeByte(&w->bytes);
    if (way % 8 == 7)
    {
        // A step that runs out of memory, or holds too many pairs, changes nothing.
        if (way < 128)
            __atomic_store_n(&s_left, way / 8, __ATOMIC_RELAXED);
        else
            def.maxPairs = 1 + (uint64_t)(way - 128) / 8;
        qcStatus status = qcScene_Detect(w->scene, &def, &found);
        __atomic_store_n(&s_left, SIZE_MAX, __ATOMIC_RELAXED);
        FUZZ_CHECK(status == qc_statusOk || status == qc_statusBadInput ||
                   status == (way < 128 ? qc_statusOutOfMemory : qc_statusTooManyPairs));
        def.maxPairs = 0;
    }
    qcScene* scene = MakeReference(w, def.motion);
    qcDetectDef brute = def;
    brute.method = qc_methodBrute;
    brute.threads = 1;
    qcStatus status = way % 8 == 6 ? DetectLater(w, &def, &found) : qcScene_Detect(w->scene, &def, &found);
    FUZZ_CHECK(status == qcScene_Detect(scene, &brute, &expected));
    FUZZ_CHECK(status == qc_statusOk || status == qc_statusBadInput);
    if (status == qc_statusOk)
        CompareResults(&def, found, expected);
    if (status == qc_statusOk && def.candidates)
        CheckCandidates(found);
    qcScene_Destroy(scene);
}

static void RunOperation(World* w)
{
    uint8_t what = Fuzz_TakeByte(&w->bytes);
    Body* body = &w->body[what >> 4 & 3];
    uint32_t operation = what & 15;
    if (operation < 2 || (!body->isUsed && operation < 9))
        AddBody(w);
    else if (operation == 2)
        RemoveBody(w, body);
    else if (operation < 4)
        SetTransform(w, body);
    else if (operation < 7)
        SetVertices(w, body);
    else if (operation < 9)
        Switch(w, body);
    else if (operation == 9)
        MarkStart(w);
    else if (operation == 10)
    {
        UseWrongId(w);
        UseWrongDefinition(w);
    }
    else
        Detect(w);
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    static const int exponents[] = {0, 0, 0, 0, -20, 30, -140, 120, -400, 300, -1000, 800, -1074, 900, 1, -3};
    static bool isReady;
    if (!isReady)
        FUZZ_CHECK(qcSetAllocator(Allocate, Release, NULL) == qc_statusOk);
    isReady = true;
    World w = {.bytes = {data, size}};
    w.exponent = exponents[Fuzz_TakeBelow(&w.bytes, 16)];
    w.isWild = abs(w.exponent) > 200;
    qcSceneDef def = qcDefaultSceneDef();
    FUZZ_CHECK(qcScene_Create(&def, &w.scene) == qc_statusOk);
    for (int i = 0; i < qc_maxOperations && w.bytes.size > 0; i++)
        RunOperation(&w);
    Detect(&w);
    qcScene_Destroy(w.scene);
    return 0;
}
