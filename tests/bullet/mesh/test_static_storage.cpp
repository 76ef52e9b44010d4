// Worlds in objects of static storage: they are destroyed after what the library has made in their life.
#include "quickcullide/bullet.h"

#include "bullet/mesh/soup_model.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <memory>

#include <sys/wait.h>
#include <unistd.h>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
/// A world with every part of the library, in the order in which Bullet requires them.
struct Parts
{
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    qcBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    qcSoftBodySolver softSolver;
    btSoftRigidDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration, &softSolver};
    qcMeshContact contact;
    std::unique_ptr<qcMeshShape> shape = qcModel(qcSphereModel(0.5, 2)).MakeShape();
    btRigidBody body{1, nullptr, shape.get(), btVector3(1, 1, 1)};
    std::unique_ptr<btSoftBody> cloth;

    Parts()
        : cloth(btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-1, 1, -1), btVector3(1, 1, -1),
                                               btVector3(-1, 1, 1), btVector3(1, 1, 1), 8, 8, 0, true))
    {
        contact.addTo(&world);
        world.addRigidBody(&body);
        world.addSoftBody(cloth.get());
    }
    ~Parts()
    {
        world.removeSoftBody(cloth.get());
        world.removeRigidBody(&body);
    }
};

// Destroyed after all that is made in functions.
std::unique_ptr<Parts> s_parts;
std::unique_ptr<qcMeshContact> s_contact;
} // namespace

START_TEST(a_world_of_static_storage_ends_well)
{
    for (bool keepsAll : {true, false})
    {
        fflush(nullptr);
        const pid_t child = fork();
        ck_assert_int_ge(child, 0);
        if (child == 0)
        {
            if (keepsAll)
            {
                s_parts.reset(new Parts);
                for (int step = 0; step < 3; step++)
                    s_parts->world.stepSimulation(btScalar(1.0 / 60), 0);
            }
            else
            {
                // Its world is gone before it.
                btDefaultCollisionConfiguration configuration;
                btCollisionDispatcher dispatcher(&configuration);
                qcBroadphase broadphase;
                btSequentialImpulseConstraintSolver solver;
                btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
                s_contact.reset(new qcMeshContact);
                s_contact->addTo(&world);
                world.stepSimulation(btScalar(1.0 / 60), 0);
            }
            exit(0);
        }
        int status = 0;
        ck_assert_int_eq(waitpid(child, &status, 0), child);
        ck_assert_msg(WIFEXITED(status) && WEXITSTATUS(status) == 0, "wait status %d", status);
    }
}
END_TEST

QC_RUN_TESTS("static storage", a_world_of_static_storage_ends_well)
