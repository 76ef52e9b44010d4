// The stage of normals: its steps in their order.
#include "manifold/normal_cost.h"
#include "manifold/stage_switches.h"
#include "base/status.h"

static bool AreEqual(qcVector a, qcVector b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

/// Settled pairs get the normals of their regions. For the others: whether the choice has kept the reported normal.
static void FinishChoice(const qcContactInput* input, qcContactNormals* normals)
{
    for (uint32_t p = 0; p < input->topology->pairs.count; p++)
    {
        const qcContactRegion* region = qcContactRegions_Of(input->regions, qcContactTopology_Pair(input->topology, p));
        qcPairNormal* normal = qcContactNormals_Pair(normals, p);
        if (region->hasSeparatingPlane)
            *normal = (qcPairNormal){.normal = region->normal};
        else
            normal->keepsReported = AreEqual(qcContactProximity_Pair(input->proximity, p)->normal, normal->normal);
    }
}

qcStatus qcContactNormals_Set(const qcContactInput* input, uint32_t pair, qcVector normal, qcPairOverlaps* overlaps,
                              qcContactNormals* normals)
{
    const qcManifoldPair* triangles = qcContactTopology_Pair(input->topology, pair);
    if (!qcPairOverlaps_Reserve(overlaps, 0, qc_maxOverlapCorners))
        return qcPairOverlaps_Status(overlaps);
    qcPairNormal* own = qcContactNormals_Pair(normals, pair);
    own->normal = normal;
    own->keepsReported = own->flipped = own->disjoint = false;
    qcProjectedOverlap overlap = {.count = -1};
    qcProjectedOverlap_Compute(input->kernels, triangles, normal, &overlap);
    qcPairOverlaps_Set(overlaps, pair, 0, &overlap, normal, false, qcContactInput_CornerLimit(input, triangles));
    return qc_statusOk;
}

qcStatus qcContactNormals_Find(const qcContactInput* input, qcPairOverlaps* overlaps, qcContactNormals* normals)
{
    size_t count = input->topology->pairs.count;
    QC_TRY(qcArray_Resize(&normals->pairs, count, sizeof(qcPairNormal), "normals of manifolds"));
    QC_TRY(qcArray_Resize(&overlaps->ranges, count, sizeof(qcCornerRange), "normals of manifolds"));
    QC_TRY(qcContactNormals_Choose(input, overlaps, normals));
    if (QC_STAGE_RUNS(propagation))
        QC_TRY(qcContactNormals_Propagate(input, overlaps, normals));
    FinishChoice(input, normals);
    if (QC_STAGE_RUNS(orientation))
        QC_TRY(qcContactNormals_Orient(input, overlaps, normals));
    if (QC_STAGE_RUNS(outwardNormals))
        QC_TRY(qcContactNormals_LeadOut(input, overlaps, normals));
    if (QC_STAGE_RUNS(minimumTranslation))
        QC_TRY(qcContactNormals_Shorten(input, overlaps, normals));
    return qc_statusOk;
}

void qcContactNormals_Free(qcContactNormals* normals)
{
    qcArray* arrays[] = {&normals->pairs,      &normals->next,        &normals->rounds,
                         &normals->components, &normals->nodes,       &normals->references,
                         &normals->items,      &normals->sortScratch, &normals->waysOut};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
