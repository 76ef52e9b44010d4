// The kernel that proves vertex fans separated, in single precision: no two features of the fan (vertices, edges,
// faces) without a common vertex are within the query distance. This settles most neighbours of a cloth, a vertex at a
// time. Proof: plugin/docs/proofs/vertex_fan_test.md.
#ifndef QC_KERNELS_VERTEX_FAN_TEST_INL_H
#define QC_KERNELS_VERTEX_FAN_TEST_INL_H

#include "mesh/vertex_fans.h"
#include "kernels/neighbour_pairs.inl.h"

/// The ring of a fan, projected, and its distances from the centre.
typedef struct FanLanes
{
    Floats x[qc_maxFanSize], y[qc_maxFanSize], length[qc_maxFanSize];
} FanLanes;

/// Projects along the sum of the triangles' normals.
QC_INLINE void ProjectFan(const qcPoint* points, const uint32_t* vertices, uint32_t valence, FanLanes* fan)
{
    const Floats zero = {0};
    Vectors at = LoadPoints(points, vertices), p[qc_maxFanSize], normal = {zero, zero, zero};
    for (uint32_t i = 0; i < valence; i++)
        p[i] = Subtract(LoadPoints(points, vertices + qc_fanLanes * (1 + i)), at);
    for (uint32_t i = 0; i < valence; i++)
    {
        Vectors n = Cross(p[i], p[i + 1 < valence ? i + 1 : 0]);
        normal = (Vectors){normal.x + n.x, normal.y + n.y, normal.z + n.z};
    }
    normal = Normalize(normal);
    Vectors u = Normalize(AddScaled(p[0], normal, -Dot(normal, p[0]))), v = Cross(normal, u);
    for (uint32_t i = 0; i < valence; i++)
    {
        fan->x[i] = Dot(u, p[i]);
        fan->y[i] = Dot(v, p[i]);
        fan->length[i] = SquareRoot(fan->x[i] * fan->x[i] + fan->y[i] * fan->y[i]);
    }
}

/// Points i and k of the ring are farther from each other's ray than the query distance. `cross`: their cross product;
/// `rounding`: the largest error of it.
QC_INLINE Ints AreOffRays(const FanLanes* fan, uint32_t i, uint32_t k, Floats cross, float query, Floats rounding)
{
    const Floats zero = {0};
    Floats dot = fan->x[i] * fan->x[k] + fan->y[i] * fan->y[k];
    Floats area = Select(dot > zero, cross, fan->length[i] * fan->length[k]);
    return area > query * MaxFloats(fan->length[i], fan->length[k]) + rounding;
}

QC_INLINE Ints IsFanSeparated(const FanLanes* fan, uint32_t valence, float query, float error)
{
    const Floats zero = {0};
    Ints separated = (Ints)zero == 0, turns = {0};
    for (uint32_t i = 0; i < valence; i++)
    {
        uint32_t next = i + 1 < valence ? i + 1 : 0;
        Floats rounding = error * (fan->length[i] + fan->length[next]);
        Floats cross = fan->x[i] * fan->y[next] - fan->y[i] * fan->x[next];
        Floats x = fan->x[next] - fan->x[i], y = fan->y[next] - fan->y[i];
        separated &= cross > query * SquareRoot(x * x + y * y) + rounding;
        separated &= AreOffRays(fan, i, next, cross, query, rounding);
        turns += (fan->y[i] < zero) & (fan->y[next] >= zero);
    }
    return separated & (turns == -1);
}

static uint32_t FindSeparatedFans(const qcPoint* points, const uint32_t* vertices, uint32_t valence,
                                  const qcDistanceThresholds* thresholds)
{
    float error = 16.0f * thresholds->pointError + 48.0f * 0x1p-24f, query = 1.002f * thresholds->query + 0x1p-24f;
    uint32_t separated = 0;
    for (uint32_t lane = 0; lane < qc_fanLanes; lane += QC_LANES)
    {
        FanLanes fan;
        ProjectFan(points, vertices + lane, valence, &fan);
        separated |= SignBits(IsFanSeparated(&fan, valence, query, error)) << lane;
    }
    return separated;
}

#endif
