// Soft bodies that penetrate at the start, by this library or by Bullet alone: a cube of tetrahedra whose
// nodes are scrambled, and three rings that run through each other.
#ifndef QC_DEMOS_BENCH_SOFT_TANGLE_SCENE_H
#define QC_DEMOS_BENCH_SOFT_TANGLE_SCENE_H

#include "bench/soft/soft_scene.h"
#include "quickcullide/bullet_deformable.h"

#include <BulletSoftBody/btDeformableLinearElasticityForce.h>

#include <algorithm>
#include <array>
#include <memory>
#include <random>
#include <vector>

/// Pairs of triangles that penetrate, in and among soft bodies, counted independently of the worlds' own contact.
inline size_t qcCountTangled(const std::vector<const btSoftBody*>& bodies)
{
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcScene* scene = nullptr;
    if (qcScene_Create(&sceneDef, &scene) != qc_statusOk)
        return SIZE_MAX;
    qcStatus status = qc_statusOk;
    for (const btSoftBody* body : bodies)
    {
        std::vector<uint32_t> indices;
        for (int i = 0; i < body->m_faces.size(); i++)
            for (const btSoftBody::Node* node : body->m_faces[i].m_n)
                indices.push_back(uint32_t(node - &body->m_nodes[0]));
        qcBodyDef def = qcDefaultBodyDef();
        def.positions = &body->m_nodes[0].m_x;
        def.positionType = qcBulletPositions;
        def.positionStride = sizeof(btSoftBody::Node);
        def.vertexCount = uint32_t(body->m_nodes.size());
        def.indices = indices.data();
        def.triangleCount = uint32_t(indices.size() / 3);
        qcBodyId id;
        status = std::max(status, qcScene_AddBody(scene, &def, &id));
    }
    qcDetectDef detect = qcDefaultDetectDef();
    const qcResult* result = nullptr;
    status = std::max(status, qcScene_Detect(scene, &detect, &result));
    size_t count = status == qc_statusOk ? result->pairCount : SIZE_MAX;
    qcScene_Destroy(scene);
    return count;
}

/// The mean of the nodes.
inline btScalar qcMeanHeight(const btSoftBody* body)
{
    btScalar sum = 0;
    for (int i = 0; i < body->m_nodes.size(); i++)
        sum += body->m_nodes[i].m_x.y();
    return sum / btScalar(body->m_nodes.size());
}

/// An elastic cube of two metres, without gravity, whose nodes lie at random places in it.
class qcScrambledScene
{
  public:
    /// `ours`: in a qcDeformableWorld; otherwise in Bullet's own. `cells` along an edge, of five tetrahedra each.
    /// `randomSeed`: of the places.
    explicit qcScrambledScene(bool ours, int cells = 5, unsigned randomSeed = 1)
    {
        solver.setDeformableSolver(&deformableSolver);
        if (ours)
            world.reset(
                quick = new qcDeformableWorld(&dispatcher, &broadphase, &solver, &configuration, &deformableSolver));
        else
            world.reset(new btDeformableMultiBodyDynamicsWorld(&dispatcher, &broadphase, &solver, &configuration,
                                                               &deformableSolver));
        world->setImplicit(true);
        world->setUseProjection(true);
        MakeCube(cells);
        world->addSoftBody(cube);
        world->addForce(cube, &elasticity);
        // After the rest shape was computed.
        std::minstd_rand random(randomSeed);
        std::uniform_real_distribution<double> place(-1, 1);
        for (int i = 0; i < cube->m_nodes.size(); i++)
            for (int axis = 0; axis < 3; axis++)
                cube->m_nodes[i].m_x[axis] = btScalar(place(random));
    }

    ~qcScrambledScene()
    {
        world->removeForce(cube, &elasticity);
        world->removeSoftBody(cube);
        delete cube;
    }
    qcScrambledScene(const qcScrambledScene&) = delete;
    qcScrambledScene& operator=(const qcScrambledScene&) = delete;

    void Step()
    {
        world->stepSimulation(btScalar(1.0 / 60), 0);
    }

    size_t CountTangled() const
    {
        return qcCountTangled({cube});
    }

    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    qcBroadphase broadphase;
    btDeformableBodySolver deformableSolver;
    btDeformableMultiBodyConstraintSolver solver;
    std::unique_ptr<btDeformableMultiBodyDynamicsWorld> world;
    qcDeformableWorld* quick = nullptr; ///< the world, if it is ours
    btDeformableLinearElasticityForce elasticity{100, 100, btScalar(0.01)};
    btSoftBody* cube = nullptr;

