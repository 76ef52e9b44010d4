// Bodies of tetrahedra that carry many times their own mass in the deformable world: they keep their shape and come to
// rest, what they carry as well, and momentum stays as it is.
#include "bullet/soft_body/deformable_test_world.h"
#include "bullet/soft_body/tetra_model.h"

#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableLinearElasticityForce.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <limits>

// After the standard headers: check defines a macro named fail.
#include "bullet/soft_body/soft_models.h"

namespace
{
constexpr int s_cells = 3;
constexpr btScalar s_cellSize = btScalar(1.0 / 3);
constexpr btScalar s_cubeMass = btScalar(0.5);

btSoftBody* AsCube(btSoftBody* body)
{
    body->initializeDmInverse();
    body->m_tetraScratches.resize(body->m_tetras.size());
    body->m_tetraScratchesTn.resize(body->m_tetras.size());
    btSoftBodyHelpers::generateBoundaryFaces(body);
    body->getCollisionShape()->setMargin(btScalar(0.02));
    body->m_cfg.collisions =
        btSoftBody::fCollision::SDF_RD | btSoftBody::fCollision::SDF_RDN | btSoftBody::fCollision::VF_DD;
    body->m_sleepingThreshold = 0;
    return body;
}

/// Elastic cubes of 1 m and boxes, over a floor at height 0.
struct LoadWorld : qcDeformableTestWorld<qcDeformableWorld>
{
    btBoxShape floorShape{btVector3(5, 1, 5)}, boxShape{btVector3(btScalar(0.4), btScalar(0.2), btScalar(0.4))};
    btRigidBody floor{0, nullptr, &floorShape};
    btDeformableGravityForce gravity;
    bool isImplicit;
    btScalar step; ///< Bullet's explicit solver is not stable in longer ones
    std::vector<std::unique_ptr<btDeformableLinearElasticityForce>> forces;
    std::vector<std::unique_ptr<btRigidBody>> boxes;

    explicit LoadWorld(const btVector3& g, bool implicit = true)
        : gravity(g), isImplicit(implicit), step(btScalar(implicit ? 1.0 / 120 : 1.0 / 240))
    {
        world->setGravity(g);
        world->getWorldInfo().m_gravity = g;
        world->getWorldInfo().m_sparsesdf.setDefaultVoxelsz(btScalar(0.25));
        world->setImplicit(implicit);
        world->setUseProjection(true);
        world->getSolverInfo().m_splitImpulse = true;
        floor.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, -1, 0)));
        floor.setFriction(1);
        world->addRigidBody(&floor);
    }

    ~LoadWorld()
    {
        // Before their forces.
        for (btSoftBody* cube : cloths)
        {
            world->removeSoftBody(cube);
            delete cube;
        }
        cloths.clear();
        for (const auto& box : boxes)
            world->removeRigidBody(box.get());
        world->removeRigidBody(&floor);
    }

    btSoftBody* AddCube(btScalar height, btScalar mass)
    {
        btSoftBody* cube = AsCube(qcMakeTetraCube(
            world->getWorldInfo(), btVector3(btScalar(-0.5), height, btScalar(-0.5)), s_cells, s_cellSize, false));
        cube->setTotalMass(mass);
        cloths.push_back(cube);
        world->addSoftBody(cube);
        forces.emplace_back(new btDeformableLinearElasticityForce(100, 100, btScalar(0.01)));
        forces.back()->setPoissonRatio(btScalar(0.3));
        // Bullet's explicit solver is not stable with stiffer ones.
        forces.back()->setYoungsModulus(isImplicit ? 10000 : 3000);
        forces.back()->setDamping(0, btScalar(0.01));
        world->addForce(cube, &gravity);
        world->addForce(cube, forces.back().get());
        return cube;
    }

    btRigidBody* AddBox(btScalar height, btScalar mass)
    {
        btVector3 inertia;
        boxShape.calculateLocalInertia(mass, inertia);
        boxes.emplace_back(new btRigidBody(mass, nullptr, &boxShape, inertia));
        btRigidBody* box = boxes.back().get();
        box->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, height, 0)));
        box->setActivationState(DISABLE_DEACTIVATION);
        world->addRigidBody(box);
        return box;
    }

    void Step(int steps)
    {
        for (int i = 0; i < steps; i++)
        {
            world->stepSimulation(step, 0);
            const qcSoftBodyStatistics& statistics = world->getStatistics();
            ck_assert_int_eq(statistics.status, qc_statusOk);
            ck_assert_int_eq(statistics.unproven, 0);
            ck_assert_int_eq(statistics.remaining, 0);
        }
    }
};

/// The smallest volume of a tetrahedron, as a share of that at rest.
double SmallestVolume(const btSoftBody* body)
{
    double smallest = std::numeric_limits<double>::max();
    for (int i = 0; i < body->m_tetras.size(); i++)
    {
        const btSoftBody::Tetra& tetra = body->m_tetras[i];
        btVector3 edge[3];
        for (int k = 0; k < 3; k++)
            edge[k] = tetra.m_n[k + 1]->m_x - tetra.m_n[0]->m_x;
        smallest =
            std::min(smallest, double(edge[0].cross(edge[1]).dot(edge[2])) / (6 * double(tetra.m_element_measure)));
    }
    return smallest;
}

