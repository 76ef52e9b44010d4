// A sum over the directed edges of all triangles shows whether the surface is closed: each edge has a number, which its
// opposite has with the opposite sign. Numbers are hashes of 64 bits: a surface with a hole passes for a closed one
// once in 2^64.
#include "scene/closed_surface.h"

#include "base/point_hash.h"
#include "base/vec3.h"

#include <math.h>

// Less volume than this share of the cube over the box's diagonal is rounding: of a sheet with triangles on both sides.
static const double s_noVolume = 1e-12;

static uint64_t HashOf(qcVector p)
{
    return qcPointHash_Of(0, p.x, p.y, p.z);
}

/// The number of the edge from one vertex to another, by their hashes.
static uint64_t EdgeNumber(uint64_t from, uint64_t to)
{
    if (from == to)
        return 0;
    uint64_t number = ((from < to ? from : to) * 0x9e3779b97f4a7c15ULL) ^ (from < to ? to : from);
    number = (number ^ number >> 32) * 0xd6e8feb86659fd93ULL;
    number ^= number >> 32;
    return from < to ? number : 0 - number;
}

static double Determinant(const double m[9])
{
    return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
}

/// Whether the surface is closed and encloses a volume that its normals in local space point out of.
static bool IsClosed(const qcBody* body)
{
    if (body->deforming || body->triangleCount == 0)
        return false;
    qcVector lower = qcVector_Load(body->localLower), diagonal = qcMinus(qcVector_Load(body->localUpper), lower);
    uint64_t boundary = 0;
    double volume = 0.0;
    for (size_t t = 0; t < body->triangleCount; t++)
    {
        qcVector p[3];
        uint64_t hash[3];
        for (size_t c = 0; c < 3; c++)
        {
            p[c] = qcVector_Load(body->local + 3 * (size_t)body->indices[3 * t + c]);
            hash[c] = HashOf(p[c]);
        }
        for (size_t c = 0; c < 3; c++)
            boundary += EdgeNumber(hash[c], hash[(c + 1) % 3]);
        volume += qcDot(qcMinus(p[0], lower), qcCross(qcMinus(p[1], lower), qcMinus(p[2], lower)));
    }
    double size = sqrt(qcDot(diagonal, diagonal));
    return boundary == 0 && volume > s_noVolume * size * size * size;
}

int qcBody_FindOuterSide(qcBody* body)
{
    // Threads that find it at the same time find the same.
    qcSurface surface = __atomic_load_n(&body->surface, __ATOMIC_RELAXED);
    if (surface == qc_surfaceUnknown)
    {
        surface = IsClosed(body) ? qc_surfaceClosed : qc_surfaceOpen;
        __atomic_store_n(&body->surface, surface, __ATOMIC_RELAXED);
    }
    bool isMirrored = !body->isIdentity && Determinant(body->transform.linear) < 0.0;
    return surface == qc_surfaceOpen ? 0 : isMirrored ? -1 : 1;
}
