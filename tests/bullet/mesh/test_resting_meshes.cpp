// Static meshes that nothing is near are left out of a step, and nothing else differs: a world whose meshes are read in
// every step moves alike, whatever the application does to them.
#include "bullet/mesh/mesh_world.h"

#include <random>
#include <set>

namespace
{
constexpr int s_steps = 240, s_props = 60, s_thrown = 12;

/// Small static meshes, some of Bullet's, with dynamic ones thrown among them.
struct PropWorld : qcMeshWorld
{
    std::mt19937 random;
    std::vector<btCollisionShape*> kinds;
    btCollisionShape* farShape;
    std::vector<btRigidBody*> props, thrown;
    std::set<btRigidBody*> removed;

    explicit PropWorld(unsigned start) : random(start)
    {
        world.setForceUpdateAllAabbs(start % 2 == 0);
        kinds = {Keep(qcBoxModel(btVector3(1, btScalar(0.05), 1), 1).MakeShape()), Keep(qcCubeModel(1).MakeShape()),
                 Keep(qcSphereModel(0.6, 1).MakeShape()), StaticMesh(qcTorusModel(0.6, 0.2, 10, 6))};
        farShape = Keep(qcCubeModel(1).MakeShape());
        Add(farShape, 0, btVector3(1000, 0, 0));
        for (int i = 0; i < s_props; i++)
            props.push_back(Add(kinds[size_t(i) % kinds.size()], 0, RandomTransform(6)));
        for (int i = 0; i < s_thrown; i++)
        {
            thrown.push_back(Add(kinds[1 + size_t(i) % 2], 1, RandomTransform(6)));
            Throw(thrown.back());
        }
    }

    btScalar Random(double low, double high)
    {
        return btScalar(low + (high - low) * double(random()) / double(std::mt19937::max()));
    }

    btVector3 RandomVector(double size)
    {
        const btScalar x = Random(-size, size), y = Random(-size, size), z = Random(-size, size);
        return btVector3(x, y, z);
    }

    btTransform RandomTransform(double size)
    {
        const btVector3 axis = RandomVector(1) + btVector3(0, 0, 2), origin = RandomVector(size);
        return btTransform(btQuaternion(axis.normalized(), Random(-3, 3)), origin);
    }

    void Throw(btRigidBody* body)
    {
        body->setWorldTransform(RandomTransform(8));
        body->setInterpolationWorldTransform(body->getWorldTransform());
        body->setLinearVelocity(RandomVector(60));
        body->setAngularVelocity(RandomVector(20));
        body->activate(true);
    }

    /// Those that have left the props behind.
    void ThrowBack()
    {
        for (btRigidBody* body : thrown)
            if (body->getWorldTransform().getOrigin().length() > 9)
                Throw(body);
    }

    /// What an application may do to the meshes of its world.
    void Change()
    {
        btRigidBody* prop = props[random() % props.size()];
        const bool isRemoved = removed.count(prop) > 0;
        switch (random() % 12)
        {
            case 0: // a little, over what is there
                prop->setWorldTransform(btTransform(prop->getWorldTransform().getBasis(),
                                                    prop->getWorldTransform().getOrigin() + RandomVector(0.3)));
                break;
            case 1: prop->setWorldTransform(RandomTransform(6)); break;
            case 2:
                if (isRemoved)
                    world.addRigidBody(prop);
                else
                    world.removeRigidBody(prop);
                if (isRemoved)
                    removed.erase(prop);
                else
                    removed.insert(prop);
                break;
            case 3: prop->setCollisionShape(kinds[random() % kinds.size()]); break;
            case 4: prop->setCollisionFlags(prop->getCollisionFlags() ^ btCollisionObject::CF_KINEMATIC_OBJECT); break;
            case 5:
                prop->setCollisionFlags(prop->getCollisionFlags() ^ btCollisionObject::CF_NO_CONTACT_RESPONSE);
                break;
            case 6: kinds[random() % 3]->setLocalScaling(btVector3(1, 1, 1) * Random(0.8, 1.2)); break;
            default: Throw(thrown[random() % thrown.size()]);
        }
    }
};
/// Counts the queries for its triangles.
class QueriedMesh : public btBvhTriangleMeshShape
{
  public:
    explicit QueriedMesh(btStridingMeshInterface* mesh) : btBvhTriangleMeshShape(mesh, true)
    {
    }

    void processAllTriangles(btTriangleCallback* callback, const btVector3& lower,
                             const btVector3& upper) const override
    {
        queries++;
        btBvhTriangleMeshShape::processAllTriangles(callback, lower, upper);
    }

    mutable int queries = 0;
};
} // namespace

START_TEST(what_rests_changes_nothing_for_the_others)
{
    const unsigned start = unsigned(_i) + 1;
    PropWorld resting(start), read(start);
    int limited = 0;
    for (int step = 0; step < s_steps; step++)
    {
        if (step % 3 == 0)
        {
            resting.Change();
            read.Change();
        }
        for (PropWorld* world : {&resting, &read})
            world->ThrowBack();
        // All meshes take part in a step in which one is read anew.
        read.contact.updateShape(read.farShape);
        resting.Step();
        read.Step();
        for (int i = 0; i < s_thrown; i++)
        {
            const btTransform &a = resting.thrown[size_t(i)]->getWorldTransform(),
                              &b = read.thrown[size_t(i)]->getWorldTransform();
            ck_assert_msg(a.getOrigin() == b.getOrigin() && a.getBasis() == b.getBasis(), "step %d: body %d differs",
                          step, i);
        }
        const qcMeshContactStatistics &a = resting.contact.getStatistics(), &b = read.contact.getStatistics();
        ck_assert_int_eq(a.limited, b.limited);
        ck_assert_int_eq(a.unproven, b.unproven);
        limited += a.limited;
    }
    ck_assert_int_gt(limited, 50);
    for (PropWorld* world : {&resting, &read})
        for (btRigidBody* prop : world->removed)
            world->world.addRigidBody(prop);
}
END_TEST

START_TEST(large_meshes_are_not_read_while_nothing_is_near)
{
    qcMeshWorld world;
    auto* const ground = new QueriedMesh(world.Interface(qcFloorModel(100, 100)));
    btCollisionShape* const kept = world.Keep(std::unique_ptr<btCollisionShape>(ground));
    auto* const scaled = new btScaledBvhTriangleMeshShape(ground, btVector3(2, 1, 2));
    btRigidBody* const upper = world.Add(kept, 0, btVector3(0, -20, 0));
    world.Add(world.Keep(std::unique_ptr<btCollisionShape>(scaled)), 0, btVector3(0, -40, 0));
    btRigidBody* const cube = world.Add(world.Keep(qcCubeModel(1).MakeShape()), 1, btVector3(0, 0, 0));
    world.Step(10);
    ck_assert_int_eq(ground->queries, 0);
    // It is read when the cube comes down to it, and holds it.
    world.Step(230);
    ck_assert_int_gt(ground->queries, 0);
    ck_assert_double_eq_tol(double(cube->getWorldTransform().getOrigin().y()), -19.5, 0.05);
    world.world.removeRigidBody(upper);
    cube->activate();
    world.Step(240);
    ck_assert_double_eq_tol(double(cube->getWorldTransform().getOrigin().y()), -39.5, 0.05);
}
END_TEST

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("resting_meshes");
    tcase_add_test(tests, large_meshes_are_not_read_while_nothing_is_near);
    tcase_add_loop_test(tests, what_rests_changes_nothing_for_the_others, 0, 4);
    return qcRunCase("resting_meshes", tests);
}
