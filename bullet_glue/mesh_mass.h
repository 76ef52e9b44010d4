// Mass properties of triangle meshes.
#ifndef QC_BULLET_GLUE_MESH_MASS_H
#define QC_BULLET_GLUE_MESH_MASS_H

#include "quickcullide/bullet_mesh.h"

/// The moments of a mass distribution of density 1 about the origin of the mesh's frame.
struct qcMoments
{
    bool closed;
    double area;
    double mass;      ///< the volume of a closed mesh, the area of a shell
    double first[3];  ///< integrals of x, y, z
    double second[6]; ///< of xx, yy, zz, xy, yz, zx
};

qcMoments qcMeasureMesh(const btVector3* vertices, uint32_t vertexCount, const uint32_t* indices,
                        uint32_t triangleCount);

/// The tensor of a body of mass 1 about a point, from its moments.
btMatrix3x3 qcInertiaAbout(const qcMoments& moments, const double point[3]);

qcMassProperties qcMassPropertiesOf(const qcMoments& moments);

#endif
