// Positions as this build of Bullet has them, for the core.
#ifndef QC_GLUE_COMMON_SCALAR_TYPE_H
#define QC_GLUE_COMMON_SCALAR_TYPE_H

#include "quickcullide/scene.h"

#include <LinearMath/btScalar.h>

constexpr qcPositionType qcBulletPositions = sizeof(btScalar) == sizeof(double) ? qc_positionF64 : qc_positionF32;

#endif
