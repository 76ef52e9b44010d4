// contactTest and contactPairTest on compounds that hold meshes: they see where the objects are, and change no step.
#include "bullet/mesh/mesh_world.h"

#include <BulletCollision/CollisionDispatch/btCompoundCompoundCollisionAlgorithm.h>

namespace
{
/// The number of points, and the least distance.
struct Points : btCollisionWorld::ContactResultCallback
{
    int count = 0;
    btScalar least = 1;

    btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* /*body0*/, int /*part0*/,
                             int /*index0*/, const btCollisionObjectWrapper* /*body1*/, int /*part1*/,
                             int /*index1*/) override
    {
        count++;
        least = std::min(least, point.getDistance());
        return 0;
    }
};

btCollisionShape* MakeCube(qcMeshWorld* made, btScalar half)
{
    return made->Keep(qcBoxModel(btVector3(half, half, half), 2).MakeShape());
}

btCollisionShape* InCompound(qcMeshWorld* made, btCollisionShape* child)
{
    std::unique_ptr<btCompoundShape> compound(new btCompoundShape());
    compound->addChildShape(btTransform::getIdentity(), child);
    return made->Keep(std::move(compound));
}

enum LoadKind
{
    load_mesh,
    load_box,
    load_compound,
    load_kinds
};

btCollisionShape* MakeLoad(qcMeshWorld* made, int kind)
{
    btCollisionShape* shape = MakeCube(made, btScalar(0.5));
    if (kind == load_box)
        return made->Keep(std::unique_ptr<btCollisionShape>(new btBoxShape(btVector3(1, 1, 1) / 2)));
    return kind == load_compound ? InCompound(made, shape) : shape;
}

START_TEST(a_moving_platform_is_where_it_is)
{
    for (bool isCompound : {false, true})
    {
        qcMeshWorld made;
        btCollisionShape* mesh = MakeCube(&made, 1);
        btRigidBody* platform = made.Add(isCompound ? InCompound(&made, mesh) : mesh, 0, btVector3(0, 0, 0));
        platform->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        platform->setActivationState(DISABLE_DEACTIVATION);
        btRigidBody* load = made.Add(MakeLoad(&made, _i), 1, btVector3(0, btScalar(1.55), 0));
        load->setGravity(btVector3(0, 0, 0));
        const btScalar gaps[] = {btScalar(0.08), btScalar(-0.02)};
        for (btScalar gap : gaps)
        {
            btDefaultMotionState motion(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(-0.03), 0)));
            platform->setMotionState(&motion);
            made.Step();
            // By the last step down it has gone away by 3 cm.
            btTransform place = load->getWorldTransform();
            place.setOrigin(platform->getWorldTransform().getOrigin() + btVector3(0, btScalar(1.5) + gap, 0));
            load->setWorldTransform(place);
            platform->setLinearVelocity(btVector3(0, btScalar(-1.8), 0));
            Points points;
            made.world.contactPairTest(platform, load, points);
            if (gap > 0)
                ck_assert_int_eq(points.count, 0);
            else
            {
                ck_assert_int_gt(points.count, 0);
                ck_assert_double_lt(double(points.least), 0.001);
                ck_assert_double_gt(double(points.least), -0.06);
            }
            platform->setMotionState(nullptr);
        }
    }
}
END_TEST

START_TEST(a_query_is_no_part_of_a_step)
{
    for (bool queries : {false, true})
    {
        qcMeshWorld made;
        made.world.setGravity(btVector3(0, 0, 0));
        made.Add(made.Keep(qcBoxModel(btVector3(btScalar(0.1), 5, 5), 2).MakeShape()), 0, btVector3(0, 0, 0));
        made.Add(MakeCube(&made, btScalar(0.3)), 0, btVector3(-2, -1, 0));
        btRigidBody* body =
            made.Add(InCompound(&made, MakeCube(&made, btScalar(0.3))), 1, btVector3(-2, btScalar(-0.385), 0));
        body->setActivationState(DISABLE_DEACTIVATION);
        body->setLinearVelocity(btVector3(0, 0, btScalar(0.3)));
        made.Step(5);
        const size_t batches = made.contact.getStatistics().batches;
        Points points;
        if (queries)
            made.world.contactTest(body, points);
        ck_assert_uint_eq(made.contact.getStatistics().batches, batches);
        // Put elsewhere, behind the wall.
        const btTransform place(btQuaternion::getIdentity(), btVector3(2, 2, 0));
        body->setWorldTransform(place);
        body->setInterpolationWorldTransform(place);
        made.Step();
        ck_assert_double_gt(double(body->getWorldTransform().getOrigin().x()), 1.9);
    }
}
END_TEST

START_TEST(a_compound_meets_itself)
{
    qcMeshWorld made;
    std::unique_ptr<btCompoundShape> compound(new btCompoundShape());
    compound->addChildShape(btTransform::getIdentity(), MakeCube(&made, 1));
    compound->addChildShape(btTransform(btQuaternion(btVector3(1, 0, 0), btScalar(0.3)), btVector3(0, 1, 0)),
                            made.Keep(std::unique_ptr<btCollisionShape>(new btBoxShape(btVector3(1, 1, 1) / 2))));
    btRigidBody* body = made.Add(made.Keep(std::move(compound)), 0, btVector3(0, 0, 0));
    body->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    body->setLinearVelocity(btVector3(0, -2, 0));
    Points points;
    made.world.contactPairTest(body, body, points);
    ck_assert_int_gt(points.count, 0);
}
END_TEST

int s_calls;

bool RefuseAll(const btCollisionShape* /*shape0*/, const btCollisionShape* /*shape1*/)
{
    s_calls++;
    return false;
}

START_TEST(the_filter_of_children_of_two_compounds_is_called)
{
    qcMeshWorld made;
    btRigidBody* platform = made.Add(InCompound(&made, MakeCube(&made, 1)), 0, btVector3(0, 0, 0));
    platform->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    made.Add(InCompound(&made, MakeCube(&made, btScalar(0.5))), 1, btVector3(0, btScalar(1.5), 0));
    gCompoundCompoundChildShapePairCallback = RefuseAll;
    made.Step(10);
    gCompoundCompoundChildShapePairCallback = nullptr;
    ck_assert_int_gt(s_calls, 0);
    int points = 0;
    for (int i = 0; i < made.dispatcher.getNumManifolds(); i++)
        points += made.dispatcher.getManifoldByIndexInternal(i)->getNumContacts();
    ck_assert_int_eq(points, 0);
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("compound_queries");
    tcase_add_loop_test(tests, a_moving_platform_is_where_it_is, 0, load_kinds);
    tcase_add_test(tests, a_query_is_no_part_of_a_step);
    tcase_add_test(tests, a_compound_meets_itself);
    tcase_add_test(tests, the_filter_of_children_of_two_compounds_is_called);
    return qcRunCase("compound_queries", tests);
}
