// Textures of pieces: attributes of the mesh, interpolated by barycentric coordinates (Ericson: Real-Time Collision
// Detection, 2005, section 3.4), and planar coordinates in cuts.
#include "quickcullide/bullet_fracture.h"

#include "common/double_vector.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace
{
/// A vertex of the piece in the mesh's frame.
qcDoubleVector PlaceOf(const qcPiece& piece, uint32_t vertex)
{
    const btMatrix3x3& axes = piece.frame.getBasis();
    const btVector3 &v = piece.vertices[vertex], &origin = piece.frame.getOrigin();
    qcDoubleVector place;
    for (int i = 0; i < 3; i++)
        place[size_t(i)] = double(axes[i][0]) * double(v[0]) + double(axes[i][1]) * double(v[1]) +
                           double(axes[i][2]) * double(v[2]) + double(origin[i]);
    return place;
}

/// The power of two just below the largest component, in which products neither overflow nor vanish; 1 for zeros.
double UnitOf(std::initializer_list<qcDoubleVector> vectors)
{
    double largest = 0;
    for (const qcDoubleVector& vector : vectors)
        for (double component : vector)
            largest = std::max(largest, std::fabs(component));
    return largest > 0 && std::isfinite(largest) ? std::exp2(std::ilogb(largest)) : 1;
}

/// Exact where the unit is a power of two.
qcDoubleVector InUnits(const qcDoubleVector& v, double unit)
{
    return {v[0] / unit, v[1] / unit, v[2] / unit};
}

/// The weights of a triangle's corners at the point nearest to `p`, or nearly so: outside it is drawn to an edge.
btVector3 WeightsAt(const qcDoubleVector& p, const qcDoubleVector corners[3])
{
    qcDoubleVector u = qcMinus(corners[1], corners[0]), v = qcMinus(corners[2], corners[0]);
    const double unit = UnitOf({u, v});
    u = InUnits(u, unit);
    v = InUnits(v, unit);
    qcDoubleVector w = InUnits(qcMinus(p, corners[0]), unit), normal = qcCrossOf(u, v);
    double square = qcDotOf(normal, normal), weights[3] = {1, 0, 0};
    if (square > 0 && std::isfinite(square))
    {
        weights[1] = std::min(std::max(qcDotOf(qcCrossOf(w, v), normal) / square, 0.0), 1.0);
        weights[2] = std::min(std::max(qcDotOf(qcCrossOf(u, w), normal) / square, 0.0), 1.0 - weights[1]);
        weights[0] = 1 - weights[1] - weights[2];
    }
    return btVector3(btScalar(weights[0]), btScalar(weights[1]), btScalar(weights[2]));
}

/// The first reason why the piece is none of the mesh, or an empty text.
std::string FindDefect(const qcFractureDef& mesh, const qcPiece& piece)
{
    size_t triangles = piece.indices.size() / 3, meshTriangles = mesh.indices.size() / 3;
    if (mesh.vertices.empty())
        return "the mesh has no vertices";
    if (piece.indices.size() % 3 != 0 || piece.sources.size() != triangles || piece.firstCutTriangle > triangles)
        return "the piece has " + std::to_string(piece.indices.size()) + " indices, " +
               std::to_string(piece.sources.size()) + " sources and " + std::to_string(piece.firstCutTriangle) +
               " triangles outside";
    for (size_t i = 0; i < piece.indices.size(); i++)
        if (piece.indices[i] >= piece.vertices.size())
            return "index " + std::to_string(i) + " of the piece is " + std::to_string(piece.indices[i]) + " of " +
                   std::to_string(piece.vertices.size()) + " vertices";
    for (size_t t = 0; t < piece.firstCutTriangle; t++)
    {
        if (piece.sources[t] >= meshTriangles)
            return "triangle " + std::to_string(t) + " of the piece is of triangle " +
                   std::to_string(piece.sources[t]) + " of a mesh of " + std::to_string(meshTriangles);
        for (size_t c = 0; c < 3; c++)
            if (mesh.indices[3 * size_t(piece.sources[t]) + c] >= mesh.vertices.size())
                return "an index of triangle " + std::to_string(piece.sources[t]) + " is out of range";
    }
    return "";
}

/// Coordinates in the plane of a cut. Those on its other side are the same.
struct CutPlane
{
    qcDoubleVector normal = {0, 0, 0}; ///< the sum of the triangles' cross products, from the lower site to the higher
    qcDoubleVector u, v;

    void FindAxes()
    {
        double length = std::sqrt(qcDotOf(normal, normal));
        qcDoubleVector n = {0, 0, 1};
        if (length > 0)
            n = {normal[0] / length, normal[1] / length, normal[2] / length};
        // Both sides of the cut choose the same axis, though their normals differ by rounding: nearly equal
        // components, as of a plane at 45 degrees or along two axes, count as equal.
        size_t smallest = 0;
        for (size_t i = 1; i < 3; i++)
            if (std::fabs(n[i]) < std::fabs(n[smallest]) - 0.001)
                smallest = i;
        u = {0, 0, 0};
        u[smallest] = 1;
        double along = n[smallest];
        u = {u[0] - along * n[0], u[1] - along * n[1], u[2] - along * n[2]};
        double size = std::sqrt(qcDotOf(u, u));
        u = {u[0] / size, u[1] / size, u[2] / size};
        v = qcCrossOf(n, u);
    }
};

std::map<uint32_t, CutPlane> PlanesOf(const qcPiece& piece)
{
    std::map<uint32_t, CutPlane> planes; // by the site on the other side
    btVector3 size(0, 0, 0);
    for (const btVector3& vertex : piece.vertices)
        size.setMax(vertex.absolute());
    const double unit = UnitOf({qcDoubleVectorOf(size)});
    for (size_t t = piece.firstCutTriangle; t < piece.sources.size(); t++)
    {
        qcDoubleVector corners[3];
        for (size_t c = 0; c < 3; c++)
            corners[c] = PlaceOf(piece, piece.indices[3 * t + c]);
        const qcDoubleVector cross =
            qcCrossOf(InUnits(qcMinus(corners[1], corners[0]), unit), InUnits(qcMinus(corners[2], corners[0]), unit));
        CutPlane& plane = planes[piece.sources[t]];
        for (size_t i = 0; i < 3; i++)
            plane.normal[i] += piece.site < piece.sources[t] ? cross[i] : -cross[i];
    }
    for (auto& plane : planes)
        plane.second.FindAxes();
    return planes;
}
} // namespace