  private:
    void MakeCube(int cells)
    {
        int side = cells + 1;
        btAlignedObjectArray<btVector3> points;
        for (int i = 0; i < side * side * side; i++)
            points.push_back(btVector3(btScalar(i % side), btScalar(i / side % side), btScalar(i / side / side)) *
                                 (btScalar(2) / btScalar(cells)) -
                             btVector3(1, 1, 1));
        btAlignedObjectArray<btScalar> masses;
        masses.resize(points.size(), 1);
        cube = new btSoftBody(&world->getWorldInfo(), points.size(), &points[0], &masses[0]);
        // The corners of a cell by the bits of their numbers: x, y, z. Every other cell is the mirror image, so that
        // the diagonals of faces agree.
        const int even[5][4] = {{0, 1, 2, 4}, {3, 1, 7, 2}, {5, 1, 4, 7}, {6, 2, 7, 4}, {1, 2, 4, 7}};
        for (int cell = 0; cell < cells * cells * cells; cell++)
        {
            int x = cell % cells, y = cell / cells % cells, z = cell / cells / cells;
            for (const int(&tetrahedron)[4] : even)
            {
                int node[4];
                for (int c = 0; c < 4; c++)
                {
                    int corner = tetrahedron[c] ^ ((x + y + z) & 1);
                    node[c] = x + (corner & 1) + side * (y + (corner >> 1 & 1) + side * (z + (corner >> 2)));
                }
                btScalar volume = (points[node[1]] - points[node[0]])
                                      .cross(points[node[2]] - points[node[0]])
                                      .dot(points[node[3]] - points[node[0]]);
                if (volume < 0)
                    std::swap(node[2], node[3]);
                cube->appendTetra(node[0], node[1], node[2], node[3]);
                for (int a = 0; a < 4; a++)
                    for (int b = a + 1; b < 4; b++)
                        cube->appendLink(node[a], node[b], nullptr, true);
            }
        }
        cube->initializeDmInverse();
        cube->m_tetraScratches.resize(cube->m_tetras.size());
        cube->m_tetraScratchesTn.resize(cube->m_tetras.size());
        cube->setTotalMass(btScalar(0.5));
        cube->getCollisionShape()->setMargin(btScalar(0.1));
        cube->m_sleepingThreshold = 0;
        btSoftBodyHelpers::generateBoundaryFaces(cube);
        elasticity.setPoissonRatio(btScalar(0.3));
        elasticity.setYoungsModulus(50);
        elasticity.setDamping(btScalar(0.1), btScalar(0.01));
    }
};

/// Three rings in free fall, side by side, each a quarter turn from the next: they begin inside of each other.
class qcRingsScene : public qcSoftScene
{
  public:
    explicit qcRingsScene(bool ours) : qcSoftScene(ours)
    {
        for (int i = 0; i < 3; i++)
            AddRing(btVector3(btScalar(2.95) * btScalar(i), 0, 0), i & 1);
    }

    ~qcRingsScene()
    {
        for (btSoftBody* ring : rings)
        {
            world->removeSoftBody(ring);
            delete ring;
        }
    }

    size_t CountTangled() const
    {
        return qcCountTangled({rings.begin(), rings.end()});
    }

    /// Mean of the rings.
    btScalar Height() const
    {
        btScalar sum = 0;
        for (const btSoftBody* ring : rings)
            sum += qcMeanHeight(ring) / btScalar(rings.size());
        return sum;
    }

    std::vector<btSoftBody*> rings;

  private:
    void AddRing(const btVector3& center, bool turned)
    {
        qcTorus torus(1, btScalar(0.5), 32, 12);
        btSoftBody* ring = btSoftBodyHelpers::CreateFromTriMesh(world->getWorldInfo(), torus.points.data(),
                                                                torus.indices.data(), int(torus.indices.size() / 3));
        ring->generateBendingConstraints(2);
        ring->m_cfg.piterations = 2;
        ring->m_cfg.collisions |= btSoftBody::fCollision::VF_SS;
        ring->transform(btTransform(btQuaternion(btVector3(1, 0, 0), turned ? SIMD_HALF_PI : 0), center));
        ring->setTotalMass(50, true);
        world->addSoftBody(ring);
        rings.push_back(ring);
    }
};

#endif
