/// @file
/// Breaks a closed triangle mesh into pieces, one or more in each Voronoi cell that holds a part of it. Pieces have
/// materials and textures, and can be saved. Link quickcullide::fracture or fracture_double, where voro++ and GLU are.
///
///     qcFractureDef def;
///     def.vertices = ..., def.indices = ..., def.sites = qcScatterSites(lower, upper, 100, 1, &impact);
///     qcFracture fracture = qcFracture_Split(def);
///     for (const qcPiece& piece : fracture.pieces) { a qcMeshShape of piece.vertices and piece.indices ... }
#ifndef QUICKCULLIDE_BULLET_FRACTURE_H
#define QUICKCULLIDE_BULLET_FRACTURE_H

#include "base.h"

#include <LinearMath/btTransform.h>

#include <cstdint>
#include <string>
#include <vector>

class btRigidBody;

/// A mesh, and where to break it.
struct qcFractureDef
{
    /// Positions in the mesh's frame. Vertices at equal positions count as one.
    std::vector<btVector3> vertices;
    /// Three for each triangle, counterclockwise as seen from outside.
    std::vector<uint32_t> indices;
    /// One site for each Voronoi cell, anywhere: the cell is the set of points nearer to its site than to any other.
    std::vector<btVector3> sites;
};

/// A closed, connected mesh. Parts of the mesh that touch in edges or corners only are pieces of their own.
struct qcPiece
{
    /// Positions in the piece's frame, rounded to btScalar once, so that they fit those of the adjacent pieces.
    std::vector<btVector3> vertices;
    std::vector<uint32_t> indices; ///< three for each triangle, counterclockwise as seen from outside
    uint32_t firstCutTriangle = 0; ///< triangles from this one on lie in cuts, the others on the mesh's surface
    uint32_t site = 0;             ///< index of the cell's site; a cell may hold several pieces
    /// For each triangle: below firstCutTriangle the triangle of the mesh that it is part of, from there on the site on
    /// the other side of the cut (UINT32_MAX: none, for splinters of rounding).
    std::vector<uint32_t> sources;
    /// Centre of mass and principal axes, in the mesh's frame: the tensor of a btRigidBody is diagonal in this frame.
    /// A piece without an inside (qcMassProperties::closed), as where the mesh crosses itself, counts as a thin shell.
    /// The centre is rounded to btScalar: for a mesh at 1e6, in float, it is off by up to 0.03.
    btTransform frame = btTransform::getIdentity();
    double volume = 0; ///< in cubed units of length; a btScalar might overflow
    /// Moments of inertia for mass 1, along the frame's axes: times the mass, that of a btRigidBody. 0 where btScalar
    /// can't hold a moment.
    btVector3 inertia{0, 0, 0};
};

/// Two pieces, and what they share of the cut between them. In the mesh's frame.
struct qcBond
{
    uint32_t pieceA = 0;       ///< index of a piece
    uint32_t pieceB = 0;       ///< index of the other piece, more than pieceA
    double area = 0;           ///< in squared units of length
    btVector3 center{0, 0, 0}; ///< centroid of the area
    btVector3 normal{0, 0, 0}; ///< of length 1, from pieceA to pieceB
};

/// The pieces of a mesh.
struct qcFracture
{
    qcStatus status = qc_statusOk; ///< qc_statusBadInput: there are no pieces
    std::string message;           ///< the defect of the input, and its place
    std::vector<qcPiece> pieces;   ///< in an order that depends on the input only
    /// Of all pairs of pieces that share an area, by pieceA, then pieceB. Areas that are less than 1e-6 of the mesh's
    /// length wide, or narrower than the distance within which triangles lie in cuts, are of pieces that touch along an
    /// edge: they have none.
    std::vector<qcBond> bonds;
    double volume = 0; ///< of the mesh
    /// Of dropped splinters, each below 1e-9 of the mesh's volume, and of dropped parts that are inside out, where the
    /// surface crosses itself: the pieces then hold more than the mesh by their volume.
    double lostVolume = 0;
    uint32_t triangleCount = 0; ///< of the mesh
    uint32_t siteCount = 0;     ///< of the definition
};

