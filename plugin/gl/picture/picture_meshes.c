// The meshes of a picture: positions near 1, normals, marked triangles last.
#include "gl/picture/picture_meshes.h"

#include "base/status.h"

#include <math.h>
#include <string.h>

enum
{
    qc_vertexFloats = 6
};

static float ToPicture(float position, double eye, double unit)
{
    double x = ((double)position - eye) / unit;
    // 1e9: far outside of the picture, and squares are finite.
    return (float)fmax(-1e9, fmin(x, 1e9));
}

/// Adds to each vertex the normals of its triangles, weighted by area.
static void AddNormals(const qcPictureMesh* mesh, float* vertices)
{
    for (size_t t = 0; t < mesh->triangleCount; ++t)
    {
        float* v[3];
        for (int c = 0; c < 3; ++c)
            v[c] = vertices + (size_t)qc_vertexFloats * mesh->indices[3 * t + (size_t)c];
        const float ab[3] = {v[1][0] - v[0][0], v[1][1] - v[0][1], v[1][2] - v[0][2]};
        const float ac[3] = {v[2][0] - v[0][0], v[2][1] - v[0][1], v[2][2] - v[0][2]};
        const float normal[3] = {ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2],
                                 ab[0] * ac[1] - ab[1] * ac[0]};
        for (int c = 0; c < 3; ++c)
        {
            for (int i = 0; i < 3; ++i)
                v[c][3 + i] += normal[i];
        }
    }
    // Unit length: vertices get equal weight in the interpolation.
    for (size_t i = 0; i < mesh->vertexCount; ++i)
    {
        float* n = vertices + qc_vertexFloats * i + 3;
        float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int axis = 0; axis < 3; ++axis)
            n[axis] = length > 0.0f && isfinite(length) ? n[axis] / length : 0.0f;
    }
}

static void CopyMesh(const qcPictureMesh* mesh, const qcPictureSpace* space, qcPictureMeshes* meshes)
{
    uint32_t firstVertex = (uint32_t)(meshes->vertices.count / qc_vertexFloats);
    float* vertices = (float*)meshes->vertices.data + meshes->vertices.count;
    meshes->vertices.count += (size_t)qc_vertexFloats * mesh->vertexCount;
    for (size_t i = 0; i < mesh->vertexCount; ++i)
    {
        for (size_t axis = 0; axis < 3; ++axis)
        {
            vertices[qc_vertexFloats * i + axis] =
                ToPicture(mesh->positions[3 * i + axis], space->eye[axis], space->unit);
            vertices[qc_vertexFloats * i + 3 + axis] = 0.0f;
        }
    }
    if (mesh->smooth || mesh->wireframe)
        AddNormals(mesh, vertices);

    qcPictureRange* range = (qcPictureRange*)meshes->ranges.data + meshes->ranges.count++;
    *range = (qcPictureRange){.first = meshes->indices.count};
    uint32_t* indices = (uint32_t*)meshes->indices.data + meshes->indices.count;
    meshes->indices.count += (size_t)3 * mesh->triangleCount;
    for (int marked = 0; marked < 2; ++marked)
    {
        for (size_t t = 0; t < mesh->triangleCount; ++t)
        {
            bool isMarked = mesh->marked != NULL && mesh->marked[t] != 0;
            if (isMarked != (marked == 1))
                continue;
            for (size_t c = 0; c < 3; ++c)
                *indices++ = firstVertex + mesh->indices[3 * t + c];
            *(marked == 1 ? &range->markedCount : &range->plainCount) += 1;
        }
    }
}

