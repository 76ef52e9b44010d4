// Where objects start their steps, in worlds where some rest while the application and contacts move others. Objects at
// rest are found by their place in the order of the broadphase, and not read further; this changes no start. A second
// record is given the objects in another order in each step, and so reads all of them.
#include "soft_body/scene/object_starts.h"

#include "common/object_motion.h"

#include "bullet/random_numbers.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <limits>
#include <memory>
#include <set>
#include <tuple>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
constexpr int s_worlds = 300;
constexpr int s_steps = 60;
constexpr btScalar s_timeStep = btScalar(1) / 60;
const btVector3 s_far(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);

/// Bodies, as a broadphase that names them in an order that can be turned.
class Bodies : public btBroadphaseInterface
{
  public:
    struct Body
    {
        btBroadphaseProxy proxy;
        btRigidBody body;
        btTransform home;
        btVector3 stride;

        Body(int id, const btRigidBody::btRigidBodyConstructionInfo& info, int flags, const btVector3& given)
            : body(info), home(info.m_startWorldTransform), stride(given)
        {
            proxy.m_uniqueId = id;
            proxy.m_clientObject = &body;
            body.setCollisionFlags(body.getCollisionFlags() | flags);
            body.setBroadphaseHandle(&proxy);
        }
    };

    std::vector<std::unique_ptr<Body>> all;
    size_t first = 0; ///< the one that is named first

    void aabbTest(const btVector3&, const btVector3&, btBroadphaseAabbCallback& callback) override
    {
        for (size_t i = 0; i < all.size(); i++)
            callback.process(&all[(first + i) % all.size()]->proxy);
    }

    // The rest of the interface, which nothing here calls.
    btBroadphaseProxy* createProxy(const btVector3&, const btVector3&, int, void*, int, int, btDispatcher*) override
    {
        return nullptr;
    }
    void destroyProxy(btBroadphaseProxy*, btDispatcher*) override
    {
    }
    void setAabb(btBroadphaseProxy*, const btVector3&, const btVector3&, btDispatcher*) override
    {
    }
    void getAabb(btBroadphaseProxy*, btVector3&, btVector3&) const override
    {
    }
    void rayTest(const btVector3&, const btVector3&, btBroadphaseRayCallback&, const btVector3&,
                 const btVector3&) override
    {
    }
    void calculateOverlappingPairs(btDispatcher*) override
    {
    }
    btOverlappingPairCache* getOverlappingPairCache() override
    {
        return nullptr;
    }
    const btOverlappingPairCache* getOverlappingPairCache() const override
    {
        return nullptr;
    }
    void getBroadphaseAabb(btVector3&, btVector3&) const override
    {
    }
    void printStats() override
    {
    }
};

using Boxes = std::multiset<std::tuple<btScalar, btScalar, btScalar, btScalar, btScalar, btScalar>>;

struct World
{
    qcRandomNumbers random;
    btBoxShape shape{btVector3(1, 1, 1)};
    Bodies bodies;
    qcBroadphases broadphases{&bodies};
    qcObjectStarts kept, turned;
    int ids = 0;

    explicit World(unsigned start) : random(start)
    {
        for (int i = 0; i < 8; i++)
            Add();
    }

    bool Chance(double part)
    {
        return random.Number(0, 1) < btScalar(part);
    }

    void Add()
    {
        const bool isDynamic = Chance(0.5);
        btRigidBody::btRigidBodyConstructionInfo info(isDynamic ? 1 : 0, nullptr, &shape, btVector3(1, 1, 1));
        info.m_startWorldTransform = btTransform(btQuaternion::getIdentity(), random.Vector(100));
        const int flags = !isDynamic && Chance(0.5) ? btCollisionObject::CF_KINEMATIC_OBJECT : 0;
        bodies.all.push_back(std::make_unique<Bodies::Body>(ids++, info, flags, random.Vector(10)));
    }

    /// Calls function(record) for both records, the second with the objects in another order.
    template <typename Function> void WithEach(Function function)
    {
        bodies.first = 0;
        function(&kept);
        bodies.first = 1 + size_t(ids + m_turns++) % (bodies.all.size() - 1);
        function(&turned);
        bodies.first = 0;
    }

    void Move(btRigidBody* body, double size)
    {
        btTransform& transform = body->getWorldTransform();
        const bool turns = Chance(0.5);
        if (!turns || Chance(0.5))
            transform.setOrigin(transform.getOrigin() + random.Vector(size));
        if (turns)
            transform.setBasis(transform.getBasis() * btMatrix3x3(btQuaternion(btVector3(0, 1, 0), btScalar(size))));
    }

    /// A flag by which an application holds a dynamic body.
    int RandomHold()
    {
        return Chance(0.5) ? btCollisionObject::CF_KINEMATIC_OBJECT : btCollisionObject::CF_STATIC_OBJECT;
    }

