// Contacts: features of two triangles that come within a margin.
#ifndef QC_NARROWPHASE_FEATURE_CONTACTS_H
#define QC_NARROWPHASE_FEATURE_CONTACTS_H

#include "kernels/triangle_kernels.h"
#include "narrowphase/local_minimum.h"

enum
{
    /// Three corners against a face both ways, three edges against three.
    qc_maxContactsPerPair = 15
};

/// One triangle of a body, named by its slot.
typedef struct qcContactSide
{
    const qcBody* body; ///< with owners
    uint32_t slot, triangle;
    /// Of a rigid body, whose points count only where none around is nearer; otherwise null.
    const qcLocalMinima* surroundings;
} qcContactSide;

/// A triangle with what is asked of it at hand: neighbours in a list of pairs mostly have one in common. All zero: of
/// none yet.
typedef struct qcContactFacet
{
    qcContactSide side;
    const uint32_t* index;
    qcVector corner[3];
    qcVector over[3];        ///< beyond each edge, of those in hasOver
    unsigned asked, hasOver; ///< bits of edges
} qcContactFacet;

void qcContactFacet_Set(qcContactFacet* facet, const qcContactSide* side);

/// Two triangles whose contacts within a margin are wanted.
typedef struct qcContactPair
{
    qcContactSide a, b;
    double margin;
} qcContactPair;

/// Which features that the triangles stand for may have contacts. For 1 to qc_featurePairs pairs.
void qcContact_FindNear(const qcTriangleKernels* kernels, const qcContactPair* pairs, size_t count,
                        qcFeatureMask near[qc_featurePairs]);

/// Writes the contacts between these features; returns their number. The facets are those of the pair.
int qcContact_Find(qcContactFacet* a, qcContactFacet* b, double margin, qcFeatureMask near, qcContact* contacts);

#endif
