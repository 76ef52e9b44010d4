// What is known of a shape holds while an object that has it stays in its world.
#include "common/shape_owners.h"

#include "bullet/mesh/mesh_world.h"

namespace
{
struct Owners
{
    qcMeshWorld world;
    qcShapeOwners owners;
    btCollisionShape* shape = world.Keep(std::make_unique<btBoxShape>(btVector3(1, 1, 1)));
    uint64_t step = 1;

    btRigidBody* Add(btCollisionShape* root)
    {
        return world.Add(root, 0, btVector3(0, 0, 0));
    }

    /// The last one that was added.
    void RemoveLast()
    {
        world.world.removeRigidBody(world.bodies.back().get());
        world.bodies.pop_back();
    }

    bool IsKnown(const btRigidBody* body)
    {
        auto isLive = [this](const qcObjectKey& key)
        {
            return std::any_of(world.bodies.begin(), world.bodies.end(),
                               [&key](const auto& present) { return qcObjectKey(present.get()) == key; });
        };
        return owners.Add(body, shape, step, isLive);
    }
};

START_TEST(bodies_in_the_world_share_what_is_known)
{
    Owners made;
    btRigidBody* first = made.Add(made.shape);
    ck_assert(!made.IsKnown(first));
    ck_assert(made.IsKnown(first));
    ck_assert(made.IsKnown(made.Add(made.shape)));
    made.world.world.removeRigidBody(first);
    made.world.bodies.erase(made.world.bodies.begin());
    ck_assert(made.IsKnown(made.Add(made.shape)));
}
END_TEST

START_TEST(nothing_is_known_once_all_bodies_have_left)
{
    Owners made;
    ck_assert(!made.IsKnown(made.Add(made.shape)));
    made.RemoveLast();
    btRigidBody* later = made.Add(made.shape);
    ck_assert(!made.IsKnown(later));
    // It is another body of the same address and shape in the world from now on.
    made.world.world.removeRigidBody(later);
    made.world.world.addRigidBody(later);
    ck_assert(!made.IsKnown(later));
}
END_TEST

START_TEST(a_body_with_another_shape_knows_nothing)
{
    Owners made;
    btRigidBody* first = made.Add(made.shape);
    ck_assert(!made.IsKnown(first));
    btCompoundShape compound;
    first->setCollisionShape(&compound);
    btRigidBody* second = made.Add(made.shape);
    ck_assert(!made.IsKnown(second));
    // A child counts.
    compound.addChildShape(btTransform::getIdentity(), made.shape);
    ck_assert(made.IsKnown(first));
    made.RemoveLast();
    ck_assert(made.IsKnown(made.Add(made.shape)));
    first->setCollisionShape(made.shape);
}
END_TEST

START_TEST(bodies_that_were_not_added_lately_are_forgotten)
{
    Owners made;
    btRigidBody *first = made.Add(made.shape), *second = made.Add(made.shape);
    ck_assert(!made.IsKnown(first));
    made.step = 2;
    ck_assert(made.IsKnown(second));
    made.owners.ForgetBefore(2);
    made.world.world.removeRigidBody(second);
    made.world.world.addRigidBody(second);
    // The second is another one now, and the first is forgotten.
    ck_assert(!made.IsKnown(first));
}
END_TEST
} // namespace

QC_RUN_TESTS("shape_owners", bodies_in_the_world_share_what_is_known, nothing_is_known_once_all_bodies_have_left,
             a_body_with_another_shape_knows_nothing, bodies_that_were_not_added_lately_are_forgotten)
