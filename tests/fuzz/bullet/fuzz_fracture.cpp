// Fractures: meshes that are bent, cut by sites that lie on vertices, in planes and far away, at any scale. Pieces are
// closed, their volumes are those that are reported and add up to the mesh's; meshes that are not closed are refused.
#include "bullet/fracture/fracture_models.h"
#include "fuzz/fuzz.h"

#include <cfloat>

namespace
{
// The tolerance of the tests of scales, for coordinates of this type.
constexpr double s_rounding = sizeof(btScalar) == 4 ? 4e-6 : 1e-14;

enum
{
    qc_maxSites = 12
};

/// Multiples of a quarter mostly, so that cuts go through vertices and along faces.
btScalar TakeCoordinate(FuzzBytes* bytes)
{
    uint8_t way = Fuzz_TakeByte(bytes);
    if (way < 240)
        return btScalar(way % 17 - 8) / 4;
    return btScalar(int16_t(uint16_t(Fuzz_TakeBits(bytes, 2)))) / 8192;
}

btVector3 TakePoint(FuzzBytes* bytes)
{
    btScalar x = TakeCoordinate(bytes), y = TakeCoordinate(bytes);
    return btVector3(x, y, TakeCoordinate(bytes));
}

qcFractureDef TakeMesh(FuzzBytes* bytes)
{
    switch (Fuzz_TakeBelow(bytes, 4))
    {
        case 0: return qcTorusToBreak(3 + int(Fuzz_TakeBelow(bytes, 5)), 3 + int(Fuzz_TakeBelow(bytes, 4)), 1, 0.5);
        case 1: return qcHollowToBreak();
        default: return qcBoxToBreak(1, 1, 0.25 * (1 + Fuzz_TakeBelow(bytes, 8)));
    }
}

/// False: an index or a number that no mesh has.
bool Spoil(FuzzBytes* bytes, qcFractureDef* def)
{
    uint8_t way = Fuzz_TakeByte(bytes);
    size_t at = way % def->indices.size();
    switch (way)
    {
        case 255: def->indices[at] = uint32_t(def->vertices.size()); return false;
        case 254: def->vertices[0].setX(btScalar(NAN)); return false;
        case 253: def->sites[0].setY(SIMD_INFINITY * 2); return false;
        case 252: def->indices.pop_back(); return false;
        case 251: def->indices.resize(def->indices.size() - 3); return false;
        default: return true;
    }
}

double ScaleOf(FuzzBytes* bytes)
{
    static const int exponents[] = {0, 0, 0, 0, 0, 0, 1, -1, 10, -10, 30, -30, 60, -60, 99, -99};
    return std::ldexp(1.0, exponents[Fuzz_TakeBelow(bytes, 16)]);
}

std::vector<btVector3> Unscaled(const std::vector<btVector3>& vertices, double scale)
{
    std::vector<btVector3> result;
    for (const btVector3& v : vertices)
        result.emplace_back(btScalar(double(v.x()) / scale), btScalar(double(v.y()) / scale),
                            btScalar(double(v.z()) / scale));
    return result;
}

/// `bent`: the mesh may meet itself, and parts of it are then inside out. They are lost, and the pieces hold more.
void CheckPieces(const qcFractureDef& def, const qcFracture& fracture, double scale, bool bent)
{
    double sum = 0, cube = scale * scale * scale, whole = qcVolumeOf(Unscaled(def.vertices, scale), def.indices);
    for (const qcPiece& piece : fracture.pieces)
    {
        FUZZ_CHECK(qcIsClosed(piece));
        FUZZ_CHECK(piece.volume > 0 && piece.site < def.sites.size());
        FUZZ_CHECK(piece.sources.size() == piece.indices.size() / 3);
        double volume = qcVolumeOf(Unscaled(piece.vertices, scale), piece.indices);
        FUZZ_CHECK(std::fabs(volume - piece.volume / cube) <= 60 * s_rounding);
        sum += piece.volume / cube;
    }
    double lost = fracture.lostVolume / cube, rounding = 8 * s_rounding * (1 + std::fabs(whole));
    FUZZ_CHECK(std::fabs(sum - whole) <= lost + rounding);
    FUZZ_CHECK(bent || (lost <= 1e-6 * whole && std::fabs(sum + lost - whole) <= rounding));
    for (const qcBond& bond : fracture.bonds)
        FUZZ_CHECK(bond.pieceA < bond.pieceB && bond.pieceB < fracture.pieces.size() && bond.area > 0);
}
} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    FuzzBytes bytes = {data, size};
    qcFractureDef def = TakeMesh(&bytes);
    for (uint32_t count = 1 + Fuzz_TakeBelow(&bytes, qc_maxSites); count > 0; count--)
        def.sites.push_back(TakePoint(&bytes));
    // Vertices that move bend the mesh and may make it meet itself, which is allowed: it stays closed.
    bool bent = Fuzz_TakeBelow(&bytes, 2) == 1;
    for (uint32_t count = bent ? Fuzz_TakeBelow(&bytes, 4) : 0; count > 0; count--)
        def.vertices[Fuzz_TakeByte(&bytes) % def.vertices.size()] += TakePoint(&bytes) / 16;
    double scale = ScaleOf(&bytes);
    for (std::vector<btVector3>* points : {&def.vertices, &def.sites})
        for (btVector3& point : *points)
            point *= btScalar(scale);
    bool isGood = Spoil(&bytes, &def);
    qcFracture fracture = qcFracture_Split(def);
    FUZZ_CHECK(fracture.status == qc_statusOk || fracture.status == qc_statusBadInput);
    FUZZ_CHECK((fracture.status == qc_statusOk) == !fracture.pieces.empty());
    if (fracture.status == qc_statusOk)
    {
        FUZZ_CHECK(isGood);
        CheckPieces(def, fracture, scale, bent);
    }
    else
        FUZZ_CHECK(!fracture.message.empty());
    // A mesh that was neither bent nor spoiled, with sites of which no two are at one place, has pieces.
    bool haveTwins = false;
    for (size_t i = 0; i < def.sites.size(); i++)
        for (size_t k = 0; k < i; k++)
            haveTwins |= def.sites[i] == def.sites[k];
    FUZZ_CHECK(fracture.status == qc_statusOk || !isGood || bent || haveTwins);
    return 0;
}
