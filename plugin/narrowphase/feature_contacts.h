// Contacts: features of two triangles (vertex and face, edge and edge) within a margin of each other.
#ifndef QC_NARROWPHASE_FEATURE_CONTACTS_H
#define QC_NARROWPHASE_FEATURE_CONTACTS_H

#include "kernels/triangle_kernels.h"
#include "narrowphase/local_minimum.h"

enum
{
    /// Three corners against a face both ways, three edges against three.
    qc_maxContactsPerPair = 15
};

/// One triangle of a body, and the body's slot.
typedef struct qcContactSide
{
    const qcBody* body; ///< with feature owners
    uint32_t slot, triangle;
    const qcLocalMinima* localMinima; ///< the filter, of a rigid body; null: no filter
} qcContactSide;

/// Triangle cache: consecutive pairs of a list mostly share one triangle. All zero: empty.
typedef struct qcContactTriangle
{
    qcContactSide side;
    const uint32_t* index;
    qcVector corner[3];
    qcVector oppositeVertex[3];               ///< across each edge, of those in hasOppositeVertex
    unsigned queriedEdges, hasOppositeVertex; ///< bits of edges
} qcContactTriangle;

void qcContactTriangle_Load(qcContactTriangle* cached, const qcContactSide* side);

/// Two triangles, and the margin of their contacts.
typedef struct qcContactPair
{
    qcContactSide a, b;
    double margin;
} qcContactPair;

/// The owned features of each of 1 to qc_featurePairs pairs that may have contacts.
void qcContact_FindNear(const qcTriangleKernels* kernels, const qcContactPair* pairs, size_t count,
                        qcFeatureMask near[qc_featurePairs]);

/// Writes the contacts of these features of the loaded triangles; returns their number, at most qc_maxContactsPerPair.
int qcContact_Find(qcContactTriangle* a, qcContactTriangle* b, double margin, qcFeatureMask near, qcContact* contacts);

#endif
