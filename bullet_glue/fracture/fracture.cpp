// Breaks a mesh along the Voronoi cells of sites: a cell holds what remains of the mesh after clipping by the bisector
// with each neighbour. Each cell starts from the part of the mesh near it (fracture/voronoi_cells.h). All
// computations are in units of the mesh's length (fracture/unit_scale.h). The volumes of all cells must add up to that
// of the mesh.
#include "quickcullide/bullet_fracture.h"

#include "common/finite.h"
#include "common/mass_properties.h"
#include "fracture/bonds.h"
#include "fracture/cell_sites.h"
#include "fracture/parallel_scratch.h"
#include "fracture/voronoi_cells.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>

namespace
{
// Draws of a site that equals an earlier one, before a free position is looked for.
constexpr int s_maxDraws = 100;
constexpr btScalar s_minMass = std::numeric_limits<btScalar>::min();
constexpr double s_minShare = 1e-9; ///< min volume of a piece relative to the mesh; smaller pieces are dropped
// Tolerances for a sum of volumes, relative and in cubic units. Boxes, needles and tori turned at random, in up to 125
// cells, had rounding errors of up to 4e-15 and 5e-16.
constexpr double s_volumeShare = 1e-12, s_volumeError = 1e-14;
constexpr double s_minVolume = 100 * s_volumeError; ///< of a mesh: above the errors, so that wrong sums are detected
// A point is enclosed, or is not, if its winding is further from a half; others are on the surface, or at it.
constexpr double s_sureWinding = 0.45;
// In units: corners in cuts are off by less.
constexpr double s_cutError = 1e-12;
// Faces lie in cuts if their corners are off by less: the rounding of btScalar, relative to the largest coordinate of
// the mesh. In double, too, that of single precision, which models in files have, up to a limit in units. In 200 meshes
// of cubes turned in single precision, 2 epsilon were enough. Beyond the last limit narrow bonds would be lost.
constexpr double s_faceRounding = 8 * double(std::numeric_limits<btScalar>::epsilon());
constexpr double s_fileRounding = 8 * double(std::numeric_limits<float>::epsilon()), s_maxFileRounding = 1e-6;
constexpr double s_maxRounding = 4e-3;

qcFracture Fail(const std::string& message)
{
    qcFracture failed;
    failed.message = "qcFracture_Split: " + message;
    failed.status = qcFail(qc_statusBadInput, "%s", failed.message.c_str());
    return failed;
}

//  ---- input -----------------------------------------------------------------------------------------

std::string FindBadSite(const std::vector<btVector3>& sites)
{
    if (sites.empty())
        return "there is no site";
    for (size_t i = 0; i < sites.size(); i++)
        if (!qcIsFinite(sites[i]))
            return "site " + std::to_string(i) + " is not finite";
    std::vector<qcClipPoint> places;
    for (const btVector3& site : sites)
        places.push_back(qcDoubleVectorOf(site));
    if (auto equal = qcFindEqual(places))
        return "sites " + std::to_string(equal->first) + " and " + std::to_string(equal->second) +
               " are at the same place";
    return "";
}

/// The first defect of the definition, or an empty text.
std::string FindDefect(const qcFractureDef& def)
{
    if (def.indices.empty() || def.indices.size() % 3 != 0)
        return std::to_string(def.indices.size()) + " indices: there must be three a triangle, and a triangle";
    for (size_t i = 0; i < def.indices.size(); i++)
        if (def.indices[i] >= def.vertices.size())
            return "index " + std::to_string(i) + " is " + std::to_string(def.indices[i]) + " of " +
                   std::to_string(def.vertices.size()) + " vertices";
    for (size_t i = 0; i < def.vertices.size(); i++)
        if (!qcIsFinite(def.vertices[i]))
            return "vertex " + std::to_string(i) + " is not finite";
    return FindBadSite(def.sites);
}

/// A definition in units of its mesh's length.
struct Job
{
    qcFractureUnits units;
    qcFractureSites sites;
    qcClipSolid solid;
    double volume = 0;
    qcRoundedFaces rounded; ///< the triangles of the mesh
    /// Numbers of faces: first the triangles of the mesh, then cut faces by the site on their other side, then the
    /// sides of boxes around cells.
    uint32_t firstCut = 0;
};

/// The mesh in local positions. Vertices without a triangle get the position of another vertex: welding drops them.
qcFacetedMesh MeshOf(const qcFractureDef& def, const qcFractureUnits& units)
{
    qcFacetedMesh mesh;
    mesh.points.assign(def.vertices.size(), units.Local(def.vertices[def.indices[0]]));
    for (size_t i = 0; i < def.indices.size(); i += 3)
    {
        qcClipTriangle triangle = {{def.indices[i], def.indices[i + 1], def.indices[i + 2]}, uint32_t(i / 3)};
        for (uint32_t corner : triangle.corner)
            mesh.points[corner] = units.Local(def.vertices[corner]);
        mesh.triangles.push_back(triangle);
    }
    return mesh;
}

std::string TextOfTriangle(const qcFractureDef& def, uint32_t triangle)
{
    const btVector3& p = def.vertices[def.indices[3 * size_t(triangle)]];
    return "triangle " + std::to_string(triangle) + ", at " + qcTextOf(double(p.x())) + ", " + qcTextOf(double(p.y())) +
           ", " + qcTextOf(double(p.z()));
}

/// The triangles of a mesh, whose corners have the rounding of the largest coordinate.
qcRoundedFaces RoundedFacesOf(const qcFractureDef& def, const qcFractureUnits& units, const qcFacetedMesh& mesh)
{
    double largest = 0;
    for (const qcClipPoint& p : mesh.points)
        for (size_t i = 0; i < 3; i++)
            largest = std::max(largest, std::fabs(p[i] + units.origin[i]));
    qcRoundedFaces faces;
    faces.rounding = std::max(std::min(s_faceRounding * largest, s_maxRounding),
                              std::min(s_fileRounding * largest, s_maxFileRounding));
    faces.corners.resize(def.indices.size() / 3);
    for (const qcClipTriangle& triangle : mesh.triangles)
        for (size_t c = 0; c < 3; c++)
            faces.corners[triangle.face][c] = mesh.points[triangle.corner[c]];
    return faces;
}

/// Makes the job of a definition without defects. Returns the reason why it can't be done, or an empty text.
std::string Prepare(const qcFractureDef& def, qcClipScratch* scratch, Job* job)
{
    std::string defect = qcFractureUnits_Find(def, &job->units);
    if (!defect.empty())
        return defect;
    qcFacetedMesh mesh = MeshOf(def, job->units);
    qcFacetedMesh_Weld(&mesh, scratch);
    const qcSolidDefects defects = qcClipSolid_Make(&mesh, &job->solid);
    if (defects.open)
    {
        const uint32_t triangle = mesh.triangles[*defects.open].face;
        return "the mesh is not closed: an edge of " + TextOfTriangle(def, triangle) +
               ", is not passed as often one way as the other: a hole, or a triangle that is turned around";
    }
    if (defects.equal)
    {
        const uint32_t triangle = mesh.triangles[defects.equal->first].face;
        return TextOfTriangle(def, triangle) + ", is given twice, again as triangle " +
               std::to_string(mesh.triangles[defects.equal->second].face) + ": a part of the mesh counts twice";
    }
    qcClipPoint first;
    job->volume = qcFacetedMesh_Measure(mesh, &first);
    if (job->volume < 0)
        return "the volume is negative: triangles must be counterclockwise as seen from outside";
    if (!(job->volume > 0))
        return "the mesh has no volume";
    if (job->volume < s_minVolume)
        return "the mesh is too thin: its volume is about " + qcTextOf(job->volume) +
               " of the cube of its length, less than " + qcTextOf(s_minVolume);
    double volume = job->units.GlobalVolume(job->volume);
    if (!std::isnormal(s_minShare * volume) || !std::isfinite(volume))
        return "the volume of the mesh, " + qcTextOf(job->volume) + " times the cube of " +
               qcTextOf(job->units.length) + ", leaves the range of double";
    job->firstCut = uint32_t(def.indices.size() / 3);
    job->solid.mayTouchItself = qcFacetedMesh_TouchesItself(mesh);
    job->rounded = RoundedFacesOf(def, job->units, mesh);
    return qcFractureSites_Find(def, job->units, mesh, &job->sites);
}

//  ---- pieces ----------------------------------------------------------------------------------------

/// How many times a mesh encloses a point: the sum of the solid angles of its triangles (van Oosterom, Strackee: The
/// solid angle of a plane triangle, 1983).
double WindingAbout(const qcFacetedMesh& mesh, const qcClipPoint& point)
{
    double sum = 0;
    for (const qcClipTriangle& triangle : mesh.triangles)
    {
        qcClipPoint e[3];
        double length[3];
        for (size_t c = 0; c < 3; c++)
        {
            e[c] = qcMinus(mesh.points[triangle.corner[c]], point);
            length[c] = std::sqrt(qcDotOf(e[c], e[c]));
        }
        sum += std::atan2(qcDotOf(e[0], qcCrossOf(e[1], e[2])),
                          length[0] * length[1] * length[2] + qcDotOf(e[0], e[1]) * length[2] +
                              qcDotOf(e[1], e[2]) * length[0] + qcDotOf(e[2], e[0]) * length[1]);
    }
    return sum / (2 * 3.14159265358979323846);
}

/// True if a mesh encloses another one that doesn't cross it. Where they touch, a point on both decides nothing.
bool Encloses(const qcFacetedMesh& outer, const qcFacetedMesh& inner)
{
    double sum = 0;
    for (const qcClipTriangle& triangle : inner.triangles)
    {
        qcClipPoint center;
        for (size_t axis = 0; axis < 3; axis++)
            center[axis] = (inner.points[triangle.corner[0]][axis] + inner.points[triangle.corner[1]][axis] +
                            inner.points[triangle.corner[2]][axis]) /
                           3;
        const double winding = WindingAbout(outer, center);
        if (std::fabs(winding - 0.5) > s_sureWinding)
            return winding > 0.5;
        sum += winding;
    }
    return sum > 0.5 * double(inner.triangles.size());
}

/// Joins hollows to the pieces around them. A hollow is a component of its own, inside out; it belongs to the smallest
/// component that encloses it.
void JoinHollows(std::vector<qcFacetedMesh>* components)
{
    auto holds = [](const qcFacetedMesh& outer, const qcFacetedMesh& inner)
    {
        for (size_t axis = 0; axis < 3; axis++)
        {
            auto less = [axis](const qcClipPoint& a, const qcClipPoint& b) { return a[axis] < b[axis]; };
            auto o = std::minmax_element(outer.points.begin(), outer.points.end(), less);
            auto i = std::minmax_element(inner.points.begin(), inner.points.end(), less);
            if ((*o.first)[axis] > (*i.first)[axis] + s_cutError || (*o.second)[axis] < (*i.second)[axis] - s_cutError)
                return false;
        }
        return true;
    };
    if (components->size() == 1)
        return;
    std::vector<double> volumes;
    for (const qcFacetedMesh& component : *components)
    {
        qcClipPoint first;
        volumes.push_back(qcFacetedMesh_Measure(component, &first));
    }
    for (size_t i = 0; i < components->size(); i++)
    {
        if (volumes[i] >= 0)
            continue;
        qcFacetedMesh& inner = (*components)[i];
        size_t around = components->size();
        for (size_t k = 0; k < components->size(); k++)
            if (volumes[k] > 0 && (around == components->size() || volumes[k] < volumes[around]) &&
                holds((*components)[k], inner) && Encloses((*components)[k], inner))
                around = k;
        if (around == components->size())
            continue;
        qcFacetedMesh& outer = (*components)[around];
        uint32_t offset = uint32_t(outer.points.size());
        outer.points.insert(outer.points.end(), inner.points.begin(), inner.points.end());
        for (qcClipTriangle triangle : inner.triangles)
        {
            for (uint32_t& corner : triangle.corner)
                corner += offset;
            outer.triangles.push_back(triangle);
        }
        inner = qcFacetedMesh();
    }
}

/// The pieces in a cell. Volumes are in cubic units.
struct CellPieces
{
    std::vector<qcPiece> pieces;
    std::vector<qcPieceCuts> cuts; ///< of each piece
    double volume = 0; ///< of all components, lost ones included; components that are inside out count negative
    double lostVolume = 0;
};

/// Puts the origin of the piece's frame at `center`, rounded, and fills the vertices, in units, relative to it.
qcMassProperties MeasureAbout(const qcFacetedMesh& component, const qcClipPoint& center, const qcFractureUnits& units,
                              qcPiece* piece)
{
    piece->frame.setOrigin(units.Global(center));
    const qcClipPoint origin = units.Local(piece->frame.getOrigin());
    piece->vertices.clear();
    for (const qcClipPoint& p : component.points)
        piece->vertices.emplace_back(btScalar(p[0] - origin[0]), btScalar(p[1] - origin[1]),
                                     btScalar(p[2] - origin[2]));
    // In units, so that no moment of inertia overflows.
    return qcMassPropertiesOf(
        qcMeasureSolid(piece->vertices.data(), piece->indices.data(), uint32_t(piece->indices.size() / 3)));
}

/// Fills the piece's vertices in its frame: the centre of mass (given in local positions) and the principal axes.
void PutInFrame(const qcFacetedMesh& component, const qcClipPoint& center, const qcFractureUnits& units, qcPiece* piece)
{
    qcMassProperties mass = MeasureAbout(component, center, units, piece);
    // Vertices are relative to the origin of the frame after its rounding to btScalar.
    qcClipPoint origin = units.Local(piece->frame.getOrigin());
    if (!mass.closed)
    {
        // A thin shell has its own centre: that of the volume may lie outside, where parts are inside out.
        for (size_t k = 0; k < 3; k++)
            origin[k] += double(mass.center[int(k)]);
        mass = MeasureAbout(component, origin, units, piece);
        origin = units.Local(piece->frame.getOrigin());
    }
    const btMatrix3x3& axes = mass.principalFrame.getBasis();
    for (size_t i = 0; i < component.points.size(); i++)
    {
        // Rounded once, so that coinciding cut faces of two pieces also coincide in their frames.
        const qcClipPoint& p = component.points[i];
        const qcClipPoint v = {p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]};
        for (int k = 0; k < 3; k++)
            piece->vertices[i][k] = btScalar(
                (v[0] * double(axes[0][k]) + v[1] * double(axes[1][k]) + v[2] * double(axes[2][k])) * units.length);
    }
    piece->frame.setBasis(axes);
    for (int k = 0; k < 3; k++)
        piece->inertia[k] = qcMomentOf(double(mass.principalInertia[k]) * units.length * units.length);
}

