// The bodies of the demo scenes, with the sizes and settings of Bullet's examples.
#include "bench/soft/demo_scenes.h"
#include "bench/soft/model.h"
#include "bench/soft/soft_scene.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>

#include <random>

namespace
{
void AddGround(qcDemoScene& scene)
{
    scene.AddRigid(0, btVector3(0, -12, 0), new btBoxShape(btVector3(100, btScalar(1.5), 100)))->setFriction(1);
}

/// A square with its middle at `place`, and `nodes` along an edge. `fixed`: as for btSoftBodyHelpers::CreatePatch.
btSoftBody* MakePatch(qcDemoScene& scene, const btVector3& place, btScalar half, int nodes, int fixed)
{
    return btSoftBodyHelpers::CreatePatch(scene.Info(), place + btVector3(-half, 0, -half),
                                          place + btVector3(half, 0, -half), place + btVector3(-half, 0, half),
                                          place + btVector3(half, 0, half), nodes, nodes, fixed, true);
}

btSoftBody* MakeSoftMesh(qcDemoScene& scene, const std::vector<btScalar>& points, const std::vector<int>& indices)
{
    btSoftBody* body =
        btSoftBodyHelpers::CreateFromTriMesh(scene.Info(), points.data(), indices.data(), int(indices.size() / 3));
    body->m_cfg.piterations = 2;
    return body;
}

btSoftBody* MakeTorus(qcDemoScene& scene)
{
    qcTorus torus(2, 1, 30, 10);
    return MakeSoftMesh(scene, torus.points, torus.indices);
}

btSoftBody* MakeBunny(qcDemoScene& scene)
{
    qcSoftModel model = qcMakeSoftModel(4);
    btSoftBody* body = MakeSoftMesh(scene, model.positions, {model.indices.begin(), model.indices.end()});
    body->m_cfg.kDF = btScalar(0.5);
    return body;
}

/// Links of a given stiffness between each node and its neighbours' neighbours.
void AddBending(btSoftBody* body, btScalar stiffness)
{
    btSoftBody::Material* material = body->appendMaterial();
    material->m_kLST = stiffness;
    body->generateBendingConstraints(2, material);
}

void MakeRopes(qcDemoScene& scene)
{
    AddGround(scene);
    for (int i = 0; i < 15; i++)
    {
        btSoftBody* rope = btSoftBodyHelpers::CreateRope(scene.Info(), btVector3(-10, 0, btScalar(i) / 4),
                                                         btVector3(10, 0, btScalar(i) / 4), 16, 1 + 2);
        rope->m_cfg.piterations = 4;
        rope->m_materials[0]->m_kLST = btScalar(0.1) + btScalar(i) / 14 * btScalar(0.9);
        rope->setTotalMass(20);
        scene.Add(rope);
    }
}

void MakeSticks(qcDemoScene& scene)
{
    AddGround(scene);
    for (int i = 0; i < 256; i++)
    {
        btVector3 foot(btScalar(i % 16) / 15 * 10 - 5, -10, btScalar(i / 16) / 15 * 10 - 5);
        btSoftBody* stick =
            btSoftBodyHelpers::CreateRope(scene.Info(), foot, foot + btVector3(btScalar(0.004), 4, 0), 4, 1);
        stick->m_cfg.kDP = btScalar(0.005);
        stick->m_cfg.kCHR = btScalar(0.1);
        for (int reach = 2; reach < 5; reach++)
            stick->generateBendingConstraints(reach);
        stick->setMass(1, 0);
        stick->setTotalMass(btScalar(0.01));
        scene.Add(stick);
    }
    scene.AddRigid(10, btVector3(0, 0, 0), new btSphereShape(3));
}

void MakePinnedCloth(qcDemoScene& scene)
{
    AddGround(scene);
    btSoftBody* cloth = MakePatch(scene, btVector3(0, 0, 0), 8, 31, 1 + 2 + 4 + 8);
    cloth->getCollisionShape()->setMargin(btScalar(0.5));
    AddBending(cloth, btScalar(0.4));
    cloth->setTotalMass(150);
    scene.Add(cloth);
    for (int i = 0; i < 8; i++)
    {
        btCollisionShape* shape = i % 2 == 0 ? static_cast<btCollisionShape*>(new btBoxShape(btVector3(1, 1, 1)))
                                             : new btSphereShape(btScalar(1.5));
        scene.AddRigid(10, btVector3(0, btScalar(2 + 4 * i), 0), shape);
    }
}

void MakeFlyers(qcDemoScene& scene)
{
    AddGround(scene);
    std::minstd_rand random(5);
    std::uniform_real_distribution<double> part(-1, 1);
    for (int i = 0; i < 50; i++)
    {
        btSoftBody* flyer = MakePatch(scene, btVector3(0, 10, 0), 2, 6, 0);
        AddBending(flyer, 1);
        flyer->m_cfg.kLF = btScalar(0.004);
        flyer->m_cfg.kDG = btScalar(0.0003);
        flyer->m_cfg.aeromodel = btSoftBody::eAeroModel::V_TwoSided;
        btScalar r[6];
        for (btScalar& number : r)
            number = btScalar(part(random));
        btQuaternion turn;
        turn.setEuler(SIMD_PI / 8 + r[0] / 10, -SIMD_PI / 7 + r[1] / 10, r[2] / 10);
        flyer->transform(btTransform(turn, btVector3(r[3], r[4], r[5]) * 15 + btVector3(0, 20, 80)));
        flyer->setTotalMass(btScalar(0.1));
        flyer->addForce(btVector3(0, 2, 0), 0);
        scene.Add(flyer);
    }
}

void MakeBall(qcDemoScene& scene)
{
    AddGround(scene);
    btSoftBody* ball = btSoftBodyHelpers::CreateEllipsoid(scene.Info(), btVector3(17, 12, 0), btVector3(3, 3, 3), 512);
    ball->m_materials[0]->m_kLST = btScalar(0.45);
    ball->m_cfg.kVC = 20;
    ball->setTotalMass(50, true);
    ball->setPose(true, false);
    scene.Add(ball);
    for (int i = 0; i < 10; i++)
        scene.AddRigid(0, btVector3(btScalar(4 * i), btScalar(2 * i) - 10, 0), new btBoxShape(btVector3(2, 1, 5)));
}

void MakeBoxes(qcDemoScene& scene)
{
    AddGround(scene);
    for (int i = 0; i < 20; i++)
    {
        btVector3 corners[8];
        for (int c = 0; c < 8; c++)
            corners[c] = btVector3(btScalar(c & 1) * 2 - 1, btScalar(c >> 1 & 1) * 2 - 1, btScalar(c >> 2) * 2 - 1) +
                         btVector3(btScalar(i) * btScalar(2.5), -9, 0);
        btSoftBody* box = btSoftBodyHelpers::CreateFromConvexHull(scene.Info(), corners, 8);
        box->generateBendingConstraints(2);
        box->m_cfg.kDF = btScalar(i + 1) / 200;
        box->addVelocity(btVector3(0, 0, -10));
        scene.Add(box);
    }
}

void MakeDrapedCloth(qcDemoScene& scene)
{
    AddGround(scene);
    scene.AddRigid(0, btVector3(0, 4, 0), new btCapsuleShapeX(1, 5))->setFriction(btScalar(0.8));
    btSoftBody* cloth = MakePatch(scene, btVector3(0, 6, 0), 4, 20, 0);
    cloth->setTotalMass(btScalar(0.1));
    cloth->m_cfg.piterations = cloth->m_cfg.citerations = cloth->m_cfg.diterations = 10;
    scene.Add(cloth);
}

void MakeMatchedTorus(qcDemoScene& scene)
{
    AddGround(scene);
    btSoftBody* torus = MakeTorus(scene);
    torus->m_materials[0]->m_kLST = btScalar(0.1);
    torus->m_cfg.kMT = btScalar(0.05);
    torus->translate(btVector3(0, -6, 0));
    torus->setTotalMass(50, true);
    torus->setPose(false, true);
    scene.Add(torus);
}

void MakeBentBunny(qcDemoScene& scene)
{
    AddGround(scene);
    btSoftBody* bunny = MakeBunny(scene);
    AddBending(bunny, btScalar(0.5));
    bunny->setTotalMass(100, true);
    scene.Add(bunny);
}

void MakeMatchedBunny(qcDemoScene& scene)
{
    AddGround(scene);
    btSoftBody* bunny = MakeBunny(scene);
    bunny->m_cfg.kMT = btScalar(0.05);
    bunny->m_cfg.piterations = 5;
    bunny->setTotalMass(100, true);
    bunny->setPose(false, true);
    scene.Add(bunny);
}

void MakeBunnyStack(qcDemoScene& scene)
{
    AddGround(scene);
    for (int i = 0; i < 3; i++)
    {
        btSoftBody* bunny = MakeBunny(scene);
        AddBending(bunny, btScalar(0.5));
        bunny->m_cfg.collisions |= btSoftBody::fCollision::VF_SS;
        bunny->translate(btVector3(0, btScalar(9 * i - 4), 0));
        bunny->setTotalMass(100, true);
        scene.Add(bunny);
    }
}

void MakeClusterStack(qcDemoScene& scene)
{
    AddGround(scene);
    for (int i = 0; i < 5; i++)
    {
        btSoftBody* torus = MakeTorus(scene);
        AddBending(torus, 1);
        torus->m_cfg.collisions = btSoftBody::fCollision::CL_SS + btSoftBody::fCollision::CL_RS;
        torus->m_cfg.kDF = 1;
        torus->rotate(btQuaternion(btVector3(1, 0, 0), SIMD_HALF_PI));
        torus->translate(btVector3(0, btScalar(3 * i - 9), 0));
        torus->setTotalMass(50, true);
        torus->generateClusters(64);
        scene.Add(torus);
    }
}

void AddDeformableCloth(qcDemoScene& scene, btSoftBody* cloth, btScalar margin, btScalar stiffness)
{
    cloth->getCollisionShape()->setMargin(margin);
    cloth->generateBendingConstraints(2);
    cloth->setTotalMass(1);
    cloth->m_cfg.kKHR = cloth->m_cfg.kCHR = 1;
    cloth->m_cfg.kDF = 2;
    cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RD | btSoftBody::fCollision::SDF_RDF |
                              btSoftBody::fCollision::SDF_RDN | btSoftBody::fCollision::VF_DD;
    scene.Add(cloth, {new btDeformableMassSpringForce(stiffness, stiffness / 20, true),
                      new btDeformableGravityForce(btVector3(0, -10, 0))});
    cloth->setSelfCollision(true);
}

void MakeDeformableCloth(qcDemoScene& scene)
{
    AddDeformableCloth(scene, MakePatch(scene, btVector3(0, 0, 0), 4, 20, 1 + 2 + 4 + 8), btScalar(0.05), 15);
    for (int i = 0; i < 5; i++)
        scene.AddRigid(btScalar(0.2), btVector3(btScalar(i % 2), btScalar(1 + i), 0),
                       new btBoxShape(btVector3(1, btScalar(0.25), btScalar(0.5))));
}

void MakeDeformableLayers(qcDemoScene& scene)
{
    scene.AddRigid(0, btVector3(0, btScalar(-2.6), 0), new btBoxShape(btVector3(50, btScalar(2.5), 50)));
    for (int i = 0; i < 2; i++)
        AddDeformableCloth(scene, MakePatch(scene, btVector3(0, btScalar(i) / 10, 0), btScalar(0.8), 21, 0),
                           btScalar(0.02), 4);
}

void MakeChain(qcDemoScene& scene)
{
    AddDeformableCloth(scene, MakePatch(scene, btVector3(0, 0, 0), 4, 20, 1 + 2 + 4 + 8), btScalar(0.025), 30);
    scene.AddChain(5, btVector3(0, 10, 0), btVector3(btScalar(0.4), 1, btScalar(0.4)));
}
} // namespace

const std::vector<qcDemoSceneDef>& qcDemoScenes()
{
    static const std::vector<qcDemoSceneDef> scenes = {
        {"15 ropes", false, MakeRopes},
        {"256 sticks, a ball", false, MakeSticks},
        {"pinned cloth, 8 bodies", false, MakePinnedCloth},
        {"50 flyers in the wind", false, MakeFlyers},
        {"ball on stairs", false, MakeBall},
        {"20 boxes that slide", false, MakeBoxes},
        {"cloth over a capsule", false, MakeDrapedCloth},
        {"torus, pose matching", false, MakeMatchedTorus},
        {"bunny", false, MakeBentBunny},
        {"bunny, pose matching", false, MakeMatchedBunny},
        {"3 bunnies", false, MakeBunnyStack},
        {"5 tori of clusters", false, MakeClusterStack},
        {"deformable cloth, 5 bodies", true, MakeDeformableCloth},
        {"2 deformable cloths", true, MakeDeformableLayers},
        {"deformable cloth, 5 links", true, MakeChain},
    };
    return scenes;
}
