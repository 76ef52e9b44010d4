// The kernel that finds which corners and faces, and which edges, of two triangles may be within a margin, in single
// precision: only these are tested in double (narrowphase/feature_contacts.c).
// Proof: plugin/docs/proofs/feature_distance.md.
#ifndef QC_KERNELS_FEATURE_DISTANCE_INL_H
#define QC_KERNELS_FEATURE_DISTANCE_INL_H

#include "kernels/triangle_distance.inl.h"

// More than twice the error of s, t and D.
#define QC_OUTSIDE 0x1p-6f

/// QC_LANES triangles: corners, edges from each to the next, and the axes for corners of the other triangle: outward
/// normals of the edges, then the face's normal in both directions.
typedef struct FacetLanes
{
    Vectors corner[3], edge[3], axis[5];
    Floats edge2[3];
    Floats limit[5]; ///< a corner farther along the axis is farther away than the margin
} FacetLanes;

QC_INLINE Floats FindLimit(const Vectors corner[3], Vectors w, Floats margin)
{
    const Floats zero = {0};
    Floats largest = MaxFloats(Dot(w, corner[0]), MaxFloats(Dot(w, corner[1]), Dot(w, corner[2])));
    Floats gap = 1.0001f * margin * SquareRoot(Dot(w, w)) + SumOfAbsolutes(w) * 4e-6f;
    // Below 1e-15 squares may have underflowed.
    return Select(gap > 1e-15f, largest + gap, zero + INFINITY);
}

QC_INLINE FacetLanes MakeFacets(Vectors p, Vectors q, Vectors r, Floats margin)
{
    FacetLanes f = {.corner = {p, q, r}};
    for (int i = 0; i < 3; i++)
    {
        f.edge[i] = Subtract(f.corner[(i + 1) % 3], f.corner[i]);
        f.edge2[i] = Dot(f.edge[i], f.edge[i]);
    }
    Vectors normal = Cross(f.edge[0], f.edge[1]);
    f.axis[3] = normal;
    f.axis[4] = (Vectors){-normal.x, -normal.y, -normal.z};
    for (int i = 0; i < 3; i++)
        f.axis[i] = Cross(f.edge[i], normal);
    for (int i = 0; i < 5; i++)
        f.limit[i] = FindLimit(f.corner, f.axis[i], margin);
    return f;
}

QC_INLINE Ints IsCornerFar(Vectors x, const FacetLanes* face)
{
    Ints far = {0};
    for (int i = 0; i < 5; i++)
        far |= Dot(face->axis[i], x) > face->limit[i];
    return far;
}

QC_INLINE Ints AreEdgesFar(const FacetLanes* a, int i, const FacetLanes* b, int k, Floats margin)
{
    Vectors p = a->corner[i], along = a->edge[i], q = b->corner[k], across = b->edge[k], r = Subtract(p, q);
    Floats ab = Dot(along, across), ar = Dot(along, r), br = Dot(across, r);
    Floats d = a->edge2[i] * b->edge2[k] - ab * ab + QC_OUTSIDE;
    Floats s = ab * br - ar * b->edge2[k], t = a->edge2[i] * br - ab * ar;
    Ints outside = (s < -QC_OUTSIDE) | (s > d) | (t < -QC_OUTSIDE) | (t > d);
    Vectors w = Cross(along, across);
    Floats p0 = Dot(w, p), p1 = Dot(w, a->corner[(i + 1) % 3]), q0 = Dot(w, q), q1 = Dot(w, b->corner[(k + 1) % 3]);
    Floats above = MinFloats(p0, p1) - MaxFloats(q0, q1), below = MinFloats(q0, q1) - MaxFloats(p0, p1);
    Floats gap = MaxFloats(above, below) - SumOfAbsolutes(w) * 4e-6f;
    const Floats zero = {0};
    return outside | ((gap > zero) & IsGapAbove(gap, margin, Dot(w, w)));
}

QC_INLINE Vectors LoadCorners(const qcFeaturePairs* pairs, int corner, int at)
{
    Vectors v;
    memcpy(&v.x, pairs->corner[corner][0] + at, sizeof v.x);
    memcpy(&v.y, pairs->corner[corner][1] + at, sizeof v.y);
    memcpy(&v.z, pairs->corner[corner][2] + at, sizeof v.z);
    return v;
}

static void FindNearFeatures(const qcFeaturePairs* pairs, qcFeatureMask near[qc_featurePairs])
{
    const Floats zero = {0};
    for (int at = 0; at < qc_featurePairs; at += QC_LANES)
    {
        Vectors v[5];
        Floats size = zero, margin;
        memcpy(&margin, pairs->margin + at, sizeof margin);
        for (int c = 0; c < 5; c++)
        {
            v[c] = LoadCorners(pairs, c, at);
            size = MaxFloats(size, MaxAbsolute(v[c]));
        }
        // Like in LoadPairs; coordinates that are too large are not scaled.
        Floats scale = (Floats)((0x7f000000 - ((Ints)size & 0x7f800000)) & (size < 1e38f));
        for (int c = 0; c < 5; c++)
            v[c] = Times(v[c], scale);
        margin *= scale;
        FacetLanes a = MakeFacets((Vectors){zero, zero, zero}, v[0], v[1], margin),
                   b = MakeFacets(v[2], v[3], v[4], margin);
        Ints far = {0};
        for (int i = 0; i < 3; i++)
        {
            const int32_t ofA = 1 << i, ofB = 1 << (qc_nearCornersOfB + i);
            far |= IsCornerFar(a.corner[i], &b) & ofA;
            far |= IsCornerFar(b.corner[i], &a) & ofB;
            for (int k = 0; k < 3; k++)
            {
                const int32_t ofEdges = 1 << (qc_nearEdges + 3 * i + k);
                far |= AreEdgesFar(&a, i, &b, k, margin) & ofEdges;
            }
        }
        for (int lane = 0; lane < QC_LANES; lane++)
            near[at + lane] = (qcFeatureMask)(~far[lane] & 0x7fff);
    }
}

#endif
