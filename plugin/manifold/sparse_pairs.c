// Which near pairs of two fine meshes are kept: plugin/docs/proofs/sparse_contact.md.
#include "manifold/sparse_pairs.h"

#include "base/status.h"

#include <math.h>
#include <string.h>

enum
{
    // For fewer pairs the stages of normals take less time than the choice.
    qc_minPairs = 64,
    // Cells along an axis of a body: 18 bits each, 5 for the direction and 1 for the side.
    qc_maxCells = 1 << 18,
    qc_cellBits = 18
};

// The squared cosine of 3 degrees: the shortest difference is perpendicular to a face.
static const float s_perpendicular2 = 0.9972f;
// The sine of 22.5 degrees: borders between the 26 directions to the neighbours of a cube.
static const float s_border = 0.38268343f;

typedef struct Triangle
{
    float corner[3][3]; ///< by axis, from the first corner of the first pair, in spacings
    float normal[3];    ///< unit, or 0
    bool isSmall;       ///< no longer than the spacing, and has a cell
    uint64_t cell;
    uint32_t first, count; ///< its candidates
} Triangle;

/// A pair that may be left out. `difference`: from triangle 1 to triangle 0.
typedef struct Candidate
{
    uint32_t pair, other; ///< the other triangle's number
    float difference[3], length2;
} Candidate;

/// The nearest candidate of a cell and a direction.
typedef struct Cell
{
    uint64_t key;  ///< plus 1; 0: free
    uint32_t pair; ///< of the input
    float length2;
} Cell;

/// One of the two bodies.
typedef struct Side
{
    const qcBody* body;
    uint32_t slot, firstTriangle;
    double scale[3]; ///< from the body's coordinates to cells
    double lower[3];
} Side;

typedef struct Job
{
    const qcBodyPairInput* input;
    const qcOverlapKernels* kernels;
    qcSparsePairs* all;
    Side sides[2];
    double origin[3], spacing;
} Job;

static Triangle* TriangleAt(const Job* job, size_t i)
{
    return &QC_AT(Triangle, job->all->triangles, i);
}

static Candidate* CandidateAt(const Job* job, size_t i)
{
    return &QC_AT(Candidate, job->all->candidates, i);
}

static uint32_t* EndsOf(const Job* job, size_t pair)
{
    return &QC_AT(uint32_t, job->all->ends, 2 * pair);
}

/// The pairs of a run are reported[first..end).
static size_t RunOf(const qcBodyPairInput* input, uint32_t run, size_t* end)
{
    size_t first = (size_t)(input->runs[run].value >> 32);
    *end = first + (uint32_t)input->runs[run].value;
    return first;
}

static size_t CountNear(const qcBodyPairInput* input)
{
    size_t count = 0;
    for (uint32_t r = 0; r < input->runCount; r++)
    {
        size_t end, first = RunOf(input, r, &end);
        for (size_t i = first; i < end; i++)
            count += input->reported->pairs[i].relation == qc_relationNear;
    }
    return count;
}

static bool MayBeSparse(const qcBodyPairInput* input)
{
    uint64_t bodies = input->runs[0].key;
    if (!(input->reported->spacing > 0.0) || input->reported->proximities != NULL || bodies >> 32 == (uint32_t)bodies ||
        input->pairCount < qc_minPairs)
        return false;
    size_t near = CountNear(input);
    return near == input->pairCount || (near != 0 && input->reported->unoriented);
}

//  ---- triangles ------------------------------------------------------------------------------------------

static void SetSides(const qcStepTriangles* triangles, Job* job)
{
    uint64_t bodies = job->input->runs[0].key;
    const uint32_t slots[2] = {(uint32_t)(bodies >> 32), (uint32_t)bodies};
    for (int s = 0; s < 2; s++)
    {
        Side* side = &job->sides[s];
        *side = (Side){.body = &QC_AT(qcBody, triangles->bodies->slots, slots[s]), .slot = slots[s]};
        const double* linear = side->body->transform.linear;
        for (int axis = 0; axis < 3; axis++)
        {
            double x = linear[axis], y = linear[3 + axis], z = linear[6 + axis];
            double length = side->body->world != NULL ? 1.0 : sqrt(x * x + y * y + z * z);
            side->scale[axis] = length / job->spacing;
            side->lower[axis] = side->body->world != NULL ? side->body->lower[axis] : side->body->localLower[axis];
        }
    }
    job->sides[1].firstTriangle = job->sides[0].body->triangleCount;
}

