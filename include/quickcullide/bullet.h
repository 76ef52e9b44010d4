/// @file
/// The parts for Bullet, but for fracture and deformable bodies. Link quickcullide::bullet, or
/// quickcullide::bullet_double where Bullet is built with BT_USE_DOUBLE_PRECISION.
///
/// Functions of these headers throw std::bad_alloc where the C++ library finds no memory, unless they say that they
/// return qc_statusOutOfMemory.
#ifndef QUICKCULLIDE_BULLET_H
#define QUICKCULLIDE_BULLET_H

#include "bullet_broadphase.h"
#include "bullet_debug_draw.h"
#include "bullet_mesh.h"
#include "bullet_positions.h"
#include "bullet_queries.h"
#include "bullet_soft_body.h"
#include "bullet_solver.h"
#include "bullet_threads.h"

#endif
