// A world of Bullet with this library's contact for the scenes of `qc-bench through`: the classic or the deformable
// world of soft bodies, and rigid meshes. It owns all that is added to it.
#ifndef QC_DEMOS_BENCH_THROUGH_WORLD_H
#define QC_DEMOS_BENCH_THROUGH_WORLD_H

#include "bench/through/shapes.h"
#include "quickcullide/bullet_deformable.h"

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <memory>
#include <random>
#include <vector>

/// Small random displacements, the same for a seed on every machine.
class qcJitter
{
  public:
    explicit qcJitter(unsigned randomSeed) : m_random(randomSeed + 1)
    {
    }
    /// In -1..1.
    btScalar Number();
    btVector3 Vector();
    /// About a random axis through `center`, by at most `angle`.
    btTransform Rotation(const btVector3& center, btScalar angle);

  private:
    std::minstd_rand m_random;
};

/// A soft body, or a rigid one and its triangles.
struct qcThroughBody
{
    btSoftBody* soft = nullptr;
    btRigidBody* rigid = nullptr;
    btScalar stiffness = 0; ///< N/m, of its springs in the deformable world
    /// Local to the body where it is rigid. A rope's links are triangles with two equal corners.
    qcTriangles triangles;
};

struct qcClothDef
{
    btVector3 center{0, 0, 0};
    btScalar halfX = 1, halfZ = 1;
    int nodesX = 30, nodesZ = 30;
    btScalar tilt = 0; ///< height of one corner above the others, metres
    btScalar mass = 1;
    btVector3 velocity{0, 0, 0};
};

enum qcThroughKind
{
    qc_throughClassic,
    qc_throughDeformable, ///< with explicit integration of springs that are soft enough for it
    /// Deformable, with stiff springs, integrated implicitly. Where they are compressed this is unstable in Bullet,
    /// which throws nodes about: a test of endurance.
    qc_throughImplicit,
    qc_throughRigid ///< rigid meshes without soft bodies
};

struct qcThroughWorldDef
{
    qcThroughKind kind = qc_throughClassic;
    btScalar gravity = 0;
    int hz = 60;            ///< steps a second
    bool continuous = true; ///< qcSoftBodySettings::continuous, for soft bodies
    unsigned threads = 0;   ///< of the library's queries; 0: one a core
};

class qcThroughWorld
{
  public:
    explicit qcThroughWorld(const qcThroughWorldDef& worldDef);
    ~qcThroughWorld();
    qcThroughWorld(const qcThroughWorld&) = delete;
    qcThroughWorld& operator=(const qcThroughWorld&) = delete;

    /// A horizontal cloth. It is rotated by at most `turn` and each node is moved by 1e-4 of an edge.
    btSoftBody* AddCloth(const qcClothDef& def, qcJitter* jitter, btScalar turn = btScalar(0.01));
    btSoftBody* AddRope(const btVector3& from, const btVector3& to, int nodes, qcJitter* jitter);
    /// A rigid body of a qcMeshShape; mass 0: static.
    btRigidBody* AddMesh(const qcTriangles& triangles, btScalar mass, const btTransform& place);
    /// A static body of one of Bullet's own shapes; `core`: triangles inside of it, to judge by.
    btRigidBody* AddShape(std::unique_ptr<btCollisionShape> shape, const qcTriangles& core, const btTransform& place);
    void Step();

    const std::vector<qcThroughBody>& Bodies() const
    {
        return m_bodies;
    }
    /// Kinetic energy, that of gravity, and that of springs (links of the classic world hold none). Joules.
    double Energy() const;
    /// Energy that is kinetic. Joules.
    double KineticEnergy() const;
    /// kg m/s.
    btVector3 Momentum() const;
    const qcSoftBodyStatistics& SoftStatistics() const;
    const qcMeshContactStatistics& MeshStatistics() const
    {
        return m_contact.getStatistics();
    }

  private:
    void AddSoft(btSoftBody* soft, const btVector3& velocity, btScalar thickness);
    double SpringEnergy() const;
    btRigidBody* AddRigid(const qcTriangles& triangles, btScalar mass, const btTransform& place);

    // In the order in which Bullet requires them to be made.
    btSoftBodyRigidBodyCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher{&m_configuration};
    qcBroadphase m_broadphase;
    btDeformableBodySolver m_deformableSolver;
    btDeformableMultiBodyConstraintSolver m_deformableConstraints;
    btSequentialImpulseConstraintSolver m_solver;
    qcSoftBodySolver m_softSolver;
    qcMeshContact m_contact;
    std::vector<std::unique_ptr<btCollisionShape>> m_shapes;
    std::vector<std::unique_ptr<btDeformableMassSpringForce>> m_springs; ///< a body's in the deformable world
    std::unique_ptr<btDeformableGravityForce> m_gravityForce;
    std::unique_ptr<btSoftRigidDynamicsWorld> m_classic; ///< or
    std::unique_ptr<qcDeformableWorld> m_deformable;
    btDiscreteDynamicsWorld* m_world;
    qcThroughWorldDef m_def;
    std::vector<qcThroughBody> m_bodies;
};

#endif