/// The triangles of a component in cuts.
qcPieceCuts CutsOf(const Job& job, const qcFacetedMesh& component, uint32_t cell)
{
    qcPieceCuts cuts;
    cuts.cell = cell;
    for (const qcClipTriangle& triangle : component.triangles)
        if (triangle.face >= job.firstCut && triangle.face < job.firstCut + job.sites.numbers.size())
            cuts.triangles.push_back({triangle.face - job.firstCut,
                                      {component.points[triangle.corner[0]], component.points[triangle.corner[1]],
                                       component.points[triangle.corner[2]]}});
    return cuts;
}

/// The site on the other side of a cut face.
uint32_t SiteAcross(const Job& job, uint32_t face)
{
    uint32_t cell = face - job.firstCut;
    return cell < job.sites.numbers.size() ? job.sites.numbers[cell] : UINT32_MAX;
}

/// The volume between the cuts of a component and the planes in which these lie. Where a face of the mesh lies in a cut
/// but for rounding, its corners are off the plane, and triangles on the two sides of the cut differ: without this
/// volume, that of the pieces does not depend on the triangles.
double VolumeBeyondCuts(const Job& job, const qcFacetedMesh& component, uint32_t cell)
{
    double volume = 0;
    qcClipPlane plane = {};
    for (const qcClipTriangle& triangle : component.triangles)
    {
        if (triangle.face < job.firstCut || triangle.face - job.firstCut >= job.sites.numbers.size())
            continue;
        if (plane.face != triangle.face)
            plane = qcFractureSites_Bisect(job.sites, cell, triangle.face - job.firstCut, triangle.face);
        double sides = 0, maxSide = 0;
        const qcClipPoint* corners[3];
        for (size_t c = 0; c < 3; c++)
        {
            corners[c] = &component.points[triangle.corner[c]];
            const double side = qcDotOf(plane.normal, *corners[c]) - plane.distance;
            sides += side;
            maxSide = std::max(maxSide, std::fabs(side));
        }
        if (maxSide > s_cutError)
            volume +=
                qcDotOf(plane.normal, qcCrossOf(qcMinus(*corners[1], *corners[0]), qcMinus(*corners[2], *corners[0]))) /
                2 * sides / 3;
    }
    return volume;
}

