// The pieces of the demo: cut, or from a file.
#ifndef QC_DEMOS_FRACTURE_PIECES_H
#define QC_DEMOS_FRACTURE_PIECES_H

#include "quickcullide/bullet_fracture.h"

/// Reads pieces of a mesh of so many triangles. False with a message: the file can't be read, or is of another mesh.
bool qcLoadPieces(const char* path, size_t triangleCount, qcFracture* fracture, std::string* message);

/// Splits a mesh and saves its pieces; `path` may be null. A failure is in the result's message.
qcFracture qcSplitAndSave(const qcFractureDef& def, const char* path);

/// A number for each triangle in a cut of a piece: the same for the pieces on both sides of the cut.
std::vector<uint32_t> qcCutNumbers(const qcPiece& piece);

#endif
