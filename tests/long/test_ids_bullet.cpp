// Numbers of proxies and of objects with meshes are used up again and again: no two proxies share an id, no pair is
// missing, and nothing passes through anything.
#include "bullet/broadphase/broadphase_model.h"
#include "bullet/mesh/mesh_world.h"

#include "common/id_counter.h"

#include <set>

namespace
{
/// Counters made meanwhile have few numbers.
struct FewNumbers
{
    explicit FewNumbers(uint32_t max)
    {
        qcIdCounter::s_max = max;
    }
    ~FewNumbers()
    {
        qcIdCounter::s_max = UINT32_MAX;
    }
};

START_TEST(a_counter_that_starts_again_leaves_out_the_numbers_in_use)
{
    qcRandom random{1};
    qcIdCounter counter(20);
    std::vector<uint32_t> used;
    int restarts = 0;
    auto visit = [&](auto add)
    {
        restarts++;
        for (uint32_t number : used)
            add(number);
        add(0);
    };
    for (int i = 0; i < 10000; i++)
    {
        while (used.size() > 15 || (!used.empty() && qcRandom_Below(&random, 2) == 0))
            used.erase(used.begin() + qcRandom_Below(&random, uint32_t(used.size())));
        uint32_t number = counter.Take(visit);
        CHECK_QUICKLY(number > 0 && number <= 20 && std::count(used.begin(), used.end(), number) == 0);
        used.push_back(number);
    }
    ck_assert_int_gt(restarts, 300);
}
END_TEST

START_TEST(proxies_have_ids_of_their_own_after_all_ids_were_given)
{
    qcRandom random{2};
    FewNumbers few(40);
    qcBroadphaseModel model;
    size_t pairs = 0;
    for (int step = 0; step < 2000; step++)
    {
        for (int i = 0; i < 3; i++)
        {
            btVector3 at = qcRandomPoint(&random, 6), size = qcRandomPoint(&random, 2);
            if (model.proxies.size() > 20 && qcRandom_Below(&random, 2) == 0)
                model.Destroy(qcRandom_Below(&random, uint32_t(model.proxies.size())));
            else if (model.proxies.size() < 30)
                model.Create(at, at + size);
            else
                model.Move(qcRandom_Below(&random, 30), at, at + size);
        }
        std::set<int> ids;
        for (const qcModelProxy& p : model.proxies)
            ids.insert(p.proxy->m_uniqueId);
        ck_assert_uint_eq(ids.size(), model.proxies.size());
        CHECK_QUICKLY(ids.empty() || (*ids.begin() > 0 && *ids.rbegin() <= 40));
        pairs += model.Check();
    }
    ck_assert_uint_gt(pairs, 10000);
}
END_TEST

/// Creates proxies in a query, which are listed only when it has ended.
struct CreatingCallback : btBroadphaseAabbCallback
{
    qcBroadphaseModel* model = nullptr;
    int left = 6;

    bool process(const btBroadphaseProxy*) override
    {
        if (left-- > 0)
            model->Create(btVector3(0, 0, 0), btVector3(1, 1, 1));
        return true;
    }
};

START_TEST(ids_of_proxies_that_callbacks_create_are_their_own)
{
    FewNumbers few(10);
    qcBroadphaseModel model;
    for (int i = 0; i < 8; i++)
        model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1));
    while (model.proxies.size() > 3)
        model.Destroy(1);
    CreatingCallback callback;
    callback.model = &model;
    for (int query = 0; query < 3; query++)
        model.broadphase.aabbTest(btVector3(0, 0, 0), btVector3(1, 1, 1), callback);
    ck_assert_uint_eq(model.proxies.size(), 9);
    std::set<int> ids;
    for (const qcModelProxy& p : model.proxies)
        ids.insert(p.proxy->m_uniqueId);
    ck_assert_uint_eq(ids.size(), 9);
    ck_assert_uint_eq(model.Check(), 36);
}
END_TEST

/// Boxes that fall into a bin of triangles, in which another one leaves.
START_TEST(meshes_stay_apart_while_the_numbers_of_their_objects_start_again)
{
    FewNumbers few(12);
    qcRandom random{3};
    qcMeshWorld w;
    w.Add(w.StaticMesh(qcBinModel(2, 12)), 0, btVector3(0, 0, 0));
    const qcModel models[2] = {qcCubeModel(5), qcBoxModel(btVector3(btScalar(0.6), btScalar(0.3), btScalar(0.6)), 5)};
    btCollisionShape* shapes[2] = {w.Keep(models[0].MakeShape()), w.Keep(models[1].MakeShape())};
    size_t replaced = 0;
    for (int step = 0; step < 3000; step++)
    {
        if (step % 25 == 0)
        {
            size_t kind = qcRandom_Below(&random, 2);
            double x = qcRandom_Below(&random, 2) * 1.5 - 0.75, z = 0, top = 0;
            for (size_t i = 1; i < w.bodies.size(); i++)
            {
                btVector3 at = w.bodies[i]->getWorldTransform().getOrigin();
                if (std::fabs(double(at.x()) - x) < 1.7 && std::fabs(double(at.z()) - z) < 1.7)
                    top = std::max(top, double(at.y()) + 0.5);
            }
            btRigidBody* body = w.Add(shapes[kind], 1, btVector3(btScalar(x), btScalar(top + 0.7), btScalar(z)));
            body->setUserPointer(const_cast<qcModel*>(&models[kind]));
        }
        if (w.bodies.size() > 8)
        {
            size_t gone = 1 + qcRandom_Below(&random, uint32_t(w.bodies.size() - 1));
            w.world.removeRigidBody(w.bodies[gone].get());
            w.bodies.erase(w.bodies.begin() + std::ptrdiff_t(gone));
            replaced++;
        }
        w.Step();
        std::vector<qcPlacedModel> placed;
        for (size_t i = 1; i < w.bodies.size(); i++)
        {
            placed.push_back({static_cast<const qcModel*>(w.bodies[i]->getUserPointer()), w.bodies[i].get()});
            btVector3 at = w.bodies[i]->getWorldTransform().getOrigin();
            ck_assert_msg(at.y() > btScalar(0.25) && std::max(std::fabs(at.x()), std::fabs(at.z())) < 2,
                          "step %d: body %zu is at %g %g %g", step, i, double(at.x()), double(at.y()), double(at.z()));
        }
        if (step % 10 == 0)
            ck_assert_msg(qcCountPenetrating(placed) == 0, "step %d: bodies penetrate", step);
    }
    ck_assert_uint_gt(replaced, 50);
}
END_TEST
} // namespace

QC_RUN_TESTS("ids in Bullet", a_counter_that_starts_again_leaves_out_the_numbers_in_use,
             proxies_have_ids_of_their_own_after_all_ids_were_given, ids_of_proxies_that_callbacks_create_are_their_own,
             meshes_stay_apart_while_the_numbers_of_their_objects_start_again)
