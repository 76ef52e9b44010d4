// Checks what a caller of qcDevice_DrawPicture gives.
#ifndef QC_GL_PICTURE_CHECK_PICTURE_H
#define QC_GL_PICTURE_CHECK_PICTURE_H

#include "quickcullide/device.h"

/// Checks all but the line of sight. qc_statusBadInput names what is wrong. O(vertices + triangles).
qcStatus qcPicture_Check(const qcPictureDef* def);

#endif