/// The cell of the triangle's centroid, in coordinates that move with a rigid body. False: there are too many cells.
static bool FindCell(const Side* side, const uint32_t vertex[3], uint64_t* cell)
{
    const double* positions = side->body->world != NULL ? side->body->world : side->body->local;
    *cell = 0;
    for (int axis = 0; axis < 3; axis++)
    {
        double sum = 0.0;
        for (int c = 0; c < 3; c++)
            sum += (positions[3 * (size_t)vertex[c] + (size_t)axis] - side->lower[axis]) * side->scale[axis];
        double at = qcFloor(sum / 3.0);
        if (!(at >= 0.0 && at < qc_maxCells))
            return false;
        *cell = *cell << qc_cellBits | (uint64_t)at;
    }
    return true;
}

static void FillTriangle(const Job* job, int s, uint32_t index, Triangle* triangle)
{
    const Side* side = &job->sides[s];
    const uint32_t* vertex = side->body->indices + 3 * (size_t)index;
    qcVector corner[3];
    for (int c = 0; c < 3; c++)
    {
        double p[3];
        qcBody_GetVertex(side->body, vertex[c], p);
        for (int axis = 0; axis < 3; axis++)
        {
            p[axis] = (p[axis] - job->origin[axis]) / job->spacing;
            triangle->corner[c][axis] = (float)p[axis];
        }
        corner[c] = qcVector_Load(p);
    }
    qcVector edge[3], n;
    double longest2 = 0.0;
    for (int e = 0; e < 3; e++)
    {
        edge[e] = qcMinus(corner[(e + 1) % 3], corner[e]);
        longest2 = qcMax(qcDot(edge[e], edge[e]), longest2);
    }
    n = qcCross(edge[0], edge[1]);
    double length = sqrt(qcDot(n, n)), unit = length > 0.0 ? 1.0 / length : 0.0;
    triangle->normal[0] = (float)(n.x * unit);
    triangle->normal[1] = (float)(n.y * unit);
    triangle->normal[2] = (float)(n.z * unit);
    triangle->isSmall = longest2 <= 1.0 && FindCell(side, vertex, &triangle->cell);
    triangle->cell = triangle->cell << 1 | (unsigned)s;
    triangle->first = triangle->count = 0;
}

static uint32_t NumberOf(const Job* job, int s, uint32_t index)
{
    uint32_t* number = &QC_AT(uint32_t, job->all->numbers, job->sides[s].firstTriangle + index);
    if (*number == 0)
    {
        FillTriangle(job, s, index, TriangleAt(job, job->all->triangles.count));
        *number = (uint32_t)++job->all->triangles.count;
    }
    return *number - 1;
}

static qcStatus MakeRoom(const Job* job)
{
    qcSparsePairs* all = job->all;
    size_t count = job->input->pairCount, runs = job->input->runCount;
    size_t triangles = (size_t)job->sides[0].body->triangleCount + job->sides[1].body->triangleCount;
    size_t bound = runs + count < triangles ? runs + count : triangles;
    QC_TRY(qcArray_GrowZeroed(&all->numbers, triangles, sizeof(uint32_t), "triangles of manifolds"));
    QC_TRY(qcArray_Reserve(&all->triangles, bound, sizeof(Triangle), "triangles of manifolds"));
    QC_TRY(qcArray_Resize(&all->candidates, count, sizeof(Candidate), "pairs of manifolds"));
    QC_TRY(qcArray_Resize(&all->ends, 2 * count, sizeof(uint32_t), "pairs of manifolds"));
    QC_TRY(qcArray_Resize(&all->isKept, count, sizeof(bool), "pairs of manifolds"));
    QC_TRY(qcArray_Reserve(&all->pairs, count, sizeof(qcPair), "pairs of manifolds"));
    return qcArray_Reserve(&all->runs, runs, sizeof(qcSortItem), "pairs of manifolds");
}

/// Numbers the triangles of the pairs, and counts the candidates of each small one. False: two triangles that touch are
/// both large.
static bool NumberTriangles(Job* job)
{
    const qcBodyPairInput* input = job->input;
    job->all->triangles.count = 0;
    bool isFine = true;
    size_t pair = 0;
    for (uint32_t r = 0; r < input->runCount; r++)
    {
        size_t end, first = RunOf(input, r, &end);
        uint32_t a = NumberOf(job, 0, input->reported->pairs[first].triangleA);
        for (size_t i = first; i < end; i++, pair++)
        {
            uint32_t b = NumberOf(job, 1, input->reported->pairs[i].triangleB), *ends = EndsOf(job, pair);
            ends[0] = a;
            ends[1] = b;
            Triangle* small = TriangleAt(job, TriangleAt(job, a)->isSmall ? a : b);
            small->count++;
            isFine = isFine && (small->isSmall || input->reported->pairs[i].relation == qc_relationNear);
        }
    }
    return isFine;
}

