// Units of length for a fracture: in them the mesh is 1 to 2 long and less than 10 from the origin, whatever its size
// and position. voro++ compares squares of lengths with absolute tolerances, and cubes of lengths could overflow.
#ifndef QC_GLUE_FRACTURE_UNIT_SCALE_H
#define QC_GLUE_FRACTURE_UNIT_SCALE_H

#include "fracture/faceted_mesh.h"

#include "quickcullide/bullet_fracture.h"

struct qcFractureUnits
{
    double length = 1;              ///< of a unit, in the mesh's frame: a power of two, so that scaling is exact
    qcClipPoint origin = {0, 0, 0}; ///< in the mesh's frame, in units; 0 along an axis unless the mesh is far from it

    /// In units from the origin of the mesh's frame. Exact unless it overflows or underflows.
    qcClipPoint Scaled(const btVector3& position) const;
    /// In units from `origin`. Exact for vertices of the mesh.
    qcClipPoint Local(const btVector3& position) const;
    /// A local position in the mesh's frame, rounded to btScalar.
    btVector3 Global(const qcClipPoint& local) const;
    /// A volume in cubic units in the mesh's frame. Infinite or 0 where it leaves the range of double.
    double GlobalVolume(double volume) const;
};

/// Finds the units for the vertices that the indices refer to. Returns the reason why there are none, or an empty text.
std::string qcFractureUnits_Find(const qcFractureDef& def, qcFractureUnits* units);

/// A number with six digits, for messages.
std::string qcTextOf(double number);

#endif
