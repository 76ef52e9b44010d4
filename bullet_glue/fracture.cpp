// A mesh broken along the Voronoi cells of sites: in a cell is what is left of the mesh when the bisector with each
// neighbour has cut it. Each is given only what is near to it (fracture_cells.h).
#include "quickcullide/bullet_fracture.h"

#include "fracture_cells.h"
#include "position_type.h"

#include "quickcullide/bullet_mesh.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace
{
constexpr double s_leastShare = 1e-9; ///< of the mesh's volume, that a piece has

qcClipPoint PointOf(const btVector3& v)
{
    return {double(v.x()), double(v.y()), double(v.z())};
}

bool IsFinite(const btVector3& v)
{
    return std::isfinite(double(v.x())) && std::isfinite(double(v.y())) && std::isfinite(double(v.z()));
}

qcFracture Fail(const std::string& message)
{
    qcFracture failed;
    failed.status = qc_statusBadInput;
    failed.message = "qcFracture_Split: " + message;
    return failed;
}

//  ---- input -----------------------------------------------------------------------------------------

/// What is wrong with it, or nothing.
std::string FindFault(const qcFractureDef& def)
{
    if (def.indices.empty() || def.indices.size() % 3 != 0)
        return std::to_string(def.indices.size()) + " indices: there must be three a triangle, and a triangle";
    for (size_t i = 0; i < def.indices.size(); i++)
        if (def.indices[i] >= def.vertices.size())
            return "index " + std::to_string(i) + " is " + std::to_string(def.indices[i]) + " of " +
                   std::to_string(def.vertices.size()) + " vertices";
    for (size_t i = 0; i < def.vertices.size(); i++)
        if (!IsFinite(def.vertices[i]))
            return "vertex " + std::to_string(i) + " is not finite";
    if (def.sites.empty())
        return "there is no site";
    for (size_t i = 0; i < def.sites.size(); i++)
        if (!IsFinite(def.sites[i]))
            return "site " + std::to_string(i) + " is not finite";
    std::vector<std::pair<qcClipPoint, size_t>> sites;
    for (size_t i = 0; i < def.sites.size(); i++)
        sites.emplace_back(PointOf(def.sites[i]), i);
    std::sort(sites.begin(), sites.end());
    for (size_t i = 1; i < sites.size(); i++)
        if (sites[i].first == sites[i - 1].first)
            return "sites " + std::to_string(sites[i - 1].second) + " and " + std::to_string(sites[i].second) +
                   " are at the same place";
    return "";
}

qcClipMesh MeshOf(const qcFractureDef& def)
{
    qcClipMesh mesh;
    for (const btVector3& vertex : def.vertices)
        mesh.points.push_back(PointOf(vertex));
    for (size_t i = 0; i < def.indices.size(); i += 3)
        mesh.triangles.push_back({{def.indices[i], def.indices[i + 1], def.indices[i + 2]}, uint32_t(i / 3)});
    return mesh;
}

//  ---- cells -----------------------------------------------------------------------------------------

/// The plane in the middle of two sites; what is outside is nearer to the second. With the sites exchanged it is the
/// same plane with other signs.
qcClipPlane BisectorOf(const qcClipPoint& a, const qcClipPoint& b, uint32_t face)
{
    qcClipPlane plane;
    plane.face = face;
    double length = 0;
    for (size_t i = 0; i < 3; i++)
        length += (b[i] - a[i]) * (b[i] - a[i]);
    length = std::sqrt(length);
    qcClipPoint middle;
    for (size_t i = 0; i < 3; i++)
    {
        plane.normal[i] = (b[i] - a[i]) / length;
        middle[i] = (a[i] + b[i]) / 2;
    }
    plane.distance = qcDotOf(plane.normal, middle);
    return plane;
}

//  ---- pieces ----------------------------------------------------------------------------------------

/// A hollow in a piece is a part of its own, inside out: it goes to the part around it, the first of those whose box
/// holds it.
void JoinHollows(std::vector<qcClipMesh>* parts)
{
    auto holds = [](const qcClipMesh& outer, const qcClipMesh& inner)
    {
        for (size_t axis = 0; axis < 3; axis++)
        {
            auto less = [axis](const qcClipPoint& a, const qcClipPoint& b) { return a[axis] < b[axis]; };
            auto o = std::minmax_element(outer.points.begin(), outer.points.end(), less);
            auto i = std::minmax_element(inner.points.begin(), inner.points.end(), less);
            if ((*o.first)[axis] > (*i.first)[axis] || (*o.second)[axis] < (*i.second)[axis])
                return false;
        }
        return true;
    };
    for (size_t i = 0; i < parts->size(); i++)
    {
        qcClipPoint first;
        if (qcClipMesh_Measure((*parts)[i], &first) >= 0)
            continue;
        for (size_t k = 0; k < parts->size(); k++)
        {
            qcClipMesh &outer = (*parts)[k], &inner = (*parts)[i];
            if (k == i || qcClipMesh_Measure(outer, &first) <= 0 || !holds(outer, inner))
                continue;
            uint32_t offset = uint32_t(outer.points.size());
            outer.points.insert(outer.points.end(), inner.points.begin(), inner.points.end());
            for (qcClipTriangle triangle : inner.triangles)
            {
                for (uint32_t& corner : triangle.corner)
                    corner += offset;
                outer.triangles.push_back(triangle);
            }
            inner = qcClipMesh();
            break;
        }
    }
}

/// Pieces, and the volume of what is none.
struct Parts
{
    std::vector<qcPiece> pieces;
    double lostVolume = 0;
};

/// The part in the frame of its centre of mass and its principal axes.
void PutInFrame(const qcClipMesh& part, const qcClipPoint& center, qcPiece* piece)
{
    auto about = [&](const qcClipPoint& p) {
        return qcClipPoint{p[0] - center[0], p[1] - center[1], p[2] - center[2]};
    };
    for (const qcClipPoint& p : part.points)
    {
        qcClipPoint v = about(p);
        piece->vertices.emplace_back(btScalar(v[0]), btScalar(v[1]), btScalar(v[2]));
    }
    btMatrix3x3 axes =
        qcMeshShape(piece->vertices.data(), qcBulletPositions, sizeof(btVector3), uint32_t(piece->vertices.size()),
                    piece->indices.data(), uint32_t(piece->indices.size() / 3))
            .getMassProperties()
            .principalFrame.getBasis();
    for (size_t i = 0; i < part.points.size(); i++)
    {
        // Rounded once: cuts of two pieces that lie on each other do so in their frames, too.
        qcClipPoint v = about(part.points[i]);
        for (int k = 0; k < 3; k++)
            piece->vertices[i][k] =
                btScalar(v[0] * double(axes[0][k]) + v[1] * double(axes[1][k]) + v[2] * double(axes[2][k]));
    }
    piece->frame = btTransform(axes, btVector3(btScalar(center[0]), btScalar(center[1]), btScalar(center[2])));
}

void AddPiece(const qcClipMesh& part, double leastVolume, uint32_t site, uint32_t firstCut, Parts* parts)
{
    qcClipPoint first;
    double volume = qcClipMesh_Measure(part, &first);
    if (!(volume > leastVolume))
    {
        parts->lostVolume += std::fabs(volume);
        return;
    }
    qcPiece piece;
    piece.site = site;
    piece.volume = btScalar(volume);
    piece.vertices.reserve(part.points.size());
    piece.indices.reserve(3 * part.triangles.size());
    for (bool isCut : {false, true})
        for (const qcClipTriangle& triangle : part.triangles)
            if ((triangle.face >= firstCut) == isCut)
            {
                piece.firstCutTriangle += !isCut;
                piece.indices.insert(piece.indices.end(), triangle.corner.begin(), triangle.corner.end());
            }
    // As far as a btVector3 tells it.
    PutInFrame(
        part,
        {double(btScalar(first[0] / volume)), double(btScalar(first[1] / volume)), double(btScalar(first[2] / volume))},
        &piece);
    parts->pieces.push_back(std::move(piece));
}

double Random(uint64_t* state)
{
    // splitmix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators, 2014).
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return double((z ^ (z >> 31)) >> 11) * 0x1p-53;
}
} // namespace

