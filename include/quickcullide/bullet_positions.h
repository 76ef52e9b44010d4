/// @file
/// Positions in this build of Bullet, for the functions of the core and for qcMeshShape.
#ifndef QUICKCULLIDE_BULLET_POSITIONS_H
#define QUICKCULLIDE_BULLET_POSITIONS_H

#include "scene.h"

#include <LinearMath/btScalar.h>

/// The type of btScalar: qc_positionF64 where Bullet is built with BT_USE_DOUBLE_PRECISION, otherwise qc_positionF32.
constexpr qcPositionType qcBulletPositions = sizeof(btScalar) == sizeof(double) ? qc_positionF64 : qc_positionF32;

#endif
