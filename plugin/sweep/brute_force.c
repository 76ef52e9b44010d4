// The reference: each triangle of the PCS against every other, by boxes in double, then the exact test. It shares no
// box arithmetic with sweep and prune or with the BVHs, so that a comparison reveals their errors.
#include "sweep/candidates.h"

#include "base/parallel_for.h"
#include "base/status.h"

typedef struct Search
{
    const qcCandidateRules* rules;
    qcCandidates* candidates;
    uint32_t count;
    const uint32_t* triangles;         ///< by row: global index
    const double *lower[3], *upper[3]; ///< by row; upper ends include the query distance
} Search;

static void CompareRow(void* context, size_t i, uint32_t worker)
{
    const Search* s = context;
    const qcStepTriangles* t = s->rules->triangles;
    qcCandidateBuffer* buffer = &QC_AT(qcCandidateBuffer, s->candidates->buffers, worker);
    uint32_t triangle = s->triangles[i], body = qcStepTriangles_BodyOf(t, triangle);
    double lx = s->lower[0][i], ly = s->lower[1][i], lz = s->lower[2][i];
    double ux = s->upper[0][i], uy = s->upper[1][i], uz = s->upper[2][i];
    for (size_t j = i + 1; j < s->count; j++)
    {
        bool disjoint = (s->lower[0][j] > ux) | (s->lower[1][j] > uy) | (s->lower[2][j] > uz) | (s->upper[0][j] < lx) |
                        (s->upper[1][j] < ly) | (s->upper[2][j] < lz);
        if (!disjoint)
            qcCandidates_Offer(s->rules, body, triangle, qcStepTriangles_BodyOf(t, s->triangles[j]), s->triangles[j],
                               buffer);
    }
}

qcStatus qcCandidates_Brute(const qcCandidateRules* rules, qcCandidates* candidates, qcProfile* profile)
{
    const qcStepTriangles* t = rules->triangles;
    QC_TRY(qcCandidates_Begin(candidates, rules->threads));
    if (t->count == 0)
        return qcCandidates_End(candidates, profile);
    QC_TRY(qcArray_Resize(&candidates->rows, 6 * (size_t)t->count, sizeof(double), "boxes of triangles"));
    QC_TRY(qcArray_Resize(&candidates->rowOwner, t->count, sizeof(uint32_t), "boxes of triangles"));
    double* rows = candidates->rows.data;
    uint32_t* owners = candidates->rowOwner.data;
    Search search = {.rules = rules, .candidates = candidates, .triangles = owners};
    for (int axis = 0; axis < 3; axis++)
    {
        search.lower[axis] = rows + (size_t)axis * t->count;
        search.upper[axis] = rows + (size_t)(axis + 3) * t->count;
    }
    for (uint32_t triangle = 0; triangle < t->count; triangle++)
    {
        if (QC_AT(uint8_t, rules->pcs->triangleSets, triangle) == 0)
            continue;
        uint32_t body = qcStepTriangles_BodyOf(t, triangle), row = search.count++;
        double lower[3], upper[3];
        qcStepTriangles_GetTriangleBox(t, body, triangle - qcStepTriangles_First(t, body), lower, upper);
        for (int axis = 0; axis < 3; axis++)
        {
            rows[(size_t)axis * t->count + row] = lower[axis];
            rows[(size_t)(axis + 3) * t->count + row] = upper[axis] + rules->queryDistance;
        }
        owners[row] = triangle;
    }
    // 256 rows: 32 896 comparisons.
    qcParallel_For(rules->threads, search.count, 256, CompareRow, &search);
    return qcCandidates_End(candidates, profile);
}
