// Scenes like those of Bullet's SoftDemo and DeformableDemo, from Bullet's own helpers: small soft bodies, in which all
// that does not depend on their size counts.
#ifndef QC_DEMOS_BENCH_SOFT_DEMO_SCENES_H
#define QC_DEMOS_BENCH_SOFT_DEMO_SCENES_H

#include "quickcullide/bullet.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btDeformableLagrangianForce.h>
#include <BulletSoftBody/btSoftBody.h>

#include <memory>
#include <vector>

enum class qcDemoContact
{
    bullets,         ///< Bullet alone
    ours,            ///< all promises of this library
    oursLikeBullets, ///< contact between soft bodies only; of nodes with rigid bodies by Bullet, none within a body
};

class qcDemoScene
{
  public:
    /// `make` adds the bodies.
    qcDemoScene(qcDemoContact contact, bool isDeformable, void (*make)(qcDemoScene&));
    ~qcDemoScene();
    qcDemoScene(const qcDemoScene&) = delete;
    qcDemoScene& operator=(const qcDemoScene&) = delete;

    void Step();
    size_t NodeCount() const;
    size_t CountTangled() const;

    btSoftBodyWorldInfo& Info();
    /// The scene owns the body, and the forces that act on it, from now on.
    void Add(btSoftBody* body, std::vector<btDeformableLagrangianForce*> forces = {});
    /// Returns the body, which the scene owns, as the shape. Mass 0: static.
    btRigidBody* AddRigid(btScalar mass, const btVector3& place, btCollisionShape* shape);
    /// Adds a multibody of boxes of 0.1 kg, each hinged to the one above. The world is deformable.
    void AddChain(int boxes, const btVector3& place, const btVector3& half);

  private:
    struct World;

    qcDemoContact m_contact;
    std::unique_ptr<World> m_world;
};

struct qcDemoSceneDef
{
    const char* name;
    bool isDeformable;
    void (*make)(qcDemoScene&);
};

/// All scenes.
const std::vector<qcDemoSceneDef>& qcDemoScenes();

#endif
