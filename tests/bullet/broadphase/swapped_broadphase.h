// Included first in a program that was not written for it: btDbvtBroadphase and btAxisSweep3 become qcBroadphase there.
// Bullet's headers, which define these names, come before the macros.
#ifndef QC_TESTS_BULLET_BROADPHASE_SWAPPED_BROADPHASE_H
#define QC_TESTS_BULLET_BROADPHASE_SWAPPED_BROADPHASE_H

#include "quickcullide/bullet_broadphase.h"

#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <btBulletDynamicsCommon.h>

#include <cstdio>

namespace qcSwapped
{
/// Prints its name at the end, as evidence.
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
    AxisSweep(const btVector3& /*worldMin*/, const btVector3& /*worldMax*/, unsigned short /*maxHandles*/ = 16384,
              btOverlappingPairCache* pairCache = nullptr, bool /*withoutAccelerator*/ = false)
        : Broadphase(pairCache)
    {
    }
};
} // namespace qcSwapped

#define btDbvtBroadphase qcSwapped::Broadphase
#define btAxisSweep3 qcSwapped::AxisSweep

#endif