/// Splits a mesh. Equal input gives equal pieces; input scaled by a power of two gives the pieces scaled, bit by bit.
/// Coincident triangles with opposite orientation are dropped. A triangle of the mesh lies in a cut if its corners are
/// less than 1e-6 of the mesh's length from it, as where mesh and sites are turned in single precision, or less than 8
/// epsilon of btScalar times the mesh's largest coordinate (up to 0.004 of the length), as where they are far from the
/// origin in float. The volumes of pieces and splinters sum up to the mesh's volume, parts that are inside out counted
/// as negative, with an error of at most 1e-12 of it plus 1e-14 of the cube of the mesh's length; far from the origin,
/// plus that length times the square of the distance within which triangles lie in cuts.
///
/// qc_statusBadInput, and no pieces:
/// - an index is out of range, a vertex or site is not finite, two sites are equal, or there is no site;
/// - the mesh is not closed (each edge must be used equally often in both directions) or is inside out;
/// - a triangle is given twice, with the same corners in the same order;
/// - the mesh is too thin: its volume is below 1e-12 of the cube of its length, where rounding errors hide overlaps;
/// - the mesh is shorter than 1e-31 or longer than 8e37 (in double: its volume is not from 1e-298 to 1e308);
/// - in double, the nearest site is further from the mesh than 1e144 times its length, or two sites are closer than
///   5e-324 times its length.
///
/// About O(triangles * log(cells)). If two sites are closer than some 1e-6 of the length of the box around mesh and
/// sites, or all sites are further away than 32 to 64 lengths, O(cells * (triangles + cells)). A mesh with hollows adds
/// O(hollows * triangles).
///
/// Don't put more than 2000 sites on one circle around the axis of another site: voro++ ends the process where more
/// than 2048 faces of a cell meet in a corner.
///
/// Thread-safety: any thread may call it, several at once. Its loops run where the library's do: on the threads of
/// qcSetParallelFor or qcSetTaskScheduler, else on the library's own. Pieces don't depend on the number of threads.
QC_API qcFracture qcFracture_Split(const qcFractureDef& def);

/// `count` sites in a box, the same for the same seed. With an impact point they are denser near it, or near the point
/// of the box next to it. No two are equal, unless the box has too few positions. Give `lower` <= `upper` in each
/// axis: otherwise the impact counts as at `upper`. Corners that are not finite, or too far apart for their difference
/// to be, give sites that are not finite, which qcFracture_Split refuses. O(count log count), or O(count * count * log
/// count) if nearly all positions near the impact are sites. Thread-safety: any thread, several at once.
QC_API std::vector<btVector3> qcScatterSites(const btVector3& lower, const btVector3& upper, uint32_t count,
                                             uint64_t seed, const btVector3* impact = nullptr);

/// The motion of a piece when the broken body is replaced: momentum and angular momentum are kept.
struct qcPieceMotion
{
    btScalar mass;             ///< 0 only if the body is static, otherwise at least the smallest normal btScalar
    btTransform transform;     ///< world transform of a body whose shape is the piece's vertices
    btVector3 linearVelocity;  ///< of the piece's centre of mass
    btVector3 angularVelocity; ///< that of the body
};

/// The motion of a piece of `body`. `fracture` must be of the body's mesh in the body's frame, whose origin is its
/// centre of mass. O(pieces). Thread-safety: any thread, several at once, while none changes the body.
QC_API qcPieceMotion qcMotionOfPiece(const btRigidBody& body, const qcFracture& fracture, const qcPiece& piece);

/// @name Materials and texture coordinates
/// @{

/// What the mesh looks like, and its inside.
struct qcTextureDef
{
    /// u and v of each corner of each triangle of the mesh, six a triangle. Empty: all are 0.
    std::vector<float> coordinates;
    std::vector<uint32_t> materials; ///< of each triangle of the mesh. Empty: all are 0
    uint32_t cutMaterial = 1;        ///< of the faces inside
    double cutScale = 1;             ///< change of u or v for a unit of length on these faces
};

/// What a piece looks like.
struct qcPieceTexture
{
    qcStatus status = qc_statusOk; ///< qc_statusBadInput: the rest is empty
    std::string message;           ///< the defect of the input, and its place
    /// u and v of each corner of each triangle of the piece, six a triangle: on the mesh's surface interpolated, in a
    /// cut planar, from the mesh's first vertex, and up to rounding equal on both of its sides.
    std::vector<float> coordinates;
    std::vector<uint32_t> materials; ///< of each triangle of the piece
};

/// Materials and texture coordinates of a piece of `mesh`, whose sites are not used. qc_statusBadInput: a list of the
/// definition is neither empty nor as long as the mesh's triangles need it, an index is out of range, or the piece
/// names a triangle that the mesh lacks. O(triangles of the piece). Thread-safety: any thread, several at once.
QC_API qcPieceTexture qcTexturePiece(const qcFractureDef& mesh, const qcPiece& piece, const qcTextureDef& texture);