void AddPiece(const Job& job, const qcFacetedMesh& component, uint32_t cell, bool hasRoundedCuts,
              CellPieces* cellPieces)
{
    qcClipPoint first;
    const double inside = qcFacetedMesh_Measure(component, &first);
    const double volume = hasRoundedCuts ? inside - VolumeBeyondCuts(job, component, cell) : inside;
    cellPieces->volume += volume;
    if (!(std::min(volume, inside) > s_minShare * job.volume))
    {
        cellPieces->lostVolume += std::fabs(volume);
        return;
    }
    qcPiece piece;
    piece.site = job.sites.numbers[cell];
    piece.volume = job.units.GlobalVolume(volume);
    piece.vertices.reserve(component.points.size());
    piece.indices.reserve(3 * component.triangles.size());
    piece.sources.reserve(component.triangles.size());
    for (bool isCut : {false, true})
        for (const qcClipTriangle& triangle : component.triangles)
            if ((triangle.face >= job.firstCut) == isCut)
            {
                piece.firstCutTriangle += !isCut;
                piece.indices.insert(piece.indices.end(), triangle.corner.begin(), triangle.corner.end());
                piece.sources.push_back(isCut ? SiteAcross(job, triangle.face) : triangle.face);
            }
    PutInFrame(component, {first[0] / inside, first[1] / inside, first[2] / inside}, job.units, &piece);
    cellPieces->pieces.push_back(std::move(piece));
    cellPieces->cuts.push_back(CutsOf(job, component, cell));
}

