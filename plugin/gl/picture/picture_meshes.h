// The meshes of a picture in one vertex buffer and one index buffer.
#ifndef QC_GL_PICTURE_PICTURE_MESHES_H
#define QC_GL_PICTURE_PICTURE_MESHES_H

#include "base/memory.h"
#include "gl/gl_functions.h"
#include "gl/picture/picture_space.h"
#include "quickcullide/device.h"

/// Indices of a mesh: those of plain triangles, then those of marked ones.
typedef struct qcPictureRange
{
    size_t first;
    uint32_t plainCount, markedCount; ///< triangles
} qcPictureRange;

typedef struct qcPictureMeshes
{
    qcArray vertices; ///< position in the picture's space, and normal: six floats
    qcArray indices;
    qcArray ranges; ///< of each mesh of the definition, and of the ground, which is last
    GLuint vertexArray, vertexBuffer, indexBuffer;
} qcPictureMeshes;

/// Copies all meshes into the picture's space, and adds the ground. Then fits the space around them.
qcStatus qcPictureMeshes_Prepare(qcPictureMeshes* meshes, const qcPictureDef* def, qcPictureSpace* space);
void qcPictureMeshes_Free(qcPictureMeshes* meshes);

void qcPictureMeshes_Upload(const struct qcGlFunctions* gl, qcPictureMeshes* meshes);
void qcPictureMeshes_Delete(const struct qcGlFunctions* gl, qcPictureMeshes* meshes);

/// Draws plain triangles of a range, or marked ones.
void qcPictureMeshes_Draw(const struct qcGlFunctions* gl, const qcPictureRange* range, bool marked);

#endif
