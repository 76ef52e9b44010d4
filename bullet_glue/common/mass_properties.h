// Mass properties of triangle meshes.
#ifndef QC_GLUE_COMMON_MASS_PROPERTIES_H
#define QC_GLUE_COMMON_MASS_PROPERTIES_H

#include "quickcullide/bullet_mesh.h"

#include <cmath>

/// Moments of a mass distribution of density 1 about a vertex of the mesh, in units of about the mesh's length: they
/// neither overflow nor cancel for any size and position of the mesh.
struct qcMoments
{
    bool closed;
    double unit;      ///< length of a unit in the mesh's frame: a power of two
    double origin[3]; ///< the vertex, in the mesh's frame
    double area;
    double mass;      ///< the volume of a closed mesh, the area of a shell
    double first[3];  ///< integrals of x, y, z
    double second[6]; ///< of xx, yy, zz, xy, yz, zx
};

/// O(n log n).
qcMoments qcMeasureMesh(const btVector3* vertices, uint32_t vertexCount, const uint32_t* indices,
                        uint32_t triangleCount);

/// Like qcMeasureMesh, for a mesh whose edges are closed. O(n).
qcMoments qcMeasureSolid(const btVector3* vertices, const uint32_t* indices, uint32_t triangleCount);

/// The diagonal of a body's inertia tensor about the origin of the mesh's frame. A moment is 0 if btScalar can't hold
/// it or its inverse.
btVector3 qcInertiaAboutOrigin(const qcMoments& moments, double mass);

/// A moment of inertia; 0 where btScalar can't hold it.
inline btScalar qcMomentOf(double moment)
{
    const btScalar rounded = btScalar(moment);
    return std::isnormal(rounded) ? rounded : btScalar(0);
}

/// Makes a symmetric matrix diagonal by rotations, up to rounding; the columns of `axes` receive their product.
void qcDiagonalize(double m[3][3], double axes[3][3]);

qcMassProperties qcMassPropertiesOf(const qcMoments& moments);

#endif