std::vector<btVector3> qcWeightsOfPiece(const qcFractureDef& mesh, const qcPiece& piece)
{
    std::vector<btVector3> weights;
    if (!FindDefect(mesh, piece).empty())
        return weights;
    weights.reserve(3 * size_t(piece.firstCutTriangle));
    for (size_t t = 0; t < piece.firstCutTriangle; t++)
    {
        qcDoubleVector corners[3];
        for (size_t c = 0; c < 3; c++)
            corners[c] = qcDoubleVectorOf(mesh.vertices[mesh.indices[3 * size_t(piece.sources[t]) + c]]);
        for (size_t c = 0; c < 3; c++)
            weights.push_back(WeightsAt(PlaceOf(piece, piece.indices[3 * t + c]), corners));
    }
    return weights;
}

qcPieceTexture qcTexturePiece(const qcFractureDef& mesh, const qcPiece& piece, const qcTextureDef& texture)
{
    qcPieceTexture made;
    size_t triangles = mesh.indices.size() / 3;
    std::string defect = FindDefect(mesh, piece);
    if (!texture.coordinates.empty() && texture.coordinates.size() != 6 * triangles)
        defect = std::to_string(texture.coordinates.size()) + " texture coordinates for a mesh of " +
                 std::to_string(triangles) + " triangles, which has six a triangle";
    if (!texture.materials.empty() && texture.materials.size() != triangles)
        defect = std::to_string(texture.materials.size()) + " materials for a mesh of " + std::to_string(triangles) +
                 " triangles";
    if (!defect.empty())
    {
        made.message = "qcTexturePiece: " + defect;
        made.status = qcFail(qc_statusBadInput, "%s", made.message.c_str());
        return made;
    }
    std::vector<btVector3> weights = qcWeightsOfPiece(mesh, piece);
    for (size_t i = 0; i < weights.size(); i++)
        for (size_t k = 0; k < 2; k++)
        {
            double sum = 0;
            for (size_t c = 0; c < 3 && !texture.coordinates.empty(); c++)
                sum += double(weights[i][int(c)]) *
                       double(texture.coordinates[6 * size_t(piece.sources[i / 3]) + 2 * c + k]);
            made.coordinates.push_back(float(sum));
        }
    for (size_t t = 0; t < piece.firstCutTriangle; t++)
        made.materials.push_back(texture.materials.empty() ? 0 : texture.materials[piece.sources[t]]);
    const std::map<uint32_t, CutPlane> planes = PlanesOf(piece);
    // Far from the mesh, the axes' rounding would count.
    const qcDoubleVector origin = qcDoubleVectorOf(mesh.vertices[0]);
    for (size_t t = piece.firstCutTriangle; t < piece.sources.size(); t++)
    {
        const CutPlane& plane = planes.at(piece.sources[t]);
        for (size_t c = 0; c < 3; c++)
        {
            const qcDoubleVector place = qcMinus(PlaceOf(piece, piece.indices[3 * t + c]), origin);
            made.coordinates.push_back(float(texture.cutScale * qcDotOf(place, plane.u)));
            made.coordinates.push_back(float(texture.cutScale * qcDotOf(place, plane.v)));
        }
        made.materials.push_back(texture.cutMaterial);
    }
    return made;
}
