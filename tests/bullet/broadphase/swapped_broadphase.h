// Included before all else into a program that was not written for it: what it calls btDbvtBroadphase or btAxisSweep3
// is qcBroadphase. Bullet's own headers have to come first, since they define these names.
#ifndef QC_TESTS_BULLET_BROADPHASE_SWAPPED_BROADPHASE_H
#define QC_TESTS_BULLET_BROADPHASE_SWAPPED_BROADPHASE_H

#include "quickcullide/bullet_broadphase.h"

#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <btBulletDynamicsCommon.h>

#include <cstdio>

namespace qcSwapped
{
/// Says at the end that it was there.
struct Broadphase : qcBroadphase
{
    explicit Broadphase(btOverlappingPairCache* pairCache = nullptr) : qcBroadphase(pairCache)
    {
    }
    ~Broadphase() override
    {
        std::fprintf(stderr, "qcBroadphase\n");
    }
};

struct AxisSweep : Broadphase
{
    AxisSweep(const btVector3& /*worldMin*/, const btVector3& /*worldMax*/, unsigned short /*mostHandles*/ = 16384,
              btOverlappingPairCache* pairCache = nullptr, bool /*withoutAccelerator*/ = false)
        : Broadphase(pairCache)
    {
    }
};
} // namespace qcSwapped

#define btDbvtBroadphase qcSwapped::Broadphase
#define btAxisSweep3 qcSwapped::AxisSweep

#endif
