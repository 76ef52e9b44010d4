// A coarser mesh of the same shape.
// Rossignac, Borrel: Multi-resolution 3D approximations for rendering complex scenes, 1993 (vertex clustering).
#include "common/mesh_io/decimate.h"

#include "common/mesh_io/bounds.h"

#include <stdlib.h>
#include <string.h>

enum
{
    qc_maxCells = 1 << 12, // along the longest edge of the box
    qc_maxTries = 16       // grids
};

typedef struct Member
{
    uint64_t cell;
    uint32_t vertex;
} Member;

typedef struct Clusters
{
    const qcMesh* mesh;
    double lower[3], extent;
    Member* members;    ///< sorted by cell
    uint32_t* clusters; ///< of each vertex
    uint32_t clusterCount;
} Clusters;

static int CompareMembers(const void* a, const void* b)
{
    const Member *x = a, *y = b;
    if (x->cell != y->cell)
        return x->cell < y->cell ? -1 : 1;
    return (x->vertex > y->vertex) - (x->vertex < y->vertex);
}

static void Cluster(Clusters* c, uint32_t cells)
{
    for (uint32_t vertex = 0; vertex < c->mesh->vertexCount; ++vertex)
    {
        double p[3];
        uint64_t cell = 0;
        qcMesh_GetVertex(c->mesh, vertex, p);
        for (int i = 0; i < 3; ++i)
            cell = cell << 16 | (uint64_t)((p[i] - c->lower[i]) / c->extent * cells);
        c->members[vertex] = (Member){cell, vertex};
    }
    qsort(c->members, c->mesh->vertexCount, sizeof *c->members, CompareMembers);
    c->clusterCount = 0;
    for (uint32_t i = 0; i < c->mesh->vertexCount; ++i)
    {
        c->clusterCount += i == 0 || c->members[i].cell != c->members[i - 1].cell;
        c->clusters[c->members[i].vertex] = c->clusterCount - 1;
    }
}

/// Three clusters of a triangle; false: it collapses.
static bool GetCorners(const Clusters* c, uint32_t triangle, uint32_t corners[3])
{
    for (size_t i = 0; i < 3; ++i)
        corners[i] = c->clusters[c->mesh->indices[3 * (size_t)triangle + i]];
    return corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0];
}

static uint32_t CountTriangles(const Clusters* c)
{
    uint32_t count = 0, corners[3];
    for (uint32_t i = 0; i < c->mesh->triangleCount; ++i)
        count += GetCorners(c, i, corners);
    return count;
}

/// The finest grid with at most `maxTriangles` triangles.
static uint32_t FindCells(Clusters* c, uint32_t maxTriangles)
{
    uint32_t low = 1, high = qc_maxCells;
    while (low + 1 < high)
    {
        uint32_t middle = (low + high) / 2;
        Cluster(c, middle);
        if (CountTriangles(c) <= maxTriangles)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/// A triangle that is left: its clusters in ascending order, and whether they are so in an odd permutation.
typedef struct Face
{
    uint32_t corners[3], isOdd;
} Face;

static int CompareFaces(const void* a, const void* b)
{
    return memcmp(((const Face*)a)->corners, ((const Face*)b)->corners, sizeof((const Face*)a)->corners);
}

static void SortCorners(Face* face, size_t i)
{
    uint32_t low = face->corners[i], high = face->corners[i + 1];
    if (low <= high)
        return;
    face->corners[i] = high;
    face->corners[i + 1] = low;
    face->isOdd ^= 1;
}

/// True if parts that fell together make a triangle twice, where two that face each other count as none. `faces` has
/// room for all.
static bool HasDoubles(const Clusters* c, Face* faces)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < c->mesh->triangleCount; ++i)
    {
        faces[count].isOdd = 0;
        if (!GetCorners(c, i, faces[count].corners))
            continue;
        SortCorners(&faces[count], 0);
        SortCorners(&faces[count], 1);
        SortCorners(&faces[count], 0);
        ++count;
    }
    qsort(faces, count, sizeof *faces, CompareFaces);
    int64_t times = 0;
    bool hasDoubles = false;
    for (uint32_t i = 0; i < count; ++i)
    {
        if (i > 0 && CompareFaces(&faces[i - 1], &faces[i]) != 0)
            times = 0;
        times += faces[i].isOdd != 0 ? -1 : 1;
        bool isLast = i + 1 == count || CompareFaces(&faces[i], &faces[i + 1]) != 0;
        hasDoubles |= isLast && (times > 1 || times < -1);
    }
    return hasDoubles;
}

