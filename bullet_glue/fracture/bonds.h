// Bonds of a fracture: which pieces share cut faces, and how large these are.
#ifndef QC_GLUE_FRACTURE_BONDS_H
#define QC_GLUE_FRACTURE_BONDS_H

#include "fracture/unit_scale.h"

/// A triangle of a piece in the cut between its cell and another one, in local positions.
struct qcCutTriangle
{
    uint32_t otherCell;
    std::array<qcClipPoint, 3> corner;
};

/// The cuts of a piece.
struct qcPieceCuts
{
    uint32_t cell;
    std::vector<qcCutTriangle> triangles;
};

/// The bonds between pieces, ordered by the two pieces. Where one side of a cut has a single face, and both sides have
/// the same area, each face of the other side counts as a whole; otherwise the overlap of faces is computed. Areas
/// that are narrower than `rounding`, that of the mesh's corners in units, have no bond. About
/// O(cut triangles * log(cut triangles)).
std::vector<qcBond> qcFindBonds(const std::vector<qcPieceCuts>& pieces, const qcFractureUnits& units, double rounding);

#endif
