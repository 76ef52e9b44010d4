// Units of length for a fracture.
#include "fracture/unit_scale.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace
{
// Pieces down to 1e-3 of the mesh's length keep all digits of btScalar.
constexpr double s_minLength = double(std::numeric_limits<btScalar>::min() / std::numeric_limits<btScalar>::epsilon());
// Vertices are rotated about a centre, and then lie up to 1.8 lengths from it.
constexpr double s_maxLength = double(std::numeric_limits<btScalar>::max() / 4);
// At a larger distance the difference between a vertex and the origin is exact (Sterbenz: Floating-point computation,
// 1974).
constexpr double s_far = 8;
} // namespace

qcClipPoint qcFractureUnits::Scaled(const btVector3& position) const
{
    double perLength = 1 / length;
    return {double(position.x()) * perLength, double(position.y()) * perLength, double(position.z()) * perLength};
}

qcClipPoint qcFractureUnits::Local(const btVector3& position) const
{
    qcClipPoint scaled = Scaled(position);
    return {scaled[0] - origin[0], scaled[1] - origin[1], scaled[2] - origin[2]};
}

btVector3 qcFractureUnits::Global(const qcClipPoint& local) const
{
    btVector3 position(0, 0, 0);
    for (int i = 0; i < 3; i++)
        position[i] = btScalar((local[size_t(i)] + origin[size_t(i)]) * length);
    return position;
}

double qcFractureUnits::GlobalVolume(double volume) const
{
    return volume * length * length * length;
}

std::string qcFractureUnits_Find(const qcFractureDef& def, qcFractureUnits* units)
{
    double size = -1;
    uint32_t from = 0, to = 0;
    qcClipPoint centre;
    for (int axis = 0; axis < 3; axis++)
    {
        auto isLower = [&](uint32_t a, uint32_t b) { return def.vertices[a][axis] < def.vertices[b][axis]; };
        auto ends = std::minmax_element(def.indices.begin(), def.indices.end(), isLower);
        double lower = double(def.vertices[*ends.first][axis]), upper = double(def.vertices[*ends.second][axis]);
        centre[size_t(axis)] = lower / 2 + upper / 2;
        if (upper - lower > size)
        {
            size = upper - lower;
            from = *ends.first;
            to = *ends.second;
        }
    }
    if (!(size >= s_minLength && size <= s_maxLength))
        return "vertices " + std::to_string(from) + " and " + std::to_string(to) + " are at distance " +
               qcTextOf(size) + " along an axis: the length of the mesh must be " + qcTextOf(s_minLength) + " to " +
               qcTextOf(s_maxLength);
    int exponent;
    std::frexp(size, &exponent);
    units->length = std::ldexp(1, exponent - 1);
    for (size_t i = 0; i < 3; i++)
    {
        double scaled = centre[i] / units->length;
        units->origin[i] = std::fabs(scaled) < s_far ? 0 : std::round(scaled);
    }
    return "";
}

std::string qcTextOf(double number)
{
    char text[32];
    std::snprintf(text, sizeof text, "%g", number);
    return text;
}
