// The box around vertices.
#ifndef QC_GLUE_COMMON_VERTEX_BOX_H
#define QC_GLUE_COMMON_VERTEX_BOX_H

#include <LinearMath/btVector3.h>

#include <cstddef>

/// The lower and upper corner of the box around `count` vertices, at least one.
inline void qcFindBox(const btVector3* vertices, size_t count, btVector3 box[2])
{
    box[0] = box[1] = vertices[0];
    for (size_t i = 1; i < count; i++)
    {
        box[0].setMin(vertices[i]);
        box[1].setMax(vertices[i]);
    }
}

#endif