qcFracture qcFracture_Split(const qcFractureDef& def)
{
    std::string fault = FindFault(def);
    if (!fault.empty())
        return Fail(fault);
    qcClipMesh mesh = MeshOf(def);
    qcClipScratch scratch;
    qcClipMesh_Weld(&mesh, &scratch);
    qcClipSolid solid;
    size_t open = qcClipSolid_Make(&mesh, &solid);
    if (open < mesh.triangles.size())
    {
        const qcClipPoint& p = mesh.points[mesh.triangles[open].corner[0]];
        return Fail("the mesh is not closed: of the triangle at " + std::to_string(p[0]) + ", " + std::to_string(p[1]) +
                    ", " + std::to_string(p[2]) + " an edge is not passed as often one way as the other");
    }
    qcClipPoint first;
    double volume = qcClipMesh_Measure(mesh, &first);
    if (!(volume > 0))
        return Fail("the volume is not positive: triangles must be counterclockwise as seen from outside");
    std::vector<qcClipPoint> sites;
    for (const btVector3& site : def.sites)
        sites.push_back(PointOf(site));
    std::vector<qcFractureCell> cells = qcFindFractureCells(mesh, sites);
    // The faces: triangles of the mesh, then cuts by the site on their other side, then those of boxes around cells.
    uint32_t firstCut = uint32_t(def.indices.size() / 3);
    std::vector<Parts> parts(sites.size());
    auto cutCell = [&](size_t site, qcClipSolid share, qcClipScratch* own)
    {
        for (uint32_t other : cells[site].neighbours)
            qcClipSolid_Cut(&share, BisectorOf(sites[site], sites[other], firstCut + other), own);
        qcClipMesh made;
        qcClipSolid_Triangulate(&share, &made, own);
        std::vector<qcClipMesh> meshes = qcClipMesh_FindParts(made, own);
        JoinHollows(&meshes);
        for (const qcClipMesh& part : meshes)
            AddPiece(part, s_leastShare * volume, uint32_t(site), firstCut, &parts[site]);
    };
    qcDealSolid(std::move(solid), cells, firstCut + uint32_t(sites.size()), cutCell);
    qcFracture fracture;
    fracture.volume = btScalar(volume);
    double lost = 0;
    for (Parts& some : parts)
    {
        std::move(some.pieces.begin(), some.pieces.end(), std::back_inserter(fracture.pieces));
        lost += some.lostVolume;
    }
    fracture.lostVolume = btScalar(lost);
    return fracture;
}

