// Breaks a closed triangle mesh into pieces: its parts in the cells of a Voronoi diagram, cut faces included. Link
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
    /// The points that are nearer to one of them than to any other are its cell. They may lie anywhere.
    std::vector<btVector3> sites;
};

/// A closed mesh in one part.
struct qcPiece
{
    /// In the piece's frame. Rounded to btScalar once: they fit those of the pieces around.
    std::vector<btVector3> vertices;
    std::vector<uint32_t> indices;
    uint32_t firstCutTriangle = 0; ///< from here on triangles lie in cuts
    uint32_t site = 0;             ///< of its cell: a cell may hold several pieces
    /// The centre of mass and the principal axes, in the mesh's frame: a btRigidBody's tensor is diagonal in its frame.
    /// The centre is rounded to btScalar: of a mesh at 1e6, in float, it is off by up to 0.03.
    btTransform frame = btTransform::getIdentity();
    double volume = 0; ///< the mesh's unit of length cubed; a btScalar may not hold it
};

struct qcFracture
{
    qcStatus status = qc_statusOk;
    std::string message; ///< the defect of the input, and its place
    std::vector<qcPiece> pieces;
    double volume = 0;     ///< of the mesh
    double lostVolume = 0; ///< of splinters, below 1e-9 of the mesh's volume each, which are dropped
};

/// Splits a mesh. The same input gives the same pieces; input scaled by a power of two gives the pieces scaled, bit by
/// bit. Triangles back to back, with nothing between them, are dropped. Pieces and splinters together have the mesh's
/// volume, within 1e-12 of it and 1e-14 of the cube of its length.
///
/// qc_statusBadInput, and no pieces:
/// - an index is out of range, a vertex or site is not finite, two sites are at the same place, there is no site;
/// - the mesh is not closed (each edge has to be passed as often one way as the other) or is inside out;
/// - the mesh is too thin: its volume is below 1e-12 of the cube of its length, where rounding errors hide overlaps;
/// - the mesh is shorter than 1e-31 or longer than 8e37 (in double: its volume is not from 1e-298 to 1e308);
/// - in double, the nearest site is further from the mesh than 1e144 times its length.
///
/// About O(triangles * log(cells)). Where two sites are closer than 1e-6 of the mesh's length, or all are further away
/// than 64 lengths, O(cells * (triangles + cells)).
///
/// Thread-safety: any thread may call it, several at once. Its loops run where the library's do: on the threads of
/// qcSetParallelFor or qcSetTaskScheduler, else on the library's own. Pieces don't depend on the number of threads.
QC_API qcFracture qcFracture_Split(const qcFractureDef& def);

/// Sites within a box, the same for the same seed; around a point, if one is given, the denser the nearer to it.
QC_API std::vector<btVector3> qcScatterSites(const btVector3& lower, const btVector3& upper, uint32_t count,
                                             uint64_t seed, const btVector3* impact = nullptr);

/// How a piece flies on when the body that it was part of is replaced: momentum and angular momentum are kept.
struct qcPieceMotion
{
    btScalar mass;         ///< 0 only if the body is static: at least the smallest normal btScalar otherwise
    btTransform transform; ///< of a body whose shape is the piece's vertices
    btVector3 linearVelocity, angularVelocity;
};

/// `fracture` is of the body's mesh in the body's frame, whose origin is its centre of mass.
QC_API qcPieceMotion qcMotionOfPiece(const btRigidBody& body, const qcFracture& fracture, const qcPiece& piece);

#endif