/// The pieces of a solid that is clipped to the cell of a site.
CellPieces PiecesOf(const Job& job, uint32_t site, qcClipSolid* solid, qcClipScratch* scratch)
{
    CellPieces cellPieces;
    qcFacetedMesh mesh;
    qcClipSolid_Triangulate(solid, &mesh, scratch);
    std::vector<qcFacetedMesh> components =
        qcFacetedMesh_FindComponents(mesh, solid->mayTouchItself, s_minShare * job.volume, scratch);
    JoinHollows(&components);
    for (const qcFacetedMesh& component : components)
        AddPiece(job, component, site, solid->hasRoundedCuts, &cellPieces);
    return cellPieces;
}

/// The pieces of each cell, clipped by its neighbours.
std::vector<CellPieces> ClipByNeighbours(const Job& job, const std::vector<qcFractureCell>& cells,
                                         const qcRoundedFaces* rounded)
{
    std::vector<CellPieces> cellPieces(cells.size());
    auto clipCell = [&](size_t site, const qcClipSolid& around, qcClipScratch* scratch)
    {
        const qcClipSolid* from = &around;
        qcClipSolid solid;
        for (uint32_t other : cells[site].neighbours)
        {
            qcClipPlane plane = qcFractureSites_Bisect(job.sites, uint32_t(site), other, job.firstCut + other);
            plane.rounded = rounded;
            qcClipSolid_Clip(*from, plane, scratch, &solid);
            from = &solid;
        }
        if (from == &around)
            solid = around;
        cellPieces[site] = PiecesOf(job, uint32_t(site), &solid, scratch);
    };
    qcDistributeSolid(job.solid, cells, job.firstCut + uint32_t(cells.size()), clipCell);
    return cellPieces;
}

