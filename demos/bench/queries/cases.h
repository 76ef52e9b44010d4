// What `qc-bench queries` measures: static meshes 60 m long, and queries of each kind on them.
#ifndef QC_DEMOS_BENCH_QUERIES_CASES_H
#define QC_DEMOS_BENCH_QUERIES_CASES_H

#include "common/message.h"

#include <LinearMath/btVector3.h>

#include <cstdint>
#include <vector>

namespace queries
{
struct Mesh
{
    std::vector<btVector3> points;
    std::vector<uint32_t> indices;
};

enum MeshIndex
{
    hills5k,
    bunny70k,
    hills500k,
    meshCount
};

/// "hills-500k".
const char* NameOfMesh(int mesh);
/// Makes a mesh whose longest side is 60 m: hills with 5 000 or 500 000 triangles, the bunny of glmark2 or, where that
/// is missing, a knot of 70 000.
Mesh MakeMesh(int mesh);

enum class Kind
{
    closestRay,
    allRays, ///< all hits of a ray
    sphere,
    box,
    capsule,
    contact, ///< contactTest of a box
    aabb     ///< the triangles whose boxes overlap a box
};

struct Case
{
    const char* name;
    Kind kind;
    double length; ///< of the way, or the edge of the box, in metres
    bool misses;   ///< only queries without a hit
};

constexpr int caseCount = 14;
extern const Case cases[caseCount];

/// One ray or sweep, or a box between two corners.
struct Query
{
    btVector3 from, to;
};

/// Queries at random places of the mesh's surface; a way has its middle there. With `misses` each is moved off the
/// surface: the caller leaves out those that still hit. Deterministic.
std::vector<Query> MakeQueries(const Mesh& mesh, const Case& kind, uint32_t count);
} // namespace queries

#endif
