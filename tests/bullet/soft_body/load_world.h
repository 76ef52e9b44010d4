// Elastic bodies of tetrahedra and what loads them, in the deformable world.
#ifndef QC_TESTS_BULLET_SOFT_BODY_LOAD_WORLD_H
#define QC_TESTS_BULLET_SOFT_BODY_LOAD_WORLD_H

#include "bullet/soft_body/deformable_test_world.h"
#include "bullet/soft_body/tetra_model.h"

#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableLinearElasticityForce.h>
#include <BulletSoftBody/btDeformableNeoHookeanForce.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <limits>

// After the standard headers: check defines a macro named fail.
#include "bullet/soft_body/soft_models.h"

constexpr int qcLoadCells = 3;
constexpr btScalar qcLoadCellSize = btScalar(1.0 / 3);
constexpr btScalar qcCubeMass = btScalar(0.5);

/// A body of tetrahedra with what Bullet's forces need.
inline btSoftBody* qcAsTetraBody(btSoftBody* body)
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
struct qcLoadWorld : qcDeformableTestWorld<qcDeformableWorld>
{
    btBoxShape floorShape{btVector3(5, 1, 5)}, boxShape{btVector3(btScalar(0.4), btScalar(0.2), btScalar(0.4))};
    btRigidBody floor{0, nullptr, &floorShape};
    btDeformableGravityForce gravity;
    bool isImplicit;
    btScalar step; ///< Bullet's explicit solver is not stable in longer ones
    std::vector<std::unique_ptr<btDeformableLinearElasticityForce>> forces;
    std::vector<std::unique_ptr<btRigidBody>> boxes;

    explicit qcLoadWorld(const btVector3& g, bool implicit = true)
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

    ~qcLoadWorld()
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
        btSoftBody* cube =
            qcAsTetraBody(qcMakeTetraCube(world->getWorldInfo(), btVector3(btScalar(-0.5), height, btScalar(-0.5)),
                                          qcLoadCells, qcLoadCellSize, false));
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

inline double qcVolumeOf(const btSoftBody::Tetra& tetra)
{
    btVector3 edge[3];
    for (int k = 0; k < 3; k++)
        edge[k] = tetra.m_n[k + 1]->m_x - tetra.m_n[0]->m_x;
    return double(edge[0].cross(edge[1]).dot(edge[2])) / 6;
}

/// The smallest volume of a tetrahedron, as a share of that at rest.
inline double qcSmallestVolume(const btSoftBody* body)
{
    double smallest = std::numeric_limits<double>::max();
    for (int i = 0; i < body->m_tetras.size(); i++)
        smallest = std::min(smallest, qcVolumeOf(body->m_tetras[i]) / double(body->m_tetras[i].m_element_measure));
    return smallest;
}

/// The volume of a body, as a share of that at rest.
inline double qcWholeVolume(const btSoftBody* body)
{
    double volume = 0, atRest = 0;
    for (int i = 0; i < body->m_tetras.size(); i++)
    {
        volume += qcVolumeOf(body->m_tetras[i]);
        atRest += double(body->m_tetras[i].m_element_measure);
    }
    return volume / atRest;
}

#endif