/// For each corner of the triangles below piece.firstCutTriangle, the weights of its source triangle's three corners, 0
/// to 1, which add up to 1: they interpolate any other attribute of the mesh. Empty if the piece names a triangle that
/// the mesh lacks. O(triangles of the piece). Thread-safety: any thread, several at once.
QC_API std::vector<btVector3> qcWeightsOfPiece(const qcFractureDef& mesh, const qcPiece& piece);
/// @}

/// @name Pieces in files
/// A mesh is split offline, and its pieces are loaded at start. Thread-safety: any thread, several at once with
/// different files.
/// @{

/// Writes a fracture, with its bonds, to a new file (plugin/docs/piece_files.md), in place of an old one when it is
/// complete: until then, and on failure, the old one stays. qc_statusBadInput: the path is null, or the fracture is not
/// one that qcFracture_Split or qcFracture_Load returns without an error; no file is written. qc_statusFile: the file
/// can't be written. `message` (may be null) then names the place. O(size).
QC_API qcStatus qcFracture_Save(const qcFracture& fracture, const char* path, std::string* message = nullptr);

/// Reads a file of qcFracture_Save, bit by bit what was saved; between float and double the numbers are rounded.
/// qc_statusFile: it is missing, not such a file, of another version or damaged, and there are no pieces; the message
/// names the file, the record and the byte. No file, however damaged, crashes the program. qc_statusOutOfMemory: it has
/// no room in memory. qc_statusBadInput: the path is null. O(size).
QC_API qcFracture qcFracture_Load(const char* path);
/// @}

/// @name Partial breaks
/// A mesh is split at load time, and its pieces hold together over their bonds until impacts have broken these:
///
///     std::vector<double> strength = qcBondEnergies(fracture, 200);
///     qcImpact impact; // of what hits a piece
///     impact.piece = ..., impact.place = ..., impact.energy = ...;
///     qcBreakBonds(fracture, impact, &strength);
///     for (const qcIsland& island : qcFindIslands(fracture, strength)) { a body for each island ... }
///
/// A body of several pieces is a btCompoundShape with each piece at island.frame.inverse() * piece.frame.
/// Thread-safety: any thread, several at once with different lists of energies, while none changes the body.
/// @{

/// The energy that breaks each bond: its area times `toughness`, the energy for a squared unit of length (Griffith's
/// criterion). Entries may be changed: 0 is a broken bond, infinity one that never breaks. O(bonds).
QC_API std::vector<double> qcBondEnergies(const qcFracture& fracture, double toughness);

/// An impact on a piece, in the mesh's frame.
struct qcImpact
{
    uint32_t piece = 0;             ///< index of the piece that was hit
    btVector3 place{0, 0, 0};       ///< position of the impact
    double energy = 0;              ///< that is there to break bonds
    btScalar reach = SIMD_INFINITY; ///< bonds whose centre is further from the place are not broken
};

/// Breaks bonds of a fracture of qcFracture_Split or qcFracture_Load, in the order of the distance of their centres
/// from the impact, beginning at the piece that was hit and going on over bonds that the impact broke. Each takes its
/// energy. The last one may get less than it needs: it holds, and is weaker from then on. Returns the energy that was
/// taken: 0, and nothing breaks, if the impact names no piece of the fracture, its energy is not positive, or
/// `energies` does not have an entry for each bond. O(broken bonds * log(broken bonds)) plus O(bonds).
QC_API double qcBreakBonds(const qcFracture& fracture, const qcImpact& impact, std::vector<double>* energies);

/// Pieces that hold together.
struct qcIsland
{
    std::vector<uint32_t> pieces; ///< indices, ascending
    /// Centre of mass and principal axes, in the mesh's frame; for a single piece, its frame.
    btTransform frame = btTransform::getIdentity();
    double volume = 0;          ///< in cubed units of length
    btVector3 inertia{0, 0, 0}; ///< for mass 1, along the frame's axes
};

/// The islands of a fracture of qcFracture_Split or qcFracture_Load: pieces connected by bonds of an energy above 0;
/// bonds without an entry are broken. Each piece is in one island; islands are ordered by their first pieces. O(pieces
/// + bonds).
QC_API std::vector<qcIsland> qcFindIslands(const qcFracture& fracture, const std::vector<double>& energies);

/// The motion of an island that breaks off `body`. `frame`: of the body in the mesh's frame, that of the island that it
/// was; identity if the body is the mesh. `density` gives the mass, since a static body has none. If the body has that
/// density, momentum and angular momentum are kept. O(1).
QC_API qcPieceMotion qcMotionOfIsland(const btRigidBody& body, const btTransform& frame, const qcIsland& island,
                                      double density);
/// @}

#endif