static void ClearNumbers(const Job* job)
{
    const qcBodyPairInput* input = job->input;
    for (uint32_t r = 0; r < input->runCount; r++)
    {
        size_t end, first = RunOf(input, r, &end);
        QC_AT(uint32_t, job->all->numbers, input->reported->pairs[first].triangleA) = 0;
        for (size_t i = first; i < end; i++)
            QC_AT(uint32_t, job->all->numbers, job->sides[1].firstTriangle + input->reported->pairs[i].triangleB) = 0;
    }
}

//  ---- candidates -----------------------------------------------------------------------------------------

static void AddCandidate(const Job* job, uint32_t pair, bool isNear)
{
    const uint32_t* ends = EndsOf(job, pair);
    bool isSecond = !TriangleAt(job, ends[0])->isSmall;
    Triangle* small = TriangleAt(job, ends[isSecond]);
    QC_AT(bool, job->all->isKept, pair) = !small->isSmall;
    if (!small->isSmall || !isNear)
        return;
    Candidate* candidate = CandidateAt(job, small->first + small->count++);
    candidate->pair = pair;
    candidate->other = ends[!isSecond];
}

/// Sorts the near pairs by their small triangles. Pairs without one are kept.
static void SortCandidates(const Job* job)
{
    const qcBodyPairInput* input = job->input;
    uint32_t first = 0;
    for (size_t i = 0; i < job->all->triangles.count; i++)
    {
        Triangle* triangle = TriangleAt(job, i);
        triangle->first = first;
        first += triangle->isSmall ? triangle->count : 0;
        triangle->count = 0;
    }
    uint32_t pair = 0;
    for (uint32_t r = 0; r < input->runCount; r++)
    {
        size_t end, begin = RunOf(input, r, &end);
        for (size_t i = begin; i < end; i++, pair++)
            AddCandidate(job, pair, input->reported->pairs[i].relation == qc_relationNear);
    }
}
static void LoadLane(const Triangle* triangle, size_t lane, float corner[3][3][qc_distanceLanes])
{
    for (int c = 0; c < 3; c++)
        for (int axis = 0; axis < 3; axis++)
            corner[c][axis][lane] = triangle->corner[c][axis];
}

static void MeasureBatch(const Job* job, Candidate* const candidates[qc_distanceLanes], size_t count)
{
    qcDistanceBatch batch;
    float difference[3][qc_distanceLanes], length2[qc_distanceLanes];
    for (size_t lane = 0; lane < qc_distanceLanes; lane++)
    {
        const uint32_t* ends = EndsOf(job, candidates[lane < count ? lane : 0]->pair);
        for (int side = 0; side < 2; side++)
            LoadLane(TriangleAt(job, ends[side]), lane, batch.corner[side]);
    }
    job->kernels->findDistances(&batch, difference, length2);
    for (size_t lane = 0; lane < count; lane++)
    {
        for (int axis = 0; axis < 3; axis++)
            candidates[lane]->difference[axis] = difference[axis][lane];
        candidates[lane]->length2 = length2[lane];
    }
}

static void MeasureCandidates(const Job* job)
{
    Candidate* batch[qc_distanceLanes];
    size_t count = 0;
    for (size_t i = 0; i < job->all->triangles.count; i++)
    {
        const Triangle* small = TriangleAt(job, i);
        for (uint32_t k = 0; k < small->count; k++)
        {
            batch[count++] = CandidateAt(job, small->first + k);
            if (count == qc_distanceLanes)
                MeasureBatch(job, batch, count);
            count %= qc_distanceLanes;
        }
    }
    if (count != 0)
        MeasureBatch(job, batch, count);
}

//  ---- rules ----------------------------------------------------------------------------------------------

static float Dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static bool IsPerpendicular(const Candidate* candidate, const Triangle* face)
{
    float along = Dot(candidate->difference, face->normal);
    return along * along >= s_perpendicular2 * candidate->length2;
}

/// First rule: the small triangle has a nearer candidate to the same side, and the shortest difference is perpendicular
/// to neither face.
static bool HasNearer(const Job* job, const Triangle* small, const Candidate* candidate)
{
    if (IsPerpendicular(candidate, small) || IsPerpendicular(candidate, TriangleAt(job, candidate->other)))
        return false;
    for (uint32_t i = 0; i < small->count; i++)
    {
        const Candidate* other = CandidateAt(job, small->first + i);
        if (other->length2 < candidate->length2 && Dot(other->difference, candidate->difference) > 0.0f)
            return true;
    }
    return false;
}

