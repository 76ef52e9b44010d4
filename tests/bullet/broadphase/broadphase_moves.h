// Random boxes for a broadphase, and random moves of them.
#ifndef QC_TESTS_BULLET_BROADPHASE_BROADPHASE_MOVES_H
#define QC_TESTS_BULLET_BROADPHASE_BROADPHASE_MOVES_H

#include "bullet/broadphase/broadphase_model.h"

struct qcBoxKinds
{
    bool grid = false;    ///< many boxes touch or are flat
    bool strange = false; ///< planes, NaN, inverted boxes
};

inline void qcRandomBounds(qcRandom* random, const qcBoxKinds& kinds, btVector3* aabbMin, btVector3* aabbMax)
{
    *aabbMin = kinds.grid ? qcRandomGridPoint(random, 6) : qcRandomPoint(random, 7);
    *aabbMax = *aabbMin + (kinds.grid ? qcRandomGridPoint(random, 2) : qcRandomPoint(random, 2));
    if (!kinds.strange)
        return;
    const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();
    switch (qcRandom_Below(random, 25))
    {
        case 0:
            aabbMin->setValue(-BT_LARGE_FLOAT, -BT_LARGE_FLOAT, -BT_LARGE_FLOAT);
            aabbMax->setValue(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
            break;
        case 1: aabbMin->setValue(nan, nan, nan); break;
        case 2: aabbMax->setY(nan); break;
        case 3: std::swap(*aabbMin, *aabbMax); break;
        case 4: aabbMin->setZ(aabbMax->z() + 1); break;
        case 5: aabbMax->setX(SIMD_INFINITY); break;
        default: break;
    }
}

/// Makes one box of a model grow, shrink, turn inside out or step aside.
inline void qcMoveOne(qcBroadphaseModel& model, qcRandom* random, const qcBoxKinds& kinds, size_t i)
{
    btVector3 aabbMin = model.proxies[i].aabbMin, aabbMax = model.proxies[i].aabbMax;
    switch (qcRandom_Below(random, 8))
    {
        case 0: qcRandomBounds(random, kinds, &aabbMin, &aabbMax); break;
        case 1: break;                                              // the same again
        case 2: std::swap(aabbMin, aabbMax); break;                 // inverted, and back
        case 3: aabbMax = aabbMin + (aabbMax - aabbMin) / 2; break; // smaller, in place
        default:
        {
            btVector3 step = kinds.grid ? qcRandomGridPoint(random, 2) - btVector3(1, 1, 1)
                                        : (qcRandomPoint(random, 1) - btVector3(0.5, 0.5, 0.5)) * btScalar(0.3);
            aabbMin += step;
            aabbMax += step;
        }
    }
    if (!kinds.strange && aabbMin.x() > aabbMax.x())
        std::swap(aabbMin, aabbMax);
    model.Move(i, aabbMin, aabbMax);
}

#endif
