// Where an object is in a step: its transforms from the start to the end that the limiter gives it.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_MOTION_H
#define QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_MOTION_H

#include <LinearMath/btTransform.h>

#include <cstdint>

struct qcSweptMotion
{
    //  In the order of time.
    btTransform last;          ///< where the previous step ended
    btTransform start, target; ///< before and after the step; the target is Bullet's, or where planes have pushed it
    btTransform carried;       ///< the start, moved by the common motion of its island
    btTransform end;           ///< after the step, as the limiter has it so far
    btTransform next;          ///< where the next step starts

    bool moves = false;        ///< the end is not the start
    btScalar travel = 0;       ///< upper bound of the points' motion from start to target
    btVector3 lower, upper;    ///< box around the meshes at start and end
    btVector3 motion{0, 0, 0}; ///< of the origin in the previous step, for objects that Bullet does not move

    //  What the limiter has made of the motion.
    uint32_t pushes = 0;    ///< number of times that planes have moved the end
    btScalar fraction = 1;  ///< of the motion from `carried` to the target that the body makes
    btScalar lost = 0;      ///< part of its own motion that the object has not made in this step
    bool isLimited = false; ///< it does not end this step where Bullet had moved it

    btTransform tested;     ///< the end at the last detection of this step
    btTransform certified;  ///< the end in the last round of certificates
    bool isUnmoved = false; ///< the end is the one certified in this step's last round

    /// The transform after this part of the motion; `carried` and target exactly for 0 and 1. For links about.
    btTransform At(btScalar part) const;
};

#endif
