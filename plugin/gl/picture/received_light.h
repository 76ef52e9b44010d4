// The light that each pixel of a picture receives, from the sky and from the light: a texture at half the picture's
// resolution or less, made before the picture is drawn.
#ifndef QC_GL_PICTURE_RECEIVED_LIGHT_H
#define QC_GL_PICTURE_RECEIVED_LIGHT_H

#include "gl/picture/picture_meshes.h"

enum
{
    qc_lightTextureCount = 5,
    qc_lightFramebufferCount = 4
};

typedef struct qcReceivedLight
{
    GLsizei width, height;
    GLuint textures[qc_lightTextureCount];
    GLuint framebuffers[qc_lightFramebufferCount];
    GLuint result; ///< the texture: ambient light, key light, depth
} qcReceivedLight;

/// The meshes' vertex array must be bound; it is, afterwards, too.
qcStatus qcReceivedLight_Make(const struct qcGlFunctions* gl, const qcPictureDef* def, const qcPictureSpace* space,
                              const qcPictureMeshes* meshes, qcReceivedLight* light);
void qcReceivedLight_Delete(const struct qcGlFunctions* gl, qcReceivedLight* light);

#endif