    /// What an application does between two steps.
    void Change()
    {
        if (Chance(0.1))
            Add();
        if (Chance(0.1) && bodies.all.size() > 4)
            bodies.all.erase(bodies.all.begin() + int(random.Number(0, double(bodies.all.size()) - 0.01)));
        if (Chance(0.05))
            std::swap(bodies.all[1], bodies.all.back());
        for (const std::unique_ptr<Bodies::Body>& each : bodies.all)
        {
            if (Chance(0.1))
                Move(&each->body, 0.2);
            if (Chance(0.03))
                Move(&each->body, 50);
            if (Chance(0.3))
                each->body.setWorldTransform(each->home);
            if (Chance(0.3))
                each->body.getWorldTransform().getOrigin() += each->stride;
            if (Chance(0.01))
                each->body.getWorldTransform().setOrigin(btVector3(0, std::numeric_limits<btScalar>::quiet_NaN(), 0));
            if (Chance(0.05))
                each->body.setLinearVelocity(random.Vector(3));
            if (Chance(0.2))
                each->body.setLinearVelocity(btVector3(0, 0, 0));
            if (Chance(0.05) && each->body.getInvMass() > 0)
                each->body.setCollisionFlags(each->body.getCollisionFlags() ^ RandomHold());
        }
    }

    /// Moves all by one translation, or none. Both records agree on it.
    void Shift()
    {
        qcTranslation shift;
        if (Chance(0.1))
        {
            const btVector3 by = random.Vector(500);
            for (const std::unique_ptr<Bodies::Body>& each : bodies.all)
            {
                btVector3& origin = each->body.getWorldTransform().getOrigin();
                if (qcIsFinite(each->body))
                    shift.Add(origin, origin + by);
                origin += by;
                each->home.getOrigin() += by;
            }
        }
        bool areShifted[2];
        int count = 0;
        WithEach([&](qcObjectStarts* starts) { areShifted[count++] = starts->AreShiftedBy(shift, broadphases); });
        ck_assert_int_eq(areShifted[0], areShifted[1]);
        WithEach([&](qcObjectStarts* starts)
                 { starts->SetShift(areShifted[0] && !shift.by.isZero() ? shift : qcTranslation()); });
    }

    void CheckPlaced()
    {
        Boxes placed[2];
        int count = 0;
        WithEach(
            [&](qcObjectStarts* starts)
            {
                auto add = [&](const btVector3& lower, const btVector3& upper) {
                    placed[count].insert({lower.x(), lower.y(), lower.z(), upper.x(), upper.y(), upper.z()});
                };
                starts->ForEachPlaced(broadphases, add);
                count++;
            });
        ck_assert(placed[0] == placed[1]);
    }

    /// Bullet's part of a step. Constraints put some back.
    void Integrate()
    {
        for (const std::unique_ptr<Bodies::Body>& each : bodies.all)
            if (!each->body.isStaticOrKinematicObject())
            {
                btTransform end;
                each->body.predictIntegratedTransform(s_timeStep, end);
                each->body.setWorldTransform(Chance(0.1) ? each->home : end);
            }
    }

    void CheckStarts()
    {
        std::multiset<const btCollisionObject*> moved[2], present[2];
        kept.ForEachMoved(-s_far, s_far, [&](const btCollisionObject* object) { moved[0].insert(object); });
        turned.ForEachMoved(-s_far, s_far, [&](const btCollisionObject* object) { moved[1].insert(object); });
        ck_assert(moved[0] == moved[1]);
        for (const qcObjectStarts::Present& each : kept.Objects())
            present[0].insert(each.object);
        for (const qcObjectStarts::Present& each : turned.Objects())
            present[1].insert(each.object);
        ck_assert(present[0] == present[1]);
        ck_assert_int_eq(kept.NotFinite() != nullptr, turned.NotFinite() != nullptr);
        for (const btCollisionObject* object : present[0])
        {
            ck_assert(qcAreSame(kept.StartOf(object), turned.StartOf(object)));
            ck_assert_int_eq(kept.StartsAtBegin(object), turned.StartsAtBegin(object));
            ck_assert(kept.Has(qcObjectKey(object)) && turned.Has(qcObjectKey(object)));
        }
    }

    void Step()
    {
        Change();
        CheckPlaced();
        Shift();
        WithEach([&](qcObjectStarts* starts) { starts->Begin(broadphases, [](const btCollisionObject*) {}); });
        if (Chance(0.2))
        {
            Move(&bodies.all[0]->body, 0.1);
            WithEach([&](qcObjectStarts* starts) { starts->ReadBegin(broadphases); });
        }
        Integrate();
        WithEach([&](qcObjectStarts* starts) { starts->Read(broadphases, s_timeStep, nullptr); });
        CheckStarts();
        for (const std::unique_ptr<Bodies::Body>& each : bodies.all)
            if (Chance(0.1) && qcIsFinite(each->body))
            {
                Move(&each->body, 0.1);
                WithEach([&](qcObjectStarts* starts) { starts->RecordEnd(&each->body); });
            }
    }

  private:
    int m_turns = 0;
};
} // namespace

START_TEST(objects_at_rest_start_where_they_are)
{
    for (int i = 0; i < s_worlds; i++)
    {
        World world{unsigned(i + 1)};
        for (int step = 0; step < s_steps; step++)
            world.Step();
    }
}
END_TEST

QC_RUN_TESTS("starts of objects", objects_at_rest_start_where_they_are)