std::vector<btVector3> qcScatterSites(const btVector3& lower, const btVector3& upper, uint32_t count, uint64_t seed,
                                      const btVector3* impact)
{
    std::vector<btVector3> sites;
    for (uint32_t i = 0; i < count; i++)
    {
        btVector3 site;
        for (int axis = 0; axis < 3; axis++)
            site[axis] = lower[axis] + btScalar(Random(&seed)) * (upper[axis] - lower[axis]);
        site.setW(0);
        // Towards the point by a random share: densities fall as the square of the distance.
        sites.push_back(impact != nullptr ? impact->lerp(site, btScalar(Random(&seed))) : site);
    }
    return sites;
}

qcPieceMotion qcMotionOfPiece(const btRigidBody& body, const qcFracture& fracture, const qcPiece& piece)
{
    btScalar total = 0;
    for (const qcPiece& other : fracture.pieces)
        total += other.volume;
    qcPieceMotion motion;
    const btTransform& transform = body.getWorldTransform();
    btVector3 arm = transform.getBasis() * piece.frame.getOrigin();
    motion.mass = body.getInvMass() > 0 ? piece.volume / total / body.getInvMass() : btScalar(0);
    motion.transform = btTransform(transform.getBasis() * piece.frame.getBasis(), transform.getOrigin() + arm);
    motion.linearVelocity = body.getLinearVelocity() + body.getAngularVelocity().cross(arm);
    motion.angularVelocity = body.getAngularVelocity();
    return motion;
}
