// The space of a picture: the eye at the origin, and half the picture's height at its target as the unit. Meshes of any
// size and place become numbers near 1, and so shaders have one set of constants.
#ifndef QC_GL_PICTURE_PICTURE_SPACE_H
#define QC_GL_PICTURE_PICTURE_SPACE_H

#include "quickcullide/device.h"

/// Matrices are stored column by column.
typedef struct qcPictureSpace
{
    double eye[3];         ///< in scene units
    double unit;           ///< in scene units
    float up[3];           ///< of the scene; unit length, as all directions here
    float forward[3];      ///< the line of sight
    float rayX[3];         ///< at depth 1, from the middle of the picture to its right border
    float rayY[3];         ///< at depth 1, from the middle of the picture to its lower border, which is at y = 1
    float clip[16];        ///< to the picture, upside down: GL's first row is the lowest
    float projection[2];   ///< clip z = projection[0] * depth + projection[1]
    float clipScale[2];    ///< clip x and y of a length of 1 at depth 1
    float light[3];        ///< towards the light
    float lightClip[16];   ///< to the shadow map, -1..1
    float lightMap[16];    ///< to the shadow map, 0..1
    float lightExtents[3]; ///< of the shadow map: across the light twice, and along it
    bool hasGround;
    float groundMiddle[3]; ///< below or above the target
    float groundExtent;
    float groundCorners[4][3];
    float tileCorner[3]; ///< a corner of a tile of the ground
    float tileWidth;     ///< 0: no tiles
} qcPictureSpace;

/// Fills all but the clip matrices. qc_statusBadInput: the definition has no line of sight.
qcStatus qcPictureSpace_Place(const qcPictureDef* def, qcPictureSpace* space);

/// Fills the clip matrices, to hold all vertices: `count` positions in this space, `stride` floats apart.
void qcPictureSpace_Fit(qcPictureSpace* space, const float* positions, size_t count, size_t stride);

#endif
