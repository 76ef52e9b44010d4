// Bodies by slot, and all their triangles as one soup.
#include "bench/paper/soup.h"

#include <stdlib.h>
#include <string.h>

static void FreeBody(qcPaperSoupBody* body)
{
    free(body->positions);
    free(body->indices);
    *body = (qcPaperSoupBody){0};
}

static void TakePositions(qcPaperSoupBody* body, const void* positions, qcPositionType type)
{
    size_t count = 3 * (size_t)body->vertexCount;
    if (type == qc_positionF64)
        memcpy(body->positions, positions, count * sizeof(double));
    for (size_t i = 0; type == qc_positionF32 && i < count; ++i)
        body->positions[i] = (double)((const float*)positions)[i];
}

static bool AddBody(qcPaperSoup* soup, const qcOperation* operation)
{
    const qcBodyDef* def = &operation->body;
    uint32_t slot = operation->id.slot;
    if (slot >= soup->bodyCount)
    {
        qcPaperSoupBody* bodies = realloc(soup->bodies, ((size_t)slot + 1) * sizeof *bodies);
        if (bodies == NULL)
            return false;
        memset(bodies + soup->bodyCount, 0, (slot + 1 - soup->bodyCount) * sizeof *bodies);
        soup->bodies = bodies;
        soup->bodyCount = slot + 1;
    }
    qcPaperSoupBody* body = &soup->bodies[slot];
    FreeBody(body);
    body->positions = malloc((3 * (size_t)def->vertexCount + 1) * sizeof(double));
    body->indices = malloc((3 * (size_t)def->triangleCount + 1) * sizeof(uint32_t));
    if (body->positions == NULL || body->indices == NULL)
        return false;
    body->isThere = true;
    body->deforming = def->deforming;
    body->selfCollision = def->selfCollision;
    body->vertexCount = def->vertexCount;
    body->triangleCount = def->triangleCount;
    body->transform = def->transform;
    body->group = def->group;
    body->mask = def->mask;
    body->owner = def->owner;
    if (def->vertexCount != 0)
        TakePositions(body, def->positions, def->positionType);
    if (def->triangleCount != 0)
        memcpy(body->indices, def->indices, 3 * (size_t)def->triangleCount * sizeof(uint32_t));
    return true;
}

bool qcPaperSoup_Apply(qcPaperSoup* soup, const qcOperation* operation)
{
    qcPaperSoupBody* body = operation->id.slot < soup->bodyCount ? &soup->bodies[operation->id.slot] : NULL;
    switch (operation->kind)
    {
        case qc_operationAddBody: soup->changes++; return AddBody(soup, operation);
        case qc_operationRemoveBody:
            soup->changes++;
            FreeBody(body);
            return true;
        case qc_operationSetTransform: body->transform = operation->transform; return true;
        case qc_operationSetVertices: TakePositions(body, operation->positions, operation->positionType); return true;
        default: return true;
    }
}

bool qcPaperSoup_Collect(qcPaperSoup* soup)
{
    soup->vertexCount = soup->triangleCount = 0;
    for (uint32_t slot = 0; slot < soup->bodyCount; ++slot)
    {
        soup->vertexCount += soup->bodies[slot].vertexCount;
        soup->triangleCount += soup->bodies[slot].triangleCount;
    }
    free(soup->positions);
    free(soup->indices);
    free(soup->firstTriangles);
    soup->positions = malloc((3 * (size_t)soup->vertexCount + 1) * sizeof(double));
    soup->indices = malloc((3 * (size_t)soup->triangleCount + 1) * sizeof(uint32_t));
    soup->firstTriangles = malloc(((size_t)soup->bodyCount + 1) * sizeof(uint32_t));
    if (soup->positions == NULL || soup->indices == NULL || soup->firstTriangles == NULL)
        return false;
    uint32_t vertex = 0, triangle = 0;
    for (uint32_t slot = 0; slot < soup->bodyCount; ++slot)
    {
        const qcPaperSoupBody* body = &soup->bodies[slot];
        soup->firstTriangles[slot] = triangle;
        for (size_t i = 0; i < 3 * (size_t)body->triangleCount; ++i)
            soup->indices[3 * (size_t)triangle + i] = vertex + body->indices[i];
        vertex += body->vertexCount;
        triangle += body->triangleCount;
    }
    return true;
}

static void PlaceBody(const qcPaperSoupBody* body, double* out)
{
    const qcTransform* t = &body->transform;
    if (body->deforming)
    {
        memcpy(out, body->positions, 3 * (size_t)body->vertexCount * sizeof(double));
        return;
    }
    for (size_t vertex = 0; vertex < body->vertexCount; ++vertex)
    {
        const double* p = body->positions + 3 * vertex;
        for (size_t axis = 0; axis < 3; ++axis)
        {
            const double* row = t->linear + 3 * axis;
            out[3 * vertex + axis] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + t->translation[axis];
        }
    }
}

void qcPaperSoup_Place(qcPaperSoup* soup)
{
    double* out = soup->positions;
    for (uint32_t slot = 0; slot < soup->bodyCount; ++slot)
    {
        if (soup->bodies[slot].isThere)
            PlaceBody(&soup->bodies[slot], out);
        out += 3 * (size_t)soup->bodies[slot].vertexCount;
    }
}

void qcPaperSoup_Free(qcPaperSoup* soup)
{
    for (uint32_t slot = 0; slot < soup->bodyCount; ++slot)
        FreeBody(&soup->bodies[slot]);
    free(soup->bodies);
    free(soup->positions);
    free(soup->indices);
    free(soup->firstTriangles);
    *soup = (qcPaperSoup){0};
}