/// The pieces of each cell, clipped by all sites that are near enough. Slower, but without voro++.
std::vector<CellPieces> ClipByDistance(const Job& job, const qcRoundedFaces* rounded)
{
    std::vector<CellPieces> cellPieces(job.sites.numbers.size());
    auto clipCell = [&](size_t site, qcClipScratch* scratch)
    {
        qcClipSolid solid = job.solid;
        qcFractureSites_ClipCell(job.sites, uint32_t(site), job.firstCut, rounded, &solid, scratch);
        cellPieces[site] = PiecesOf(job, uint32_t(site), &solid, scratch);
    };
    qcForEachInParallel(cellPieces.size(), clipCell);
    return cellPieces;
}

double VolumeOf(const std::vector<CellPieces>& cellPieces)
{
    double volume = 0;
    for (const CellPieces& cell : cellPieces)
        volume += cell.volume;
    return volume;
}

/// True if the pieces together have the volume of the mesh: none is missing, none overlap. `error`: in cubic units.
bool FillMesh(const Job& job, const std::vector<CellPieces>& cellPieces, double error)
{
    return std::fabs(VolumeOf(cellPieces) - job.volume) <= s_volumeShare * job.volume + error;
}

/// Finds the pieces of all cells. Faces that lie in cuts but for rounding are laid in them. Far from the origin that
/// may cost volume in the order of the squared rounding: then the cuts are checked without. False: the pieces don't
/// fill the mesh.
bool ClipToCells(const Job& job, std::vector<CellPieces>* cellPieces)
{
    const std::vector<qcFractureCell> cells = qcFindFractureCells(job.solid.points, job.sites.local);
    const double roundedError = s_volumeError + job.rounded.rounding * job.rounded.rounding;
    for (bool byDistance : {false, true})
    {
        if (!byDistance && cells.empty())
            continue;
        auto clip = [&](const qcRoundedFaces* rounded)
        { return byDistance ? ClipByDistance(job, rounded) : ClipByNeighbours(job, cells, rounded); };
        *cellPieces = clip(&job.rounded);
        if (FillMesh(job, *cellPieces, s_volumeError))
            return true;
        std::vector<CellPieces> plain = clip(nullptr);
        const bool isFilled = FillMesh(job, plain, s_volumeError);
        if (!isFilled || !FillMesh(job, *cellPieces, roundedError))
            *cellPieces = std::move(plain);
        if (isFilled)
            return true;
    }
    return false;
}