static uint64_t KeyOf(const Triangle* small, const Candidate* candidate)
{
    float border = s_border * sqrtf(candidate->length2);
    uint64_t direction = 0;
    for (int axis = 0; axis < 3; axis++)
    {
        float x = candidate->difference[axis];
        direction = 3 * direction + (x > border ? 2u : x < -border ? 0u : 1u);
    }
    return (small->cell << 5 | direction) + 1;
}

static Cell* FindSlot(const Job* job, uint64_t key)
{
    size_t mask = job->all->cells.count - 1, at = (size_t)((key * UINT64_C(0x9e3779b97f4a7c15)) >> 20) & mask;
    Cell* cells = job->all->cells.data;
    while (cells[at].key != 0 && cells[at].key != key)
        at = (at + 1) & mask;
    return &cells[at];
}

/// Second rule: of the candidates of a cell and a direction the nearest is kept, of equal ones the first.
static void TakeNearest(const Job* job, const Triangle* small, const Candidate* candidate)
{
    uint64_t key = KeyOf(small, candidate);
    Cell* cell = FindSlot(job, key);
    bool isFirst = cell->key == 0, *isKept = job->all->isKept.data;
    if (!isFirst &&
        (cell->length2 < candidate->length2 || (!(cell->length2 > candidate->length2) && cell->pair < candidate->pair)))
        return;
    if (!isFirst)
        isKept[cell->pair] = false;
    *cell = (Cell){key, candidate->pair, candidate->length2};
    isKept[candidate->pair] = true;
}

static qcStatus ApplyRules(const Job* job)
{
    size_t size = 16;
    while (size < 2 * job->input->pairCount)
        size *= 2;
    QC_TRY(qcArray_Resize(&job->all->cells, size, sizeof(Cell), "pairs of manifolds"));
    memset(job->all->cells.data, 0, size * sizeof(Cell));
    for (size_t i = 0; i < job->all->triangles.count; i++)
    {
        const Triangle* small = TriangleAt(job, i);
        for (uint32_t k = 0; k < small->count; k++)
        {
            const Candidate* candidate = CandidateAt(job, small->first + k);
            if (!(candidate->length2 < INFINITY)) // coordinates too large for floats
                QC_AT(bool, job->all->isKept, candidate->pair) = true;
            else if (!HasNearer(job, small, candidate))
                TakeNearest(job, small, candidate);
        }
    }
    return qc_statusOk;
}

static void ListKept(const Job* job, qcManifoldInput* reported, qcBodyPairInput* sparse)
{
    const qcBodyPairInput* input = job->input;
    qcArray *pairs = &job->all->pairs, *runs = &job->all->runs;
    pairs->count = runs->count = 0;
    size_t pair = 0;
    for (uint32_t r = 0; r < input->runCount; r++)
    {
        size_t end, first = RunOf(input, r, &end), begin = pairs->count;
        for (size_t i = first; i < end; i++, pair++)
            if (QC_AT(bool, job->all->isKept, pair))
                QC_AT(qcPair, *pairs, pairs->count++) = input->reported->pairs[i];
        if (pairs->count != begin)
            QC_AT(qcSortItem, *runs, runs->count++) =
                (qcSortItem){input->runs[r].key, (uint64_t)begin << 32 | (pairs->count - begin)};
    }
    *reported = *input->reported;
    reported->pairs = pairs->data;
    reported->count = pairs->count;
    *sparse = (qcBodyPairInput){reported, runs->data, (uint32_t)runs->count, pairs->count};
}

qcStatus qcSparsePairs_Choose(const qcStepTriangles* triangles, const qcBodyPairInput* input,
                              const qcOverlapKernels* kernels, qcSparsePairs* pairs, qcManifoldInput* reported,
                              qcBodyPairInput* sparse)
{
    *sparse = *input;
    if (!MayBeSparse(input))
        return qc_statusOk;
    Job job = {.input = input, .kernels = kernels, .all = pairs, .spacing = input->reported->spacing};
    SetSides(triangles, &job);
    size_t end, first = RunOf(input, 0, &end);
    const qcBody* body = job.sides[0].body;
    qcBody_GetVertex(body, body->indices[3 * (size_t)input->reported->pairs[first].triangleA], job.origin);
    QC_TRY(MakeRoom(&job));
    bool isFine = NumberTriangles(&job);
    ClearNumbers(&job);
    if (!isFine)
        return qc_statusOk;
    SortCandidates(&job);
    MeasureCandidates(&job);
    QC_TRY(ApplyRules(&job));
    ListKept(&job, reported, sparse);
    return qc_statusOk;
}

void qcSparsePairs_Free(qcSparsePairs* pairs)
{
    qcArray* arrays[] = {&pairs->pairs,      &pairs->runs, &pairs->numbers, &pairs->triangles,
                         &pairs->candidates, &pairs->ends, &pairs->isKept,  &pairs->cells};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