START_TEST(a_cube_carries_many_times_its_mass)
{
    for (bool implicit : {true, false})
        for (btScalar times : {btScalar(1), btScalar(10), btScalar(implicit ? 40 : 15)})
        {
            LoadWorld world(btVector3(0, -10, 0), implicit);
            btSoftBody* cube = world.AddCube(btScalar(0.02), s_cubeMass);
            btRigidBody* box = world.AddBox(btScalar(1.25), times * s_cubeMass);
            world.Step(240);
            ck_assert_double_gt(SmallestVolume(cube), 0.7);
            // By load, Young's modulus and area the cube is some 3 % lower under the heaviest.
            ck_assert_double_gt(double(box->getWorldTransform().getOrigin().y()), 1.18);
            ck_assert_double_lt(double(box->getWorldTransform().getOrigin().y()), 1.25);
            ck_assert_double_lt(double(qcSpeedOf(cube)), times > 20 ? 0.3 : 0.1);
            ck_assert_double_lt(double(box->getLinearVelocity().length()), times > 20 ? 0.3 : 0.1);
        }
}
END_TEST

START_TEST(a_light_cube_carries_a_heavy_one)
{
    LoadWorld world(btVector3(0, -10, 0));
    btSoftBody *lower = world.AddCube(btScalar(0.02), s_cubeMass),
               *upper = world.AddCube(btScalar(1.05), 10 * s_cubeMass);
    world.Step(240);
    ck_assert_double_gt(SmallestVolume(lower), 0.7);
    ck_assert_double_gt(SmallestVolume(upper), 0.7);
    ck_assert_double_lt(double(qcSpeedOf(lower)), 0.1);
    ck_assert_double_lt(double(qcSpeedOf(upper)), 0.3);
}
END_TEST

START_TEST(momentum_is_kept_and_energy_does_not_grow)
{
    LoadWorld world(btVector3(0, 0, 0));
    btSoftBody* cube = world.AddCube(3, s_cubeMass);
    btRigidBody* box = world.AddBox(btScalar(4.3), 5);
    box->setLinearVelocity(btVector3(btScalar(0.2), -2, 0));
    const btVector3 begin = box->getLinearVelocity() * 5;
    bool hasTouched = false;
    for (int i = 0; i < 100; i++)
    {
        world.Step(1);
        hasTouched = hasTouched || world.world->getStatistics().contacts > 0;
        const btVector3 momentum = box->getLinearVelocity() * 5 + qcMomentumOf(cube);
        ck_assert_double_lt(double((momentum - begin).length()), 0.02 * double(begin.length()));
        ck_assert_double_lt(double(box->getLinearVelocity().length()), 2.02);
    }
    ck_assert(hasTouched);
    ck_assert_double_gt(double(-qcMomentumOf(cube).y()), 0.5);
    ck_assert_double_gt(SmallestVolume(cube), 0.3);
}
END_TEST

/// How far a box slides in a second on a cube with this friction, where gravity has a fifth of its strength sideways.
double SlideOnCube(btScalar friction)
{
    LoadWorld world(btVector3(2, -10, 0));
    btSoftBody* cube = world.AddCube(btScalar(0.02), s_cubeMass);
    qcSoftBodySettings settings = world.world->getSettings(cube);
    settings.friction = friction;
    ck_assert_int_eq(world.world->setSettings(cube, settings), qc_statusOk);
    // The cube stays on the floor.
    for (int i = 0; i < cube->m_nodes.size(); i++)
        if (cube->m_nodes[i].m_x.y() < btScalar(0.03))
            cube->setMass(i, 0);
    btRigidBody* box = world.AddBox(btScalar(1.23), 1);
    box->setFriction(friction);
    world.Step(240);
    return double(box->getWorldTransform().getOrigin().x());
}

START_TEST(friction_holds_a_load)
{
    ck_assert_double_lt(SlideOnCube(btScalar(0.6)), 0.1);
    // Without friction it has left the cube.
    ck_assert_double_gt(SlideOnCube(0), 0.5);
}
END_TEST

START_TEST(a_load_may_go)
{
    LoadWorld world(btVector3(0, -10, 0));
    btSoftBody *lower = world.AddCube(btScalar(0.02), s_cubeMass), *upper = world.AddCube(btScalar(1.05), s_cubeMass);
    btRigidBody* box = world.AddBox(btScalar(2.28), 5);
    world.Step(60);
    world.world->removeRigidBody(box);
    world.boxes.clear();
    world.Step(10);
    world.world->removeSoftBody(upper);
    world.cloths.pop_back();
    delete upper;
    world.Step(240);
    ck_assert_double_gt(SmallestVolume(lower), 0.95);
    ck_assert_double_lt(double(qcSpeedOf(lower)), 0.02);
}
END_TEST
} // namespace

QC_RUN_TESTS("loaded_bodies", a_cube_carries_many_times_its_mass, a_light_cube_carries_a_heavy_one,
             momentum_is_kept_and_energy_does_not_grow, friction_holds_a_load, a_load_may_go)
