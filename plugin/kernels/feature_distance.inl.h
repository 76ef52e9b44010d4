// The kernel that tells which corners and faces, and which edges, of two triangles may come within a margin: contacts
// are looked for in double (narrowphase/feature_contacts.c) only there. In single precision.
//
// Where projections of two features on a direction w leave a gap, they are apart by the gap over |w|. For a corner and
// a face w is across the face, or in its plane and across an edge; for two edges across both. Two edges meet only
// where points inside both are the closest. These are the closest ones of their lines then: at s / D along the one and
// t / D along the other, with D = |a|^2 |b|^2 - (a . b)^2 for edges a and b. So s or t outside 0 .. D will do, too.
//
// Rounding. Coordinates are those of the filter (kernels/separating_axis.inl.h) with no error but that of being rounded
// to float once: by 2^-24 of themselves or, below 2^-126, by 2^-149, which scaled by 2^127 is 2^-22. So a gap is wrong
// by |w|_1 2.9e-6 at most, and the margin, scaled, by 2^-22 besides what is relative. Edges, and what is between them,
// are below 4 in each coordinate and wrong by 3 * 2^-22: a dot product is wrong by 108 * 2^-22, and s, t and D, made of
// two products of two such below 48 each, by 5.5e-3. Double arithmetic rounds by so much less that it comes to the same
// end. What is too large for floats is not scaled: there nothing is told.
#ifndef QC_KERNELS_FEATURE_DISTANCE_INL_H
#define QC_KERNELS_FEATURE_DISTANCE_INL_H

#include "kernels/triangle_distance.inl.h"

// Twice what s or t and D are wrong by, and more.
#define QC_OUTSIDE 0x1p-6f

/// QC_LANES triangles: corners, edges from each to the next, and what a corner of the other is looked at along: the
/// normal, both ways, and away from the edges.
typedef struct FacetLanes
{
    Vectors corner[3], edge[3], across[5];
    Floats edge2[3];
    Floats beyond[5]; ///< what is farther along is farther than the margin
} FacetLanes;

QC_INLINE Floats FindLimit(const Vectors corner[3], Vectors w, Floats margin)
{
    const Floats zero = {0};
    Floats most = MaxFloats(Dot(w, corner[0]), MaxFloats(Dot(w, corner[1]), Dot(w, corner[2])));
    Floats gap = 1.0001f * margin * SquareRoot(Dot(w, w)) + SumOfAbsolutes(w) * 4e-6f;
    // Below 1e-15 squares may have vanished.
    return Select(gap > 1e-15f, most + gap, zero + INFINITY);
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
    f.across[3] = normal;
    f.across[4] = (Vectors){-normal.x, -normal.y, -normal.z};
    for (int i = 0; i < 3; i++)
        f.across[i] = Cross(f.edge[i], normal);
    for (int i = 0; i < 5; i++)
        f.beyond[i] = FindLimit(f.corner, f.across[i], margin);
    return f;
}

QC_INLINE Ints IsCornerFar(Vectors x, const FacetLanes* face)
{
    Ints far = {0};
    for (int i = 0; i < 5; i++)
        far |= Dot(face->across[i], x) > face->beyond[i];
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
        // As in LoadLanes.
        Floats up = (Floats)((0x7f000000 - ((Ints)size & 0x7f800000)) & (size < 1e38f));
        for (int c = 0; c < 5; c++)
            v[c] = Times(v[c], up);
        margin *= up;
        FacetLanes a = MakeFacets((Vectors){zero, zero, zero}, v[0], v[1], margin),
                   b = MakeFacets(v[2], v[3], v[4], margin);
        Ints far = {0};
        for (int i = 0; i < 3; i++)
        {
            far |= IsCornerFar(a.corner[i], &b) & (1 << i);
            far |= IsCornerFar(b.corner[i], &a) & (1 << (qc_nearCornersOfB + i));
            for (int k = 0; k < 3; k++)
                far |= AreEdgesFar(&a, i, &b, k, margin) & (1 << (qc_nearEdges + 3 * i + k));
        }
        for (int lane = 0; lane < QC_LANES; lane++)
            near[at + lane] = (qcFeatureMask)(~far[lane] & 0x7fff);
    }
}

#endif
