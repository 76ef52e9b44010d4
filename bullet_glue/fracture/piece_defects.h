// The first defect of a fracture that is saved or loaded, or an empty text.
#ifndef QC_GLUE_FRACTURE_PIECE_DEFECTS_H
#define QC_GLUE_FRACTURE_PIECE_DEFECTS_H

#include "quickcullide/bullet_fracture.h"

#include <string>

std::string qcFindPieceDefect(const qcPiece& piece, const qcFracture& fracture);
std::string qcFindBondDefect(const qcBond& bond, const qcFracture& fracture);
/// That of the whole fracture, its pieces and its bonds.
std::string qcFindDefect(const qcFracture& fracture);

#endif
