// The first defect of a fracture that is saved or loaded.
#include "fracture/piece_defects.h"

#include "common/finite.h"

#include <cmath>

std::string qcFindPieceDefect(const qcPiece& piece, const qcFracture& fracture)
{
    size_t triangles = piece.sources.size();
    if (piece.indices.size() != 3 * triangles)
        return std::to_string(piece.indices.size()) + " indices for " + std::to_string(triangles) + " sources";
    if (piece.firstCutTriangle > triangles)
        return "the first triangle in a cut is " + std::to_string(piece.firstCutTriangle) + " of " +
               std::to_string(triangles);
    if (piece.site >= fracture.siteCount)
        return "its site is " + std::to_string(piece.site) + " of " + std::to_string(fracture.siteCount);
    for (size_t i = 0; i < piece.vertices.size(); i++)
        if (!qcIsFinite(piece.vertices[i]))
            return "vertex " + std::to_string(i) + " is not finite";
    for (size_t i = 0; i < piece.indices.size(); i++)
        if (piece.indices[i] >= piece.vertices.size())
            return "index " + std::to_string(i) + " is " + std::to_string(piece.indices[i]) + " of " +
                   std::to_string(piece.vertices.size()) + " vertices";
    for (size_t t = 0; t < triangles; t++)
    {
        bool isCut = t >= piece.firstCutTriangle;
        uint32_t count = isCut ? fracture.siteCount : fracture.triangleCount;
        if (piece.sources[t] >= count && !(isCut && piece.sources[t] == UINT32_MAX))
            return "the source of triangle " + std::to_string(t) + " is " + std::to_string(piece.sources[t]) + " of " +
                   std::to_string(count);
    }
    if (!std::isfinite(piece.volume) || !qcIsFinite(piece.inertia) || !qcIsFinite(piece.frame))
        return "its volume, its inertia or its frame is not finite";
    if (!(piece.volume > 0))
        return "its volume is not positive";
    return "";
}

std::string qcFindBondDefect(const qcBond& bond, const qcFracture& fracture)
{
    if (bond.pieceA >= bond.pieceB || bond.pieceB >= fracture.pieces.size())
        return "it joins pieces " + std::to_string(bond.pieceA) + " and " + std::to_string(bond.pieceB) + " of " +
               std::to_string(fracture.pieces.size());
    if (!(bond.area >= 0) || !std::isfinite(bond.area) || !qcIsFinite(bond.center) || !qcIsFinite(bond.normal))
        return "its area, its centre or its normal is not finite";
    return "";
}

std::string qcFindDefect(const qcFracture& fracture)
{
    if (fracture.status != qc_statusOk)
        return "its status is " + std::string(qcStatus_Name(fracture.status));
    if (fracture.siteCount == 0)
        return "it has no sites";
    if (!std::isfinite(fracture.volume) || !std::isfinite(fracture.lostVolume))
        return "its volume is not finite";
    for (size_t i = 0; i < fracture.pieces.size(); i++)
    {
        std::string defect = qcFindPieceDefect(fracture.pieces[i], fracture);
        if (!defect.empty())
            return "piece " + std::to_string(i) + ": " + defect;
    }
    for (size_t i = 0; i < fracture.bonds.size(); i++)
    {
        std::string defect = qcFindBondDefect(fracture.bonds[i], fracture);
        if (!defect.empty())
            return "bond " + std::to_string(i) + ": " + defect;
    }
    return "";
}
