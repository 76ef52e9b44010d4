// Breaks a closed triangle mesh into pieces: what each cell of a Voronoi diagram holds of it, cut faces included. Link
// quickcullide::fracture (or fracture_double), which is built where voro++ and GLU are installed.
//
//     qcFractureDef def;
//     def.vertices = ..., def.indices = ...;
//     def.sites = qcScatterSites(lower, upper, 100, 1, &impact);
//     qcFracture fracture = qcFracture_Split(def);
//     for (const qcPiece& piece : fracture.pieces) { a qcMeshShape over piece.vertices and piece.indices ... }
#ifndef QUICKCULLIDE_BULLET_FRACTURE_H
#define QUICKCULLIDE_BULLET_FRACTURE_H

#include "base.h"

#include <LinearMath/btTransform.h>

#include <cstdint>
#include <string>
#include <vector>

class btRigidBody;

struct qcFractureDef
{
    /// Positions in the mesh's frame. Vertices at the same position count as one.
    std::vector<btVector3> vertices;
    /// Three a triangle, counterclockwise as seen from outside.
    std::vector<uint32_t> indices;
    /// One cell each, of what is nearer to it than to any other.
    std::vector<btVector3> sites;
};

/// A closed mesh in one part.
struct qcPiece
{
    std::vector<btVector3> vertices; ///< in the piece's frame
    std::vector<uint32_t> indices;
    uint32_t firstCutTriangle = 0; ///< from here on triangles lie in cuts
    uint32_t site = 0;             ///< of its cell: a cell may hold several pieces
    /// The centre of mass and the principal axes, in the mesh's frame: a btRigidBody's tensor is diagonal in its frame.
    btTransform frame = btTransform::getIdentity();
    btScalar volume = 0;
};

struct qcFracture
{
    qcStatus status = qc_statusOk;
    std::string message; ///< what was wrong, and where
    std::vector<qcPiece> pieces;
    btScalar volume = 0;     ///< of the mesh
    btScalar lostVolume = 0; ///< of splinters too thin to have a volume to speak of (below 1e-9 of the mesh's)
};

/// Splits a mesh. qc_statusBadInput, and no pieces: an index is out of range, a position not finite, two sites are at
/// the same place, there is no site, the mesh is not closed (each edge has to be passed as often one way as the other)
/// or is inside out. Triangles back to back, with nothing between them, are dropped. The same input gives the same
/// pieces. About O(triangles * log(cells)).
QC_API qcFracture qcFracture_Split(const qcFractureDef& def);

/// Sites within a box, the same for the same seed; around a point, if one is given, the denser the nearer to it.
QC_API std::vector<btVector3> qcScatterSites(const btVector3& lower, const btVector3& upper, uint32_t count,
                                             uint64_t seed, const btVector3* impact = nullptr);

/// How a piece flies on when the body that it was part of is replaced: momentum and angular momentum are kept.
struct qcPieceMotion
{
    btScalar mass;
    btTransform transform; ///< of a body whose shape is the piece's vertices
    btVector3 linearVelocity, angularVelocity;
};

/// `fracture` is of the body's mesh in the body's frame, whose origin is its centre of mass.
QC_API qcPieceMotion qcMotionOfPiece(const btRigidBody& body, const qcFracture& fracture, const qcPiece& piece);

#endif