double Random(uint64_t* state)
{
    // splitmix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators, 2014).
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return double((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

/// The position in a box that follows another one: x first, then y, then z; behind the last one comes the first.
btVector3 NextPosition(const btVector3& position, const btVector3& lower, const btVector3& upper)
{
    btVector3 next = position;
    for (int axis = 0; axis < 3; axis++)
    {
        if (next[axis] < upper[axis])
        {
            next[axis] = std::nextafter(next[axis], upper[axis]);
            break;
        }
        next[axis] = lower[axis];
    }
    return next;
}
} // namespace

qcFracture qcFracture_Split(const qcFractureDef& def)
{
    Job job;
    qcClipScratch scratch;
    std::string defect = FindDefect(def);
    if (defect.empty())
        defect = Prepare(def, &scratch, &job);
    if (!defect.empty())
        return Fail(defect);
    std::vector<CellPieces> cellPieces;
    if (!ClipToCells(job, &cellPieces))
        return Fail("the pieces hold " + qcTextOf(VolumeOf(cellPieces) / job.volume) +
                    " of the mesh's volume: rounding errors of the cuts are too large");
    qcFracture fracture;
    fracture.volume = job.units.GlobalVolume(job.volume);
    fracture.triangleCount = uint32_t(def.indices.size() / 3);
    fracture.siteCount = uint32_t(def.sites.size());
    double lost = 0;
    std::vector<qcPieceCuts> cuts;
    for (CellPieces& some : cellPieces)
    {
        std::move(some.pieces.begin(), some.pieces.end(), std::back_inserter(fracture.pieces));
        std::move(some.cuts.begin(), some.cuts.end(), std::back_inserter(cuts));
        lost += some.lostVolume;
    }
    fracture.lostVolume = job.units.GlobalVolume(lost);
    fracture.bonds = qcFindBonds(cuts, job.units, job.rounded.rounding);
    return fracture;
}

std::vector<btVector3> qcScatterSites(const btVector3& lower, const btVector3& upper, uint32_t count, uint64_t seed,
                                      const btVector3* impact)
{
    std::vector<btVector3> sites;
    std::set<std::array<btScalar, 3>> taken;
    btVector3 dense = impact != nullptr ? *impact : lower;
    dense.setMax(lower);
    dense.setMin(upper);
    auto draw = [&]
    {
        btVector3 site;
        for (int axis = 0; axis < 3; axis++)
            site[axis] = lower[axis] + btScalar(Random(&seed)) * (upper[axis] - lower[axis]);
        site.setW(0);
        // A random share of the way from the impact to the site: densities fall as the square of the distance.
        return impact != nullptr ? dense.lerp(site, btScalar(Random(&seed))) : site;
    };
    auto take = [&taken](const btVector3& site) { return taken.insert({site.x(), site.y(), site.z()}).second; };
    for (uint32_t i = 0; i < count; i++)
    {
        btVector3 site = draw();
        bool isNew = take(site);
        // Far from the origin few positions are near the impact.
        for (int more = 0; more < s_maxDraws && !isNew; more++)
            isNew = take(site = draw());
        // One of as many positions as are taken, and one more, is free.
        for (size_t passed = 0; passed < taken.size() && !isNew; passed++)
            isNew = take(site = NextPosition(site, lower, upper));
        sites.push_back(site);
    }
    return sites;
}

qcPieceMotion qcMotionOfPiece(const btRigidBody& body, const qcFracture& fracture, const qcPiece& piece)
{
    double total = 0;
    for (const qcPiece& other : fracture.pieces)
        total += other.volume;
    qcPieceMotion motion;
    const btTransform& transform = body.getWorldTransform();
    btVector3 arm = transform.getBasis() * piece.frame.getOrigin();
    double inverseMass = double(body.getInvMass());
    const double part = total > 0 ? piece.volume / total : 0;
    // A body of mass 0 is a static one.
    motion.mass = inverseMass > 0 ? std::max(btScalar(part / inverseMass), s_minMass) : btScalar(0);
    motion.transform = btTransform(transform.getBasis() * piece.frame.getBasis(), transform.getOrigin() + arm);
    motion.linearVelocity = body.getLinearVelocity() + body.getAngularVelocity().cross(arm);
    motion.angularVelocity = body.getAngularVelocity();
    return motion;
}
