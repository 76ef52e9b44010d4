// Seeded worlds of mixed shapes that live through random changes. The same seed makes the same calls.
#ifndef QC_TESTS_BULLET_BROADPHASE_RANDOM_WORLDS_H
#define QC_TESTS_BULLET_BROADPHASE_RANDOM_WORLDS_H

#include "support/soups.h"
#include "bullet/broadphase/world_kinds.h"

class qcRandomWorld
{
  public:
    /// Boxes, spheres, capsules, hulls, compounds, planes, a static triangle mesh, a heightfield, ghosts, kinematic and
    /// static bodies, cloth where the kind takes it. Takes the broadphase over.
    qcRandomWorld(uint64_t seed, qcWorldKind kind, btBroadphaseInterface* broadphase);

    /// Some objects are added, removed, pushed, put elsewhere, sent to sleep or woken; filters change.
    void Change();
    void Step();
    /// A ray and a sweep through the world, each on the world's broadphase and on a btDbvtBroadphase with the same
    /// boxes: all hits must be the same to the last bit, and the nearest ones to rounding. Returns the number of hits.
    size_t CompareQueries();
    /// Of all places and velocities.
    uint64_t Hash() const;

    qcWorld world;

  private:
    btScalar Uniform(double lower, double upper);
    btVector3 Point(double lower, double upper);
    btTransform Place();
    uint32_t Below(uint32_t bound);
    void MakeShapes();
    void MakeScenery();
    void MakeMesh();
    void AddSomething();
    void AddGhost();

    qcRandom m_random;
    std::vector<btCollisionShape*> m_movable; ///< shapes that a body may have
    std::vector<btScalar> m_vertices;
    std::vector<int> m_indices;
    std::vector<float> m_heights;
    std::unique_ptr<btStridingMeshInterface> m_mesh;
    int m_sceneryCount = 0; ///< the first so many objects stay
};

#endif