/// Two triangles; none if the picture has no ground.
static void AddGround(const qcPictureSpace* space, qcPictureMeshes* meshes)
{
    static const uint32_t corners[6] = {0, 2, 1, 0, 3, 2};
    uint32_t firstVertex = (uint32_t)(meshes->vertices.count / qc_vertexFloats);
    qcPictureRange* range = (qcPictureRange*)meshes->ranges.data + meshes->ranges.count++;
    *range = (qcPictureRange){.first = meshes->indices.count, .plainCount = space->hasGround ? 2 : 0};
    for (int i = 0; i < 4 && space->hasGround; ++i)
    {
        float* vertex = (float*)meshes->vertices.data + meshes->vertices.count;
        memcpy(vertex, space->groundCorners[i], 3 * sizeof(float));
        memcpy(vertex + 3, space->up, 3 * sizeof(float));
        meshes->vertices.count += qc_vertexFloats;
    }
    for (int i = 0; i < 6 && space->hasGround; ++i)
        ((uint32_t*)meshes->indices.data)[meshes->indices.count++] = firstVertex + corners[i];
}

qcStatus qcPictureMeshes_Prepare(qcPictureMeshes* meshes, const qcPictureDef* def, qcPictureSpace* space)
{
    size_t vertexCount = 4, triangleCount = 2; // of the ground
    for (uint32_t m = 0; m < def->meshCount; ++m)
    {
        vertexCount += def->meshes[m].vertexCount;
        triangleCount += def->meshes[m].triangleCount;
    }
    if (vertexCount > UINT32_MAX)
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: the meshes have more than %u vertices", UINT32_MAX - 4);
    QC_TRY(qcArray_Reserve(&meshes->vertices, vertexCount * qc_vertexFloats, sizeof(float), "a picture's vertices"));
    QC_TRY(qcArray_Reserve(&meshes->indices, triangleCount * 3, sizeof(uint32_t), "a picture's indices"));
    QC_TRY(qcArray_Reserve(&meshes->ranges, (size_t)def->meshCount + 1, sizeof(qcPictureRange), "a picture's meshes"));
    for (uint32_t m = 0; m < def->meshCount; ++m)
        CopyMesh(&def->meshes[m], space, meshes);
    qcPictureSpace_Fit(space, meshes->vertices.data, meshes->vertices.count / qc_vertexFloats, qc_vertexFloats);
    AddGround(space, meshes);
    return qc_statusOk;
}

void qcPictureMeshes_Free(qcPictureMeshes* meshes)
{
    qcArray_Free(&meshes->vertices);
    qcArray_Free(&meshes->indices);
    qcArray_Free(&meshes->ranges);
}

void qcPictureMeshes_Upload(const struct qcGlFunctions* gl, qcPictureMeshes* meshes)
{
    gl->GenVertexArrays(1, &meshes->vertexArray);
    gl->BindVertexArray(meshes->vertexArray);
    gl->GenBuffers(1, &meshes->vertexBuffer);
    gl->BindBuffer(GL_ARRAY_BUFFER, meshes->vertexBuffer);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(meshes->vertices.count * sizeof(float)), meshes->vertices.data,
                   GL_STATIC_DRAW);
    gl->GenBuffers(1, &meshes->indexBuffer);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, meshes->indexBuffer);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(meshes->indices.count * sizeof(uint32_t)),
                   meshes->indices.data, GL_STATIC_DRAW);
    for (GLuint i = 0; i < 2; ++i)
    {
        gl->VertexAttribPointer(i, 3, GL_FLOAT, GL_FALSE, qc_vertexFloats * sizeof(float),
                                (const void*)((size_t)3 * i * sizeof(float)));
        gl->EnableVertexAttribArray(i);
    }
}

void qcPictureMeshes_Delete(const struct qcGlFunctions* gl, qcPictureMeshes* meshes)
{
    gl->DeleteVertexArrays(1, &meshes->vertexArray);
    gl->DeleteBuffers(1, &meshes->vertexBuffer);
    gl->DeleteBuffers(1, &meshes->indexBuffer);
}

void qcPictureMeshes_Draw(const struct qcGlFunctions* gl, const qcPictureRange* range, bool marked)
{
    size_t first = range->first + (marked ? (size_t)3 * range->plainCount : 0);
    uint32_t count = marked ? range->markedCount : range->plainCount;
    if (count > 0)
        gl->DrawElements(GL_TRIANGLES, (GLsizei)(3 * count), GL_UNSIGNED_INT, (const void*)(first * sizeof(uint32_t)));
}
