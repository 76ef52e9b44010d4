// The life of a broadphase as Bullet calls it, against lists of all proxies: the pair cache after each search, box
// tests, rays, groups and masks, filter and query callbacks, proxies that come and go, failed allocations, a pool that
// starts anew. And its recording, which brute force replays.
#include "fuzz/fuzz.h"

#include "quickcullide/bullet_broadphase.h"
#include "quickcullide/recording.h"

#include <LinearMath/btIDebugDraw.h>

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace
{
enum
{
    qc_maxProxies = 20,
    qc_maxOperations = 100
};

/// A proxy as it should be; `number` is its user pointer.
struct Model
{
    btBroadphaseProxy* proxy = nullptr;
    btVector3 lower{0, 0, 0}, upper{0, 0, 0}; ///< the fourth component is compared, too
    int number = 0;
};

/// Accepts two of three pairs.
struct Filter : btOverlapFilterCallback
{
    bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override
    {
        return (*static_cast<const int*>(a->m_clientObject) + *static_cast<const int*>(b->m_clientObject)) % 3 != 0;
    }
};

struct World
{
    FuzzBytes bytes;
    qcBroadphase broadphase;
    Model models[qc_maxProxies];
    bool hasNan = false; ///< boxes without bounds: what rays meet is not checked
    Filter filter;
    bool hasFilter = false;
    int file = -1; ///< of the recording; -1: none
};

//  ---- memory ------------------------------------------------------------------------------------------------------

size_t s_left = SIZE_MAX; ///< allocations until they fail

void* Allocate(size_t size, void*)
{
    if (s_left == 0)
        return nullptr;
    s_left -= s_left != SIZE_MAX;
    return std::aligned_alloc(64, (size + 63) / 64 * 64);
}

void Release(void* memory, size_t, void*)
{
    std::free(memory);
}

//  ---- boxes -------------------------------------------------------------------------------------------------------

/// Small multiples of a half: boxes touch often.
btScalar TakeCoordinate(World* w)
{
    return btScalar(int8_t(Fuzz_TakeByte(&w->bytes)) / 8) / 2;
}

void TakeBox(World* w, btVector3* lower, btVector3* upper)
{
    uint8_t way = Fuzz_TakeByte(&w->bytes);
    for (int axis = 0; axis < 3; axis++)
    {
        (*lower)[axis] = TakeCoordinate(w);
        (*upper)[axis] = (*lower)[axis] + btScalar(Fuzz_TakeBelow(&w->bytes, way < 64 ? 2 : 8)) / 2;
    }
    if (way == 255)
    {
        (*upper)[way % 3] = btScalar(NAN);
        w->hasNan = true;
    }
}

/// Bounds that are NaN overlap everything, as in TestAabbAgainstAabb2.
bool Overlap(const btVector3& lowerA, const btVector3& upperA, const btVector3& lowerB, const btVector3& upperB)
{
    for (int axis = 0; axis < 3; axis++)
        if (lowerA[axis] > upperB[axis] || upperA[axis] < lowerB[axis])
            return false;
    return true;
}

bool Collide(const World* w, const Model& a, const Model& b)
{
    btBroadphaseProxy *x = a.proxy, *y = b.proxy;
    if (!Overlap(a.lower, a.upper, b.lower, b.upper))
        return false;
    if (w->hasFilter)
        return w->filter.needBroadphaseCollision(x, y);
    return (x->m_collisionFilterGroup & y->m_collisionFilterMask) != 0 &&
           (y->m_collisionFilterGroup & x->m_collisionFilterMask) != 0;
}

//  ---- changes -----------------------------------------------------------------------------------------------------

void Create(World* w, Model* model)
{
    TakeBox(w, &model->lower, &model->upper);
    int group = int(1 + Fuzz_TakeBelow(&w->bytes, 3)), mask = int(Fuzz_TakeBelow(&w->bytes, 8)) - 1;
    model->proxy = w->broadphase.createProxy(model->lower, model->upper, 0, &model->number, group, mask, nullptr);
    FUZZ_CHECK(model->proxy != nullptr || s_left == 0);
    FUZZ_CHECK(model->proxy == nullptr || model->proxy->m_clientObject == &model->number);
}

void Destroy(World* w, Model* model)
{
    w->broadphase.destroyProxy(model->proxy, nullptr);
    model->proxy = nullptr;
}

void Move(World* w, Model* model)
{
    TakeBox(w, &model->lower, &model->upper);
    w->broadphase.setAabb(model->proxy, model->lower, model->upper, nullptr);
    btVector3 lower, upper;
    w->broadphase.getAabb(model->proxy, lower, upper);
    FUZZ_CHECK(lower == model->lower);
}

/// A filter is read when the box is set.
void ChangeMask(World* w, Model* model)
{
    model->proxy->m_collisionFilterMask = int(Fuzz_TakeBelow(&w->bytes, 8)) - 1;
    w->broadphase.setAabb(model->proxy, model->lower, model->upper, nullptr);
}

void DestroyAll(World* w)
{
    for (Model& model : w->models)
        if (model.proxy != nullptr)
            Destroy(w, &model);
    w->broadphase.resetPool(nullptr);
    FUZZ_CHECK(w->broadphase.getOverlappingPairCache()->getNumOverlappingPairs() == 0);
}

//  ---- searches ----------------------------------------------------------------------------------------------------

using Numbers = std::pair<const void*, const void*>;

Numbers NumbersOf(const void* a, const void* b)
{
    return {std::min(a, b), std::max(a, b)};
}

void Search(World* w)
{
    w->broadphase.calculateOverlappingPairs(nullptr);
    std::set<Numbers> expected, found;
    for (int i = 0; i < qc_maxProxies; i++)
        for (int k = 0; k < i; k++)
            if (w->models[i].proxy != nullptr && w->models[k].proxy != nullptr &&
                Collide(w, w->models[i], w->models[k]))
                expected.insert(NumbersOf(&w->models[i].number, &w->models[k].number));
    btOverlappingPairCache* cache = w->broadphase.getOverlappingPairCache();
    for (int i = 0; i < cache->getNumOverlappingPairs(); i++)
    {
        const btBroadphasePair& pair = cache->getOverlappingPairArrayPtr()[i];
        FUZZ_CHECK(found.insert(NumbersOf(pair.m_pProxy0->m_clientObject, pair.m_pProxy1->m_clientObject)).second);
        FUZZ_CHECK(cache->findPair(pair.m_pProxy0, pair.m_pProxy1) == &pair);
    }
    FUZZ_CHECK(found == expected);
}

struct Boxes : btBroadphaseAabbCallback
{
    std::set<const void*> numbers;
    bool process(const btBroadphaseProxy* proxy) override
    {
        FUZZ_CHECK(numbers.insert(proxy->m_clientObject).second);
        return true;
    }
};

void TestBox(World* w)
{
    btVector3 lower, upper;
    bool hadNan = w->hasNan;
    TakeBox(w, &lower, &upper);
    w->hasNan = hadNan;
    Boxes boxes;
    w->broadphase.aabbTest(lower, upper, boxes);
    for (const Model& model : w->models)
        if (model.proxy != nullptr)
            FUZZ_CHECK(Overlap(model.lower, model.upper, lower, upper) == (boxes.numbers.count(&model.number) == 1));
}

/// Changes proxies while boxes are reported. What it changes takes effect behind the test.
struct ChangingBoxes : Boxes
{
    World* w;
    std::set<const void*> destroyed;
    explicit ChangingBoxes(World* world) : w(world)
    {
    }
    bool process(const btBroadphaseProxy* proxy) override
    {
        FUZZ_CHECK(destroyed.count(proxy->m_clientObject) == 0);
        Boxes::process(proxy);
        Model* model = &w->models[Fuzz_TakeBelow(&w->bytes, qc_maxProxies)];
        uint32_t what = Fuzz_TakeBelow(&w->bytes, 4);
        if (model->proxy == nullptr && destroyed.count(&model->number) == 0)
            Create(w, model);
        else if (model->proxy != nullptr && what == 0)
        {
            destroyed.insert(&model->number);
            Destroy(w, model);
        }
        else if (model->proxy != nullptr && what == 1)
        {
            TakeBox(w, &model->lower, &model->upper);
            w->broadphase.setAabb(model->proxy, model->lower, model->upper, nullptr);
        }
        FUZZ_CHECK(w->broadphase.record(nullptr) == qc_statusBadInput);
        return true;
    }
};

void TestBoxWithChanges(World* w)
{
    btVector3 lower, upper;
    bool hadNan = w->hasNan;
    TakeBox(w, &lower, &upper);
    w->hasNan = hadNan;
    std::set<const void*> expected;
    for (const Model& model : w->models)
        if (model.proxy != nullptr && Overlap(model.lower, model.upper, lower, upper))
            expected.insert(&model.number);
    ChangingBoxes boxes(w);
    w->broadphase.aabbTest(lower, upper, boxes);
    for (const void* number : boxes.numbers)
        FUZZ_CHECK(expected.count(number) == 1);
    for (const void* number : expected)
        FUZZ_CHECK(boxes.numbers.count(number) == 1 || boxes.destroyed.count(number) == 1);
}

struct Ray : btBroadphaseRayCallback
{
    std::set<const void*> numbers;
    bool process(const btBroadphaseProxy* proxy) override
    {
        FUZZ_CHECK(numbers.insert(proxy->m_clientObject).second);
        return true;
    }
};

/// Along one axis: what the ray meets is then beyond doubt.
void CastRay(World* w)
{
    btVector3 from(TakeCoordinate(w), TakeCoordinate(w), TakeCoordinate(w)), to = from;
    int axis = int(Fuzz_TakeBelow(&w->bytes, 3));
    to[axis] += btScalar(1 + Fuzz_TakeBelow(&w->bytes, 40)) / 2;
    Ray ray;
    btVector3 way = to - from;
    for (int k = 0; k < 3; k++)
    {
        ray.m_rayDirectionInverse[k] = k == axis ? btScalar(1) : btScalar(BT_LARGE_FLOAT);
        ray.m_signs[k] = 0;
    }
    ray.m_lambda_max = way[axis];
    w->broadphase.rayTest(from, to, ray);
    for (const Model& model : w->models)
        if (model.proxy != nullptr && !w->hasNan && Overlap(model.lower, model.upper, from, to))
            FUZZ_CHECK(ray.numbers.count(&model.number) == 1);
}

//  ---- the whole ---------------------------------------------------------------------------------------------------

struct Drawer : btIDebugDraw
{
    int boxes = 0, lines = 0;
    void drawAabb(const btVector3&, const btVector3&, const btVector3&) override
    {
        boxes++;
    }
    void drawLine(const btVector3&, const btVector3&, const btVector3&) override
    {
        lines++;
    }
    void drawContactPoint(const btVector3&, const btVector3&, btScalar, int, const btVector3&) override
    {
    }
    void reportErrorWarning(const char*) override
    {
    }
    void draw3dText(const btVector3&, const char*) override
    {
    }
    void setDebugMode(int) override
    {
    }
    int getDebugMode() const override
    {
        return 0;
    }
};

/// Bounds, and what is drawn.
void LookAtAll(World* w)
{
    Drawer drawer;
    w->broadphase.debugDraw(&drawer);
    int count = 0;
    bool anyNan = false;
    btVector3 lower(0, 0, 0), upper(0, 0, 0), foundLower, foundUpper;
    for (const Model& model : w->models)
    {
        if (model.proxy == nullptr)
            continue;
        bool isNan = std::isnan(model.upper.x() + model.upper.y() + model.upper.z());
        anyNan = anyNan || isNan;
        if (isNan)
            continue;
        if (count == 0)
        {
            lower = model.lower;
            upper = model.upper;
        }
        lower.setMin(model.lower);
        upper.setMax(model.upper);
        count++;
    }
    FUZZ_CHECK(drawer.boxes == count);
    int pairs = w->broadphase.getOverlappingPairCache()->getNumOverlappingPairs();
    FUZZ_CHECK(anyNan ? drawer.lines <= pairs : drawer.lines == pairs);
    w->broadphase.getBroadphaseAabb(foundLower, foundUpper);
    for (int axis = 0; axis < 3; axis++)
        FUZZ_CHECK(anyNan || (foundLower[axis] == lower[axis] && foundUpper[axis] == upper[axis]));
}

void SwitchFilter(World* w)
{
    w->hasFilter = !w->hasFilter;
    w->broadphase.getOverlappingPairCache()->setOverlapFilterCallback(w->hasFilter ? &w->filter : nullptr);
}

//  ---- recordings --------------------------------------------------------------------------------------------------

struct Recorded
{
    double bounds[6];
    uint32_t group, mask;
};

using RecordedBoxes = std::map<uint32_t, Recorded>;

bool Overlap(const double* a, const double* b)
{
    for (int axis = 0; axis < 3; axis++)
        if (a[axis] > b[3 + axis] || a[3 + axis] < b[axis])
            return false;
    return true;
}

void CheckPairs(const RecordedBoxes& boxes, const qcBoxOperation& operation)
{
    std::vector<qcBoxPair> pairs;
    for (auto a = boxes.begin(); a != boxes.end(); ++a)
        for (auto b = std::next(a); b != boxes.end(); ++b)
        {
            auto isThis = [&](const qcBoxPair& pair) { return pair.a == a->first && pair.b == b->first; };
            bool agrees = operation.hasCallback
                              ? std::none_of(operation.rejected, operation.rejected + operation.rejectedCount, isThis)
                              : (a->second.group & b->second.mask) != 0 && (b->second.group & a->second.mask) != 0;
            if (agrees && Overlap(a->second.bounds, b->second.bounds))
                pairs.push_back({a->first, b->first});
        }
    FUZZ_CHECK(pairs.size() == operation.pairCount);
    FUZZ_CHECK(qcBoxPairs_Hash(pairs.data(), pairs.size()) == operation.pairHash);
}

void CheckQuery(const RecordedBoxes& boxes, const qcBoxOperation& operation)
{
    std::vector<uint32_t> ids;
    for (const auto& box : boxes)
        if (Overlap(box.second.bounds, operation.bounds))
            ids.push_back(box.first);
    FUZZ_CHECK(ids.size() == operation.count && std::equal(ids.begin(), ids.end(), operation.ids));
}

/// An operation by brute force.
void Replay(RecordedBoxes* boxes, const qcOperation& operation)
{
    const qcBoxOperation& o = operation.boxes;
    switch (operation.kind)
    {
        case qc_operationAddBox:
            FUZZ_CHECK(boxes->count(o.ids[0]) == 0);
            (*boxes)[o.ids[0]] = {{}, o.group, o.mask};
            std::copy_n(o.bounds, 6, (*boxes)[o.ids[0]].bounds);
            break;
        case qc_operationRemoveBox: FUZZ_CHECK(boxes->erase(o.ids[0]) == 1); break;
        case qc_operationMoveBoxes:
            for (uint32_t i = 0; i < o.count; i++)
                std::copy_n(o.bounds + 6 * i, 6, boxes->at(o.ids[i]).bounds);
            break;
        case qc_operationSetBoxFilter:
            boxes->at(o.ids[0]).group = o.group;
            boxes->at(o.ids[0]).mask = o.mask;
            break;
        case qc_operationResetBoxes: boxes->clear(); break;
        case qc_operationFindPairs:
            if (!o.isDisturbed)
                CheckPairs(*boxes, o);
            break;
        case qc_operationQueryBox:
            if (!o.isDisturbed)
                CheckQuery(*boxes, o);
            break;
        default: FUZZ_CHECK(operation.kind == qc_operationCastBox);
    }
}

void EndRecording(World* w)
{
    qcStatus status = w->broadphase.record(nullptr);
    FUZZ_CHECK(status == qc_statusOk || status == qc_statusOutOfMemory);
    char path[64];
    std::snprintf(path, sizeof path, "/proc/self/fd/%d", w->file);
    qcRecording* recording = nullptr;
    const qcOperation* operation = nullptr;
    RecordedBoxes boxes;
    FUZZ_CHECK(qcRecording_Open(path, &recording) == qc_statusOk);
    do
    {
        FUZZ_CHECK(qcRecording_Next(recording, &operation) == qc_statusOk);
        if (operation->kind != qc_operationEnd)
            Replay(&boxes, *operation);
    } while (operation->kind != qc_operationEnd);
    qcRecording_Close(recording);
    close(w->file);
    w->file = -1;
}

void SwitchRecording(World* w)
{
    if (w->file >= 0)
    {
        EndRecording(w);
        return;
    }
    w->file = memfd_create("recording", 0);
    char path[64];
    std::snprintf(path, sizeof path, "/proc/self/fd/%d", w->file);
    FUZZ_CHECK(w->file >= 0 && w->broadphase.record(path) == qc_statusOk);
}

//  ---- operations --------------------------------------------------------------------------------------------------

void RunOperation(World* w);

/// An operation that runs out of memory: no pair is missed.
void RunOutOfMemory(World* w)
{
    s_left = Fuzz_TakeBelow(&w->bytes, 8);
    RunOperation(w);
    s_left = SIZE_MAX;
}

/// What few inputs need.
void RunRareOperation(World* w, uint8_t what)
{
    if (what > 245)
        DestroyAll(w);
    else if (what < 40)
        LookAtAll(w);
    else if (what < 80)
        SwitchFilter(w);
    else if (what < 120 && s_left == SIZE_MAX)
        SwitchRecording(w);
    else if (what < 180)
        TestBoxWithChanges(w);
    else if (s_left == SIZE_MAX)
        RunOutOfMemory(w);
}

void RunOperation(World* w)
{
    uint8_t what = Fuzz_TakeByte(&w->bytes);
    Model* model = &w->models[Fuzz_TakeBelow(&w->bytes, qc_maxProxies)];
    switch (what % 12)
    {
        case 0: TestBox(w); break;
        case 1: CastRay(w); break;
        case 2:
        case 3: Search(w); break;
        case 4: RunRareOperation(w, what); break;
        default:
            if (model->proxy == nullptr)
                Create(w, model);
            else if (what % 12 == 5)
                Destroy(w, model);
            else if (what % 12 == 6)
                ChangeMask(w, model);
            else
                Move(w, model);
    }
}
} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    static bool isReady;
    if (!isReady)
        FUZZ_CHECK(qcSetAllocator(Allocate, Release, nullptr) == qc_statusOk);
    isReady = true;
    World w;
    w.bytes = {data, size};
    for (int i = 0; i < qc_maxProxies; i++)
        w.models[i].number = i;
    for (int i = 0; i < qc_maxOperations && w.bytes.size > 0; i++)
        RunOperation(&w);
    Search(&w);
    if (w.file >= 0)
        EndRecording(&w);
    DestroyAll(&w);
    return 0;
}
