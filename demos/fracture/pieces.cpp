// Pieces cut, saved and loaded.
#include "fracture/pieces.h"

#include <algorithm>

bool qcLoadPieces(const char* path, size_t triangleCount, qcFracture* fracture, std::string* message)
{
    *fracture = qcFracture_Load(path);
    *message = fracture->message;
    if (fracture->status == qc_statusOk && fracture->triangleCount != triangleCount)
        *message = std::string(path) + " has the pieces of a mesh of " + std::to_string(fracture->triangleCount) +
                   " triangles, not of " + std::to_string(triangleCount) +
                   ": give the --mesh and --triangles that it was made with";
    return message->empty();
}

qcFracture qcSplitAndSave(const qcFractureDef& def, const char* path)
{
    qcFracture fracture = qcFracture_Split(def);
    if (path == nullptr || fracture.status != qc_statusOk)
        return fracture;
    std::string message;
    fracture.status = qcFracture_Save(fracture, path, &message);
    fracture.message = message;
    return fracture;
}

std::vector<uint32_t> qcCutNumbers(const qcPiece& piece)
{
    std::vector<uint32_t> numbers;
    for (size_t t = piece.firstCutTriangle; t < piece.sources.size(); t++)
        numbers.push_back(std::min(piece.site, piece.sources[t]) * 7919 + std::max(piece.site, piece.sources[t]));
    return numbers;
}
