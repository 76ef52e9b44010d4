// Refuses bad pictures by name.
#include "gl/picture/check_picture.h"

#include "base/status.h"

#include <limits.h>
#include <math.h>

enum
{
    qc_maxPictureSide = 8192
};

static bool AreFinite(const float* values, size_t count)
{
    for (size_t i = 0; i < count; ++i)
    {
        if (!isfinite(values[i]))
            return false;
    }
    return true;
}

static bool IsColor(const float color[3])
{
    for (int i = 0; i < 3; ++i)
    {
        if (!(color[i] >= 0.0f && color[i] <= 1.0f))
            return false;
    }
    return true;
}

static qcStatus CheckMesh(const qcPictureMesh* mesh, uint32_t m)
{
    if ((mesh->positions == NULL && mesh->vertexCount > 0) || (mesh->indices == NULL && mesh->triangleCount > 0))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: %s of mesh %u is null",
                      mesh->positions == NULL && mesh->vertexCount > 0 ? "positions" : "indices", m);
    if (mesh->triangleCount > INT_MAX / 3)
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: mesh %u has %u triangles, more than %d", m,
                      mesh->triangleCount, INT_MAX / 3);
    for (size_t i = 0; i < mesh->vertexCount; ++i)
    {
        if (!AreFinite(mesh->positions + 3 * i, 3))
            return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: vertex %zu of mesh %u is not finite", i, m);
    }
    for (size_t i = 0; i < (size_t)3 * mesh->triangleCount; ++i)
    {
        if (mesh->indices[i] >= mesh->vertexCount)
            return qcFail(qc_statusBadInput,
                          "qcDevice_DrawPicture: index %zu of mesh %u is %u, but the mesh has %u vertices", i, m,
                          mesh->indices[i], mesh->vertexCount);
    }
    if (!IsColor(mesh->color) || !IsColor(mesh->backColor) || !IsColor(mesh->markColor))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: a colour of mesh %u is not in 0..1", m);
    return qc_statusOk;
}

static qcStatus CheckGround(const qcPictureDef* def)
{
    if (!def->hasGround)
        return qc_statusOk;
    if (!AreFinite(&def->groundHeight, 1))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: the ground's height is not finite");
    if (!(def->groundTile >= 0.0f) || !AreFinite(&def->groundTile, 1))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: the ground's tiles are not 0 or wider");
    if (!(def->groundExtent >= 0.0f) || !AreFinite(&def->groundExtent, 1))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: the ground's extent is not 0 or larger");
    if (!IsColor(def->groundColor))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: the ground's colour is not in 0..1");
    return qc_statusOk;
}

qcStatus qcPicture_Check(const qcPictureDef* def)
{
    if (def->width == 0 || def->width > qc_maxPictureSide || def->height == 0 || def->height > qc_maxPictureSide)
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: %u x %u pixels are not in 1..%d", def->width,
                      def->height, qc_maxPictureSide);
    if (!AreFinite(def->eye, 3) || !AreFinite(def->target, 3) || !AreFinite(def->up, 3))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: eye, target or up is not finite");
    if (!(def->fieldOfView > 0.0f && def->fieldOfView < 180.0f))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: a field of view of %g degrees is not between 0 and 180",
                      (double)def->fieldOfView);
    if (!IsColor(def->background))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: the background is not in 0..1");
    if (!AreFinite(def->light, 3))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: the light is not finite");
    QC_TRY(CheckGround(def));
    if (def->meshes == NULL && def->meshCount > 0)
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: meshes is null");
    for (uint32_t m = 0; m < def->meshCount; ++m)
        QC_TRY(CheckMesh(&def->meshes[m], m));
    return qc_statusOk;
}
