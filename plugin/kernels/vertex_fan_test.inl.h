// The kernel that looks at the star of a vertex, the closed fan of the triangles around it: do any two features of it
// (vertices, edges, triangles) that have no vertex in common come within the reach r of each other? Most pairs of
// neighbours of a cloth are settled here, a vertex at a time. In single precision.
//
// Project the star on a plane, with the vertex at 0 and p0 .. pk-1 around it. A projection makes nothing longer, so
// what is further apart than r there is so in space. If 0 < angle(p_i, p_i+1) < pi for all i, and all angles together
// turn once, the triangles T_i = (0, p_i, p_i+1) lie in wedges W_i side by side that only meet in their rays R_i, from
// 0 through p_i. Let D(p, q) be the distance of the point p from the ray of q: |p| times the sine of the angle between
// them, or |p| where that is not acute, so it grows with the angle. Asked for is more than r
// - for D(p_i, p_i+1) and D(p_i+1, p_i), and so for D(p_i, p_j) of any j: whichever way round, the ray of p_j comes
//   behind that of p_i's neighbour or is the same;
// - for the distance h_i of 0 from the line through p_i and p_i+1, which is no greater than that from the edge.
// Two triangles that only share 0, T_i and T_j: of features without a common vertex one lies in an edge that faces 0,
// say that of T_i, the other somewhere in W_j, which is none of W_i-1, W_i, W_i+1. The way from one to the other
// crosses R_i-1 or R_i+2. The edge and that ray don't meet, so they are nearest at an end of either: p_i or p_i+1, at
// one of the D, or 0, at h_i. T_i and T_i+1 share p_i+1 too. The way from p_i into W_i+1 crosses R_i+1 or R_i+2: one of
// the D; p_i+2 likewise. What is left is the edge (0, p_i) and the edge (p_i+1, p_i+2), or the other way round, and
// parts of them. They don't meet, so they are nearest at an end: 0 at h_i+1, p_i as before, p_i+1 and p_i+2 at their D
// from R_i.
//
// Rounding. Coordinates are wrong by e; relative to the middle, and then as a sum of three products with a vector of
// length 1, a projected point is off by eta = 5 e + 11 * 2^-24 at most, as coordinates are 1 at most. That the two
// vectors are of length 1 and at right angles only to 2^-20, whatever became of the first on its way, stretches the
// projection by no more than that, which 1.002 r covers. With |p| and |q| as computed a cross or dot product is then
// off by (eta + 2^-22) (|p| + |q|), eta^2 included, lengths by eta: for R = 1.002 r and H = 3 eta + 2^-21, rounded up,
// the kernel asks for cross > R |q| + H (|p| + |q|) and the like. Where p . q <= 0 the ray begins nearest p, and |p|
// |q| stands for the cross product; what the error of p . q may hide there is as small. So each cross product is
// positive, by more than its error, as computed and as it is: on the straight way from the points that are to those
// that were computed the sum of the angles keeps its number of turns, which is counted exactly where y changes its
// sign.
#ifndef QC_KERNELS_VERTEX_FAN_TEST_INL_H
#define QC_KERNELS_VERTEX_FAN_TEST_INL_H

#include "mesh/vertex_fans.h"
#include "kernels/neighbour_pairs.inl.h"

/// Points of a star, projected, and their distances from the middle.
typedef struct FanLanes
{
    Floats x[qc_maxFanSize], y[qc_maxFanSize], length[qc_maxFanSize];
} FanLanes;

/// Seen along the sum of the triangles' normals.
QC_INLINE void ProjectFan(const qcPoint* points, const uint32_t* vertices, uint32_t valence, FanLanes* star)
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
        star->x[i] = Dot(u, p[i]);
        star->y[i] = Dot(v, p[i]);
        star->length[i] = SquareRoot(star->x[i] * star->x[i] + star->y[i] * star->y[i]);
    }
}

/// Are D(p_i, p_k) and D(p_k, p_i) large enough? `cross` is that of the two, `least` their part of the rounding.
QC_INLINE Ints AreOffRays(const FanLanes* star, uint32_t i, uint32_t k, Floats cross, float reach, Floats least)
{
    const Floats zero = {0};
    Floats dot = star->x[i] * star->x[k] + star->y[i] * star->y[k];
    Floats area = Select(dot > zero, cross, star->length[i] * star->length[k]);
    return area > reach * MaxFloats(star->length[i], star->length[k]) + least;
}

QC_INLINE Ints IsFanSeparated(const FanLanes* star, uint32_t valence, float reach, float error)
{
    const Floats zero = {0};
    Ints quiet = (Ints)zero == 0, turns = {0};
    for (uint32_t i = 0; i < valence; i++)
    {
        uint32_t next = i + 1 < valence ? i + 1 : 0;
        Floats least = error * (star->length[i] + star->length[next]);
        Floats cross = star->x[i] * star->y[next] - star->y[i] * star->x[next];
        Floats x = star->x[next] - star->x[i], y = star->y[next] - star->y[i];
        quiet &= cross > reach * SquareRoot(x * x + y * y) + least;
        quiet &= AreOffRays(star, i, next, cross, reach, least);
        turns += (star->y[i] < zero) & (star->y[next] >= zero);
    }
    return quiet & (turns == -1);
}

static uint32_t FindSeparatedFans(const qcPoint* points, const uint32_t* vertices, uint32_t valence,
                                  const qcDistanceThresholds* bound)
{
    float error = 16.0f * bound->pointError + 48.0f * 0x1p-24f, reach = 1.002f * bound->query + 0x1p-24f;
    uint32_t quiet = 0;
    for (uint32_t lane = 0; lane < qc_fanLanes; lane += QC_LANES)
    {
        FanLanes star;
        ProjectFan(points, vertices + lane, valence, &star);
        quiet |= SignBits(IsFanSeparated(&star, valence, reach, error)) << lane;
    }
    return quiet;
}

#endif
