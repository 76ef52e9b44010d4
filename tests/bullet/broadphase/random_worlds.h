// Seeded worlds of mixed shapes with random changes. Equal seeds make equal calls.
#ifndef QC_TESTS_BULLET_BROADPHASE_RANDOM_WORLDS_H
#define QC_TESTS_BULLET_BROADPHASE_RANDOM_WORLDS_H

#include "bullet/broadphase/hills.h"
#include "bullet/broadphase/world_kinds.h"
#include "support/soups.h"

class qcRandomWorld
{
  public:
    /// Boxes, spheres, capsules, hulls, compounds, planes, a static triangle mesh, a heightfield, ghosts, kinematic and
    /// static bodies, cloth where the kind has it. Takes ownership of the broadphase.
    qcRandomWorld(uint64_t seed, qcWorldKind kind, btBroadphaseInterface* broadphase);

    /// Adds, removes, pushes, moves, puts to sleep and wakes some objects, and changes filters.
    void Change();
    void Step();
    /// A ray and a sweep through the world, each on the world's broadphase and on a btDbvtBroadphase with the same
    /// boxes: all hits must be the same to the last bit, and the nearest ones to rounding. Returns the number of hits.
    size_t CompareQueries();
    /// Hash of all transforms and velocities.
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
    std::vector<float> m_heights;
    std::unique_ptr<qcHills> m_hills;
    int m_sceneryCount = 0; ///< this many objects, the first ones, are never removed
};

#endif
