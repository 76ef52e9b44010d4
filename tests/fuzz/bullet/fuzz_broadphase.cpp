// The life of a broadphase as Bullet calls it, against lists of all proxies: the pair cache after each search, box
// tests, rays, groups and masks, proxies that come and go, a pool that starts anew.
#include "fuzz/fuzz.h"

#include "quickcullide/bullet_broadphase.h"

#include <algorithm>
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
    btVector3 lower, upper;
    int number = 0;
};

struct World
{
    FuzzBytes bytes;
    qcBroadphase broadphase;
    Model models[qc_maxProxies];
    bool hasNan = false; ///< boxes without bounds: what rays meet is not checked
};

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

bool Collide(const Model& a, const Model& b)
{
    const btBroadphaseProxy *x = a.proxy, *y = b.proxy;
    return Overlap(a.lower, a.upper, b.lower, b.upper) && (x->m_collisionFilterGroup & y->m_collisionFilterMask) != 0 &&
           (y->m_collisionFilterGroup & x->m_collisionFilterMask) != 0;
}

//  ---- changes -----------------------------------------------------------------------------------------------------

void Create(World* w, Model* model)
{
    TakeBox(w, &model->lower, &model->upper);
    int group = int(1 + Fuzz_TakeBelow(&w->bytes, 3)), mask = int(Fuzz_TakeBelow(&w->bytes, 8)) - 1;
    model->proxy = w->broadphase.createProxy(model->lower, model->upper, 0, &model->number, group, mask, nullptr);
    FUZZ_CHECK(model->proxy != nullptr && model->proxy->m_clientObject == &model->number);
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
void Filter(World* w, Model* model)
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
            if (w->models[i].proxy != nullptr && w->models[k].proxy != nullptr && Collide(w->models[i], w->models[k]))
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
        case 4:
            if (what > 245)
                DestroyAll(w);
            break;
        default:
            if (model->proxy == nullptr)
                Create(w, model);
            else if (what % 12 == 5)
                Destroy(w, model);
            else if (what % 12 == 6)
                Filter(w, model);
            else
                Move(w, model);
    }
}
} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    World w;
    w.bytes = {data, size};
    for (int i = 0; i < qc_maxOperations && w.bytes.size > 0; i++)
        RunOperation(&w);
    Search(&w);
    DestroyAll(&w);
    return 0;
}
