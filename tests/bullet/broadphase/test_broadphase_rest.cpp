// Bodies come to rest on qcBroadphase in the places in which they do on btDbvtBroadphase: ten seconds of a stack of
// boxes, a row of dominoes and a pile of compounds.
#include "bullet/broadphase/broadphase_model.h"
#include "bullet/broadphase/world_kinds.h"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>

namespace
{
void FillStack(qcWorld& world)
{
    btCollisionShape* box = world.Make<btBoxShape>(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5)));
    for (int i = 0; i < 10; i++)
        world.AddBody(1, btVector3(btScalar(0.01) * btScalar(i % 3), btScalar(0.5) + btScalar(1.05) * btScalar(i), 0),
                      box);
}

void FillDominoes(qcWorld& world)
{
    btCollisionShape* domino = world.Make<btBoxShape>(btVector3(btScalar(0.1), btScalar(0.5), btScalar(0.25)));
    for (int i = 0; i < 12; i++)
        world.AddBody(1, btVector3(btScalar(0.45) * btScalar(i), btScalar(0.5), 0), domino);
    // The first one falls on the second.
    btRigidBody* first = btRigidBody::upcast(world.objects[1].get());
    first->setLinearVelocity(btVector3(2, 0, 0));
    first->setAngularVelocity(btVector3(0, 0, -4));
}

/// Crosses of two bars in layers, each turned and tilted, that fall onto each other. (A heap that tumbles apart comes
/// to rest differently on each of Bullet's own broadphases: they hold different non-overlapping pairs, and the order of
/// the manifolds of two compounds depends on all manifolds created before.)
void FillPile(qcWorld& world)
{
    btCollisionShape* bar = world.Make<btBoxShape>(btVector3(btScalar(0.6), btScalar(0.2), btScalar(0.2)));
    btCompoundShape* cross = world.Make<btCompoundShape>();
    for (int axis = 0; axis < 2; axis++)
        cross->addChildShape(btTransform(btQuaternion(btScalar(axis) * SIMD_HALF_PI, 0, 0), btVector3(0, 0, 0)), bar);
    for (int i = 0; i < 24; i++)
    {
        const btScalar layer = btScalar(i / 4);
        const btVector3 place(btScalar(1.5) * btScalar(i % 4 / 2), btScalar(0.8) + btScalar(0.8) * layer,
                              btScalar(1.5) * btScalar(i % 2));
        world.AddBody(1, btTransform(btQuaternion(btScalar(0.3) * layer, btScalar(0.2), 0), place), cross,
                      btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter);
    }
}

/// Simulates ten seconds on both broadphases. At least one body must move by `least`.
void Compare(void (*fill)(qcWorld& world), double least)
{
    qcWorld ours(qcWorldKind::discrete, new qcBroadphase), theirs(qcWorldKind::discrete, new btDbvtBroadphase);
    for (qcWorld* world : {&ours, &theirs})
    {
        world->AddBody(0, btVector3(0, -1, 0), world->Make<btBoxShape>(btVector3(30, 1, 30)));
        fill(*world);
    }
    std::vector<btVector3> start;
    for (const auto& object : ours.objects)
        start.push_back(object->getWorldTransform().getOrigin());
    for (int step = 0; step < 600; step++)
    {
        ours.Step();
        theirs.Step();
    }
    double moved = 0;
    for (size_t i = 0; i < ours.objects.size(); i++)
    {
        const btTransform &here = ours.objects[i]->getWorldTransform(), &there = theirs.objects[i]->getWorldTransform();
        ck_assert_double_lt(double(here.getOrigin().distance(there.getOrigin())), 0.001);
        ck_assert_double_lt(double(here.getRotation().angleShortestPath(there.getRotation())), 0.001);
        for (qcWorld* world : {&ours, &theirs})
            ck_assert_double_lt(double(btRigidBody::upcast(world->objects[i].get())->getLinearVelocity().length()),
                                0.001);
        moved = std::max(moved, double(here.getOrigin().distance(start[i])));
    }
    ck_assert_double_gt(moved, least);
}
} // namespace

START_TEST(a_stack_of_boxes_rests_where_it_does_on_btDbvtBroadphase)
{
    Compare(FillStack, 0.4);
}
END_TEST

START_TEST(a_row_of_dominoes_falls_as_it_does_on_btDbvtBroadphase)
{
    Compare(FillDominoes, 0.8);
}
END_TEST

START_TEST(a_pile_of_compounds_rests_where_it_does_on_btDbvtBroadphase)
{
    Compare(FillPile, 2);
}
END_TEST

QC_RUN_TESTS("rest on the broadphase", a_stack_of_boxes_rests_where_it_does_on_btDbvtBroadphase,
             a_row_of_dominoes_falls_as_it_does_on_btDbvtBroadphase,
             a_pile_of_compounds_rests_where_it_does_on_btDbvtBroadphase)