/// Groups by the finest grid with at most `maxTriangles` triangles, none of them twice: the inside of a closed mesh
/// would count twice there. If no grid with half as many triangles is so, by the finest one. False: out of memory.
static bool Group(Clusters* c, uint32_t maxTriangles)
{
    uint32_t finest = FindCells(c, maxTriangles);
    Cluster(c, finest);
    uint32_t most = CountTriangles(c), least = most / 2;
    Face* faces = malloc(((size_t)most + 1) * sizeof *faces);
    if (faces == NULL)
        return false;
    uint32_t cells = finest;
    bool found = !HasDoubles(c, faces);
    while (!found && cells > 1 && finest - cells < qc_maxTries)
    {
        Cluster(c, --cells);
        uint32_t count = CountTriangles(c);
        found = count >= least && count <= most && !HasDoubles(c, faces);
    }
    if (!found)
        Cluster(c, finest);
    free(faces);
    return true;
}

static void PutVertices(const Clusters* c, float* positions)
{
    for (uint32_t i = 0, cluster = 0; i < c->mesh->vertexCount; ++cluster)
    {
        double sum[3] = {0.0, 0.0, 0.0}, p[3];
        uint32_t first = i;
        for (; i < c->mesh->vertexCount && c->members[i].cell == c->members[first].cell; ++i)
        {
            qcMesh_GetVertex(c->mesh, c->members[i].vertex, p);
            for (int axis = 0; axis < 3; ++axis)
                sum[axis] += p[axis];
        }
        for (int axis = 0; axis < 3; ++axis)
            positions[3 * (size_t)cluster + (size_t)axis] = (float)(sum[axis] / (i - first));
    }
}

static bool Build(Clusters* c, uint32_t triangleCount, qcMesh* coarse)
{
    c->members = malloc(c->mesh->vertexCount * sizeof *c->members);
    c->clusters = malloc(c->mesh->vertexCount * sizeof *c->clusters);
    if (c->members == NULL || c->clusters == NULL || !Group(c, triangleCount))
        return false;
    coarse->vertexCount = c->clusterCount;
    coarse->positions = malloc((size_t)c->clusterCount * 3 * sizeof(float));
    coarse->indices = malloc(((size_t)CountTriangles(c) * 3 + 1) * sizeof(uint32_t));
    if (coarse->positions == NULL || coarse->indices == NULL)
        return false;
    PutVertices(c, coarse->positions);
    for (uint32_t i = 0; i < c->mesh->triangleCount; ++i)
    {
        uint32_t corners[3];
        if (!GetCorners(c, i, corners))
            continue;
        memcpy(&coarse->indices[3 * (size_t)coarse->triangleCount], corners, sizeof corners);
        ++coarse->triangleCount;
    }
    return true;
}

bool qcMesh_Decimate(const qcMesh* mesh, uint32_t triangleCount, qcMesh* coarse)
{
    Clusters clusters = {.mesh = mesh};
    double upper[3];
    *coarse = (qcMesh){0};
    clusters.extent = qcMesh_FindBox(mesh, 1, clusters.lower, upper);
    bool built = Build(&clusters, triangleCount, coarse);
    free(clusters.members);
    free(clusters.clusters);
    if (!built)
        qcMesh_Free(coarse);
    return built;
}
