// Bodies with a closed surface, whose triangles have an outer side.
#ifndef QC_SCENE_CLOSED_SURFACE_H
#define QC_SCENE_CLOSED_SURFACE_H

#include "scene/bodies.h"

/// The outer side of a rigid body's triangles. 1: their normals (b - a) x (c - a) in world space point out of the body;
/// -1: into it, since its transform mirrors; 0: there is no outer side. There is one if the body's surface is closed
/// and encloses a volume that its normals point out of before the transform. A surface is closed if each edge has as
/// many triangles in one direction as in the other; vertices at one position are the same. Thread-safe. The first call
/// takes O(triangles), later ones O(1).
int qcBody_FindOuterSide(qcBody* body);

#endif
