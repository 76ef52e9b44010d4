// The reference: every triangle of bodies that may meet against every other, by their boxes as given, then the exact
// test. It shares no box arithmetic with the sweep, so that it can find the sweep's mistakes; see also
// sweep/body_pairs.c.
#include "sweep/candidates.h"

#include "base/status.h"

typedef struct Search
{
    const qcCandidateRules* rules;
    qcCandidates* candidates;
    uint32_t count;
    const uint32_t* ranks;
    const double *lower[3], *upper[3]; ///< by place in `ranks`; upper ends include the margin
} Search;

static void CompareRow(void* context, size_t i, uint32_t worker)
{
    const Search* s = context;
    qcCandidateBuffer* sink = &QC_AT(qcCandidateBuffer, s->candidates->sinks, worker);
    uint32_t rank = s->ranks[i], body = qcStepTriangles_BodyOf(s->rules->triangles, rank);
    double lx = s->lower[0][i], ly = s->lower[1][i], lz = s->lower[2][i];
    double ux = s->upper[0][i], uy = s->upper[1][i], uz = s->upper[2][i];
    for (size_t j = i + 1; j < s->count; j++)
    {
        bool apart = (s->lower[0][j] > ux) | (s->lower[1][j] > uy) | (s->lower[2][j] > uz) | (s->upper[0][j] < lx) |
                     (s->upper[1][j] < ly) | (s->upper[2][j] < lz);
        if (!apart)
            qcCandidates_Offer(s->rules, sink, body, rank, qcStepTriangles_BodyOf(s->rules->triangles, s->ranks[j]),
                               s->ranks[j]);
    }
}

qcStatus qcCandidates_Brute(qcCandidates* candidates, const qcCandidateRules* rules, qcProfile* profile)
{
    const qcStepTriangles* t = rules->triangles;
    QC_TRY(qcCandidates_Begin(candidates, rules->threads));
    if (t->count == 0)
        return qcCandidates_End(candidates, profile);
    QC_TRY(qcArray_Resize(&candidates->rows, 6 * (size_t)t->count, sizeof(double), "boxes of triangles"));
    QC_TRY(qcArray_Resize(&candidates->ranks, t->count, sizeof(uint32_t), "boxes of triangles"));
    double* rows = candidates->rows.data;
    uint32_t* ranks = candidates->ranks.data;
    Search search = {.rules = rules, .candidates = candidates, .ranks = ranks};
    for (int axis = 0; axis < 3; axis++)
    {
        search.lower[axis] = rows + (size_t)axis * t->count;
        search.upper[axis] = rows + (size_t)(axis + 3) * t->count;
    }
    for (uint32_t rank = 0; rank < t->count; rank++)
    {
        if (QC_AT(uint8_t, t->pcs, rank) == 0)
            continue;
        uint32_t body = qcStepTriangles_BodyOf(t, rank), at = search.count++;
        double lower[3], upper[3];
        qcBody_GetTriangleBox(qcStepTriangles_Body(t, body), rank - qcStepTriangles_First(t, body), lower, upper);
        for (int axis = 0; axis < 3; axis++)
        {
            rows[(size_t)axis * t->count + at] = lower[axis];
            rows[(size_t)(axis + 3) * t->count + at] = upper[axis] + rules->margin;
        }
        ranks[at] = rank;
    }
    // 256 rows: 32 896 comparisons.
    qcParallel_For(rules->threads, search.count, 256, CompareRow, &search);
    return qcCandidates_End(candidates, profile);
}
