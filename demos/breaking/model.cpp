// Models of the breaking scene: read, scaled, and cut in advance.
#include "breaking/model.h"

#include "breaking/stand_in.h"

#include "common/bullet/points_inside.h"
#include "common/mesh_io/bounds.h"
#include "common/mesh_io/decimate.h"
#include "common/mesh_io/mesh_file.h"
#include "quickcullide/bullet_positions.h"

#include <algorithm>

namespace
{
constexpr double s_dragonLength = 4, s_bunnyLength = 1.3; // m
constexpr btScalar s_margin = btScalar(0.001);            // m; adjacent pieces begin with overlapping margins
constexpr size_t s_sparseness = 2;                        // in the lower half there are fewer cells by this factor
// Gaps of a tenth of a millimetre. Where faces of two bodies coincide, exact tests need exact arithmetic, and the body
// pair counts as touching, which exempts it from the limits of motion in that step.
constexpr btScalar s_pieceScale = btScalar(0.999);
constexpr btScalar s_groundedHeight = btScalar(0.03); // of the lowest point of a piece that stands on the ground, m

/// Vertices from y = 0 up, centred in x and z, and `length` long.
void TakeMesh(const qcMesh& mesh, double length, qcBreakingMesh* taken)
{
    double lower[3], upper[3];
    double longest = qcMesh_FindBox(&mesh, 1, lower, upper);
    double scale = longest > 0 ? length / longest : 1;
    double origin[3] = {(lower[0] + upper[0]) / 2, lower[1], (lower[2] + upper[2]) / 2};
    taken->vertices.resize(mesh.vertexCount);
    for (size_t i = 0; i < mesh.vertexCount; i++)
    {
        double p[3];
        qcMesh_GetVertex(&mesh, i, p);
        taken->vertices[i].setValue(btScalar((p[0] - origin[0]) * scale), btScalar((p[1] - origin[1]) * scale),
                                    btScalar((p[2] - origin[2]) * scale));
    }
    taken->indices.assign(mesh.indices, mesh.indices + 3 * size_t(mesh.triangleCount));
}

bool ReadMesh(const std::string& path, uint32_t triangles, double length, qcBreakingMesh* taken, std::string* message)
{
    qcMesh mesh;
    qcMessage failure;
    if (!qcMesh_ReadFile(path.c_str(), qc_meshAsDeclared, &mesh, &failure))
    {
        *message = failure.text;
        return false;
    }
    // Vertices are merged only: holes narrower than the new edges are closed.
    qcMesh coarse;
    if (mesh.triangleCount > triangles && qcMesh_Decimate(&mesh, triangles, &coarse))
    {
        qcMesh_Free(&mesh);
        mesh = coarse;
    }
    TakeMesh(mesh, length, taken);
    qcMesh_Free(&mesh);
    return true;
}

std::unique_ptr<qcMeshShape> ShapeOf(const std::vector<btVector3>& vertices, const std::vector<uint32_t>& indices)
{
    auto shape = std::make_unique<qcMeshShape>(vertices.data(), qcBulletPositions, sizeof(btVector3),
                                               uint32_t(vertices.size()), indices.data(), uint32_t(indices.size() / 3));
    shape->setMargin(s_margin);
    return shape;
}

/// Sites inside the dragon, denser in its upper half.
std::vector<btVector3> ScatterSites(const qcMeshShape& shape, const qcBreakingModelDef& def,
                                    const qcBreakingModel& model)
{
    btScalar middle = (model.lower.y() + model.upper.y()) / 2;
    // A dragon fills about a sixth of its box; others may get fewer cells.
    std::vector<btVector3> candidates = qcScatterSites(model.lower, model.upper, 32 * def.cells, def.seed), kept;
    for (size_t i = 0; i < candidates.size(); i++)
        if (candidates[i].y() > middle || i % s_sparseness == 0)
            kept.push_back(candidates[i]);
    return qcPointsInside(shape, kept, def.cells);
}

bool CutDragon(const qcBreakingModelDef& def, const qcBreakingMesh& dragon, qcBreakingModel* model,
               std::string* message)
{
    std::unique_ptr<qcMeshShape> whole = ShapeOf(dragon.vertices, dragon.indices);
    whole->setMargin(0);
    whole->getAabb(btTransform::getIdentity(), model->lower, model->upper);
    model->dragonTriangles = whole->getTriangleCount();
    qcFractureDef fracture;
    fracture.vertices = dragon.vertices;
    fracture.indices = dragon.indices;
    fracture.sites = ScatterSites(*whole, def, *model);
    model->fracture = qcFracture_Split(fracture);
    *message = (def.dragon.empty() ? "the dragon" : def.dragon) + ": " + model->fracture.message;
    for (const qcPiece& piece : model->fracture.pieces)
    {
        std::vector<btVector3> vertices = piece.vertices;
        for (btVector3& vertex : vertices)
            vertex *= s_pieceScale;
        model->shapes.push_back(ShapeOf(vertices, piece.indices));
        btVector3 lower, upper;
        model->shapes.back()->getAabb(piece.frame, lower, upper);
        model->grounded.push_back(lower.y() < s_groundedHeight);
    }
    return model->fracture.status == qc_statusOk;
}

bool MakeBunny(const std::string& name, const qcBreakingMesh& mesh, qcBreakingBunny* bunny, std::string* message)
{
    std::unique_ptr<qcMeshShape> shape = ShapeOf(mesh.vertices, mesh.indices);
    qcMassProperties mass = shape->getMassProperties();
    *message = name + ": the mesh is not closed, so it has no mass";
    bunny->shape = shape->makeRecentered(&bunny->upright);
    bunny->volume = mass.volume;
    bunny->inertia = mass.principalInertia;
    return mass.closed;
}
} // namespace

bool qcMakeBreakingModel(const qcBreakingModelDef& def, qcBreakingModel* model, std::string* message)
{
    qcBreakingMesh dragon, bunny;
    if (def.dragon.empty())
        dragon = qcStandInDragon(def.dragonTriangles, s_dragonLength);
    else if (!ReadMesh(def.dragon, def.dragonTriangles, s_dragonLength, &dragon, message))
        return false;
    if (def.bunny.empty())
        bunny = qcStandInBunny(def.bunnyTriangles, s_bunnyLength);
    else if (!ReadMesh(def.bunny, def.bunnyTriangles, s_bunnyLength, &bunny, message))
        return false;
    return CutDragon(def, dragon, model, message) &&
           MakeBunny(def.bunny.empty() ? "the bunny" : def.bunny, bunny, &model->bunny, message);
}
