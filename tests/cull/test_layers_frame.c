// The grid frame of `layers` against rational arithmetic: positions in the frame; boxes of levels overlap wherever
// triangles are within the query distance, for any rounding that plugin/docs/proofs/layers.md admits; lifetime of a
// frame.
#include "support/check_ok.h"
#include "gl/layers/layers_gpu.h"
#include "cull/layers/gpu_residency.h"
#include "cull/layers/frame.h"
#include "support/soups.h"
#include "support/suite.h"

#include <float.h>
#include <gmp.h>
#include <math.h>
#include <string.h>

//  ---- bounds ----------------------------------------------------------------------------------------------------

static qcGridBounds MakeUnitBounds(void)
{
    return (qcGridBounds){.upper = {1.0, 2.0, 4.0}};
}

static double Pick(qcRandom* random, const double values[], uint32_t count)
{
    return values[qcRandom_Below(random, count)];
}

/// Bounds of any size, far from the origin or not, with axes of little or no extent.
static qcGridBounds MakeBounds(qcRandom* random)
{
    static const double s_sizes[] = {0.0, 0x1p-900, 1e-6, 1.0, 1.0, 1.0, 1e6, 0x1p900};
    static const double s_shares[] = {0.0, 1e-9, 0.01, 1.0, 1.0};
    static const double s_offsets[] = {0.0, 1.0, 1e3, 1e7, 1e12};
    static const double s_reaches[] = {0.0, 0.0, 1e-12, 1e-3, 1.0, 1e3};
    double size = Pick(random, s_sizes, 8), offset = Pick(random, s_offsets, 5);
    qcGridBounds bounds = {.queryDistance = size * Pick(random, s_reaches, 6) * qcRandom_Uniform(random, 0.5, 1.0),
                           .depthAxis = "\0xyz"[qcRandom_Below(random, 4)],
                           .transforms = qcRandom_Below(random, 2) == 0};
    for (int axis = 0; axis < 3; axis++)
    {
        bounds.lower[axis] = qcRandom_Uniform(random, -1.0, 1.0) * size * offset;
        bounds.upper[axis] = bounds.lower[axis] + qcRandom_Uniform(random, 0.1, 1.0) * size * Pick(random, s_shares, 5);
    }
    // A query distance of 1e6 times the extent and more is refused, which another test checks.
    double widest = 0.0;
    for (int axis = 0; axis < 3; axis++)
        widest = fmax(widest, bounds.upper[axis] - bounds.lower[axis]);
    bounds.queryDistance = fmin(bounds.queryDistance, 1e5 * (widest > 0.0 ? widest : 1.0));
    return bounds;
}

static void PickInside(qcRandom* random, const qcGridBounds* bounds, double p[3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        double lower = bounds->lower[axis], upper = bounds->upper[axis], x = qcRandom_Uniform(random, lower, upper);
        uint32_t where = qcRandom_Below(random, 4);
        p[axis] = where == 0 ? lower : where == 1 || x > upper ? upper : x;
    }
}

//  ---- exact -----------------------------------------------------------------------------------------------------

/// True if |x - (world - origin) * 2^-exponent| <= bound.
static bool IsWithin(double x, double world, double origin, int exponent, double bound)
{
    mpq_t error, term;
    mpq_inits(error, term, NULL);
    mpq_set_d(error, world);
    mpq_set_d(term, origin);
    mpq_sub(error, error, term);
    if (exponent > 0)
        mpq_div_2exp(error, error, (mp_bitcnt_t)exponent);
    else
        mpq_mul_2exp(error, error, (mp_bitcnt_t)-exponent);
    mpq_set_d(term, x);
    mpq_sub(error, error, term);
    mpq_abs(error, error);
    mpq_set_d(term, bound);
    bool within = mpq_cmp(error, term) <= 0;
    mpq_clears(error, term, NULL);
    return within;
}

/// The number nearest to x - reach (below) or x + reach whose exact distance from x is at most `reach`.
static double StepOut(double x, double reach, bool below)
{
    double to = below ? x - reach : x + reach;
    while (!IsWithin(to, x, 0.0, 0, reach))
        to = nextafter(to, x);
    return to;
}

/// True if |p - q| <= reach.
static bool AreWithinReach(const double p[3], const double q[3], double reach)
{
    mpq_t sum, term, other;
    mpq_inits(sum, term, other, NULL);
    for (int axis = 0; axis < 3; axis++)
    {
        mpq_set_d(term, p[axis]);
        mpq_set_d(other, q[axis]);
        mpq_sub(term, term, other);
        mpq_mul(term, term, term);
        mpq_add(sum, sum, term);
    }
    mpq_set_d(term, reach);
    mpq_mul(term, term, term);
    bool within = mpq_cmp(sum, term) <= 0;
    mpq_clears(sum, term, other, NULL);
    return within;
}

//  ---- roundings of a device -------------------------------------------------------------------------------------

/// The float furthest in this direction (-1, 1; 0: nearest) within one unit in the last place.
static float Round(double exact, int direction)
{
    float nearest = (float)exact;
    if (fabsf(nearest) < FLT_MIN)
        return 0.0f;
    if (direction == 0)
        return nearest;
    float further = nextafterf(nearest, direction < 0 ? -INFINITY : INFINITY);
    double unit = fabs((double)nextafterf(nearest, INFINITY) - (double)nearest);
    return fabs((double)further - exact) <= unit ? further : nearest;
}

/// The coordinate furthest in this direction that the point error allows in the device's buffer.
static float Misplace(double exact, double pointError, int direction)
{
    float x = (float)(exact + direction * pointError);
    return fabs((double)x - exact) > pointError ? nextafterf(x, (float)exact) : x;
}

static uint32_t ToLevel(float x)
{
    return x <= 1.0f ? 1 : x >= (float)qc_layersLevels ? qc_layersLevels : (uint32_t)x;
}

/// One end of the box of a point, as boxes.comp makes it: -1 lower, 1 upper; all errors away from the other end's side.
static void MakeEnd(const qcGridFrame* frame, const double world[3], int end, uint32_t levels[4])
{
    double exact[3];
    qcGridFrame_Map(frame, world, exact);
    float g[4];
    for (int i = 0; i < 3; i++)
        g[i] = Round((double)Misplace(exact[i], frame->pointError, -end) * frame->scale[i], -end);
    g[3] = 0.5f * Round((double)g[0] + g[1], -end);
    for (int i = 0; i < 4; i++)
        levels[i] = ToLevel(Round((double)g[i] + (double)end * frame->slack[i], -end));
}

//  ---- positions and levels --------------------------------------------------------------------------------------

START_TEST(an_uploaded_position_lies_in_the_frame_within_the_point_error)
{
    qcRandom random = {41};
    for (int i = 0; i < 4000; i++)
    {
        qcGridBounds bounds = MakeBounds(&random);
        qcGridFrame frame = {0};
        ck_assert(qcGridFrame_Fit(&frame, &bounds));
        for (int k = 0; k < 8; k++)
        {
            double p[3], x[3];
            PickInside(&random, &bounds, p);
            qcGridFrame_Map(&frame, p, x);
            for (int c = 0; c < 3; c++)
            {
                float uploaded = (float)x[c];
                ck_assert(uploaded >= 0.0f && uploaded <= 1.0f);
                ck_assert(IsWithin(uploaded, p[frame.axes[c]], frame.origin[c], frame.exponent, 0x1p-23));
                ck_assert(frame.pointError >= 0x1p-23f);
            }
        }
    }
}
END_TEST

START_TEST(boxes_of_points_within_the_query_distance_overlap_under_any_rounding)
{
    qcRandom random = {42};
    uint64_t apart = 0;
    for (int i = 0; i < 20000; i++)
    {
        qcGridBounds bounds = MakeBounds(&random);
        qcGridFrame frame = {0};
        ck_assert(qcGridFrame_Fit(&frame, &bounds));
        double p[3], q[3];
        PickInside(&random, &bounds, p);
        memcpy(q, p, sizeof q);
        // The query distance along one axis, or nearly so along the diagonal of the image.
        bool diagonal = i % 2 == 0;
        for (int c = 0; c < 3; c++)
        {
            int axis = frame.axes[c];
            double share = !diagonal ? (i / 2 % 3 == c ? 1.0 : 0.0) : c < 2 ? 0.7071067 : 0.0;
            q[axis] = fmin(StepOut(p[axis], share * bounds.queryDistance, false), bounds.upper[axis]);
        }
        ck_assert(AreWithinReach(p, q, bounds.queryDistance));
        uint32_t upper[4], lower[4];
        MakeEnd(&frame, p, 1, upper);
        MakeEnd(&frame, q, -1, lower);
        for (int c = 0; c < 4; c++)
            ck_assert_msg(lower[c] <= upper[c], "case %d, component %d: level %u is above %u", i, c, lower[c],
                          upper[c]);
        MakeEnd(&frame, bounds.lower, 1, upper);
        MakeEnd(&frame, bounds.upper, -1, lower);
        apart += lower[0] > upper[0];
    }
    // The slack makes them overlap, not a frame without levels.
    ck_assert_uint_gt(apart, 5000);
}
END_TEST

START_TEST(a_world_box_overlaps_boxes_of_points_within_the_query_distance)
{
    qcRandom random = {43};
    for (int i = 0; i < 20000; i++)
    {
        qcGridBounds bounds = MakeBounds(&random);
        qcGridFrame frame = {0};
        ck_assert(qcGridFrame_Fit(&frame, &bounds));
        double a[3], b[3], lower[3], upper[3], p[3];
        PickInside(&random, &bounds, a);
        PickInside(&random, &bounds, b);
        bool below = i % 2 == 0;
        for (int axis = 0; axis < 3; axis++)
        {
            lower[axis] = fmin(a[axis], b[axis]);
            upper[axis] = fmax(a[axis], b[axis]);
            // Out to the query distance or the bounds.
            p[axis] = below ? fmax(StepOut(lower[axis], bounds.queryDistance, below), bounds.lower[axis])
                            : fmin(StepOut(upper[axis], bounds.queryDistance, below), bounds.upper[axis]);
        }
        uint32_t box[4], end[4];
        qcGridFrame_MapBox(&frame, lower, upper, box);
        MakeEnd(&frame, p, below ? 1 : -1, end);
        const uint32_t least[3] = {box[0] & 0x7fff, box[0] >> 16, box[1] & 0x7fff};
        const uint32_t most[3] = {box[2] & 0x7fff, box[2] >> 16 & 0x7fff, box[3] & 0x7fff};
        for (int c = 0; c < 3; c++)
            ck_assert_msg(below ? end[c] >= least[c] : end[c] <= most[c], "case %d, component %d: level %u", i, c,
                          end[c]);
        // The diagonal is unbounded.
        ck_assert_uint_eq(box[1] >> 16, 0);
        ck_assert_uint_eq(box[3] >> 16 & 0x7fff, qc_layersLevels);
    }
}
END_TEST

//  ---- rigid bodies ----------------------------------------------------------------------------------------------

/// The arithmetic of vertices.comp: all roundings in one direction, or to nearest.
static float TransformCoordinate(const float row[4], const float local[3], int direction)
{
    float sum = Round((double)row[0] * local[0], direction);
    for (int i = 1; i < 3; i++)
        sum = Round((double)sum + Round((double)row[i] * local[i], direction), direction);
    return Round((double)sum + row[3], direction);
}

static void SetTransform(qcRandom* random, qcTransform* transform)
{
    static const double s_scales[] = {1e-250, 1e-3, 1.0, 1.0, 1.0, 1e3};
    static const double s_offsets[] = {0.0, 1.0, 1.0, 100.0, 1e7};
    double scale = Pick(random, s_scales, 6), offset = Pick(random, s_offsets, 5);
    for (int i = 0; i < 9; i++)
        transform->linear[i] = scale * qcRandom_Uniform(random, -1.0, 1.0);
    for (int axis = 0; axis < 3; axis++)
        transform->translation[axis] = offset * qcRandom_Uniform(random, -1.0, 1.0);
}

/// Adds a random soup with a random transform, and grows the bounds by it.
static void AddRandomBody(qcRandom* random, qcBodies* bodies, qcGridBounds* bounds)
{
    qcSoup soup = qcSoup_MakeRandom(qcRandom_Next(random), 40, 0.2);
    double offset = qcRandom_Below(random, 3) == 0 ? 1e6 : 0.0;
    qcSoup_Translate(&soup, offset, -offset, offset);
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = soup.positions;
    def.positionType = qc_positionF64;
    def.vertexCount = soup.vertexCount;
    def.indices = soup.indices;
    def.triangleCount = soup.triangleCount;
    SetTransform(random, &def.transform);
    qcBodyId id;
    CHECK_OK(qcBodies_Add(bodies, &def, &id));
    qcSoup_Free(&soup);
    const qcBody* body = &QC_AT(qcBody, bodies->slots, id.slot);
    for (int axis = 0; axis < 3; axis++)
    {
        bounds->lower[axis] = fmin(bounds->lower[axis], body->lower[axis]);
        bounds->upper[axis] = fmax(bounds->upper[axis], body->upper[axis]);
    }
}

/// Checks transforms on the device. Returns the number of bodies that it transforms.
static uint32_t CheckTransforms(qcRandom* random, uint32_t bodyCount)
{
    qcBodies bodies = {0};
    qcStepTriangles triangles = {0};
    qcGpuResidency onDevice = {0};
    qcGridFrame frame = {0};
    qcGridBounds bounds = {{DBL_MAX, DBL_MAX, DBL_MAX}, {-DBL_MAX, -DBL_MAX, -DBL_MAX}, 0.0, 0, true};
    uint8_t takesPart[8], hasSelfPairs[8] = {0};
    uint32_t partnerBoxes[4 * 8] = {0}, transformed = 0;
    for (uint32_t i = 0; i < bodyCount; i++)
    {
        takesPart[i] = 1;
        AddRandomBody(random, &bodies, &bounds);
    }
    ck_assert(qcGridFrame_Fit(&frame, &bounds));
    CHECK_OK(qcStepTriangles_Number(&triangles, &bodies));
    const qcResidencyJob job = {&triangles, &frame, takesPart, hasSelfPairs, partnerBoxes, 1};
    CHECK_OK(qcGpuResidency_Prepare(&job, &onDevice));
    qcLayersStep step = {0};
    qcGpuResidency_FillStep(&onDevice, &frame, &step);
    for (size_t u = 0; u < step.uploadCount; u++)
    {
        const qcLayersUpload* upload = &step.uploads[u];
        if (upload->buffer != qc_layersLocals)
            continue;
        const float(*locals)[4] = upload->data;
        uint32_t slot;
        memcpy(&slot, &locals[0][3], sizeof slot);
        if (!QC_AT(qcBodyResidency, onDevice.bodies, slot).transformed)
            continue;
        transformed++;
        const qcLayersBody* entry = &QC_AT(qcLayersBody, onDevice.table, slot);
        for (size_t i = 0; i < 9 * upload->count; i++)
        {
            size_t v = i / 9;
            int c = (int)(i / 3 % 3), direction = (int)(i % 3) - 1;
            float x = TransformCoordinate(entry->transform[c], locals[v], direction);
            double world[3];
            qcBody_GetVertex(&QC_AT(qcBody, bodies.slots, slot), (uint32_t)v, world);
            ck_assert(IsWithin(x, world[frame.axes[c]], frame.origin[c], frame.exponent, frame.pointError));
        }
    }
    qcGpuResidency_Free(&onDevice);
    qcStepTriangles_Free(&triangles);
    qcBodies_Free(&bodies);
    return transformed;
}

START_TEST(a_transformed_vertex_lies_in_the_frame_within_the_point_error)
{
    qcRandom random = {44};
    uint32_t transformed = 0, all = 0;
    for (int i = 0; i < 300; i++)
    {
        uint32_t count = 1 + qcRandom_Below(&random, 8);
        transformed += CheckTransforms(&random, count);
        all += count;
    }
    // The vertices of all others are uploaded: a transform would not be exact enough.
    ck_assert_uint_gt(transformed, all / 3);
    ck_assert_uint_lt(transformed, all);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

//  ---- which frame -----------------------------------------------------------------------------------------------

START_TEST(the_thinnest_axis_is_the_depth_unless_another_is_given)
{
    for (int thin = 0; thin < 3; thin++)
        for (int given = 0; given < 4; given++)
        {
            qcGridBounds bounds = {.upper = {3.0, 3.0, 3.0}, .depthAxis = "\0xyz"[given]};
            bounds.upper[thin] = 1.0;
            qcGridFrame frame = {0};
            ck_assert(qcGridFrame_Fit(&frame, &bounds));
            ck_assert_int_eq(frame.axes[2], given == 0 ? thin : given - 1);
            ck_assert_int_eq((1 << frame.axes[0]) | (1 << frame.axes[1]) | (1 << frame.axes[2]), 7);
        }
}
END_TEST

/// True if a frame for the first bounds fits the second ones.
static bool Stays(const qcGridBounds* first, const qcGridBounds* second)
{
    qcGridFrame frame = {0};
    ck_assert(qcGridFrame_Fit(&frame, first));
    uint64_t number = frame.number;
    ck_assert(qcGridFrame_Fit(&frame, second));
    ck_assert(frame.number == number || frame.number == number + 1);
    return frame.number == number;
}

START_TEST(a_frame_stays_while_the_bounds_fit_and_are_more_than_half_as_wide)
{
    const qcGridBounds bounds = MakeUnitBounds();
    qcGridBounds other = bounds;
    ck_assert(Stays(&bounds, &other));
    for (int axis = 0; axis < 3; axis++)
    {
        other = bounds;
        other.lower[axis] -= 0.1;
        other.upper[axis] += 0.1;
        ck_assert(Stays(&bounds, &other));
        other.lower[axis] -= 1.0;
        ck_assert(!Stays(&bounds, &other));
        other.lower[axis] = bounds.lower[axis];
        other.upper[axis] += 1.0;
        ck_assert(!Stays(&bounds, &other));
        other.upper[axis] = bounds.upper[axis] * 0.9;
        ck_assert(Stays(&bounds, &other));
    }
    other = bounds;
    other.upper[2] = 1.9;
    ck_assert(!Stays(&bounds, &other));
}
END_TEST

START_TEST(another_query_distance_or_axis_or_transforms_need_a_new_frame)
{
    const qcGridBounds bounds = MakeUnitBounds();
    qcGridBounds other = bounds;
    other.queryDistance = 1e-9;
    ck_assert(!Stays(&bounds, &other));
    ck_assert(!Stays(&other, &bounds));
    other = bounds;
    other.depthAxis = 'y';
    ck_assert(!Stays(&bounds, &other));
    other = bounds;
    other.transforms = true;
    ck_assert(!Stays(&bounds, &other));
    ck_assert(!Stays(&other, &bounds));
}
END_TEST

/// By members: between them lie bytes without a value.
static void CheckSameFrame(const qcGridFrame* a, const qcGridFrame* b)
{
    ck_assert_uint_eq(a->number, b->number);
    ck_assert_mem_eq(a->axes, b->axes, sizeof a->axes);
    ck_assert_mem_eq(a->origin, b->origin, sizeof a->origin);
    ck_assert_mem_eq(a->extent, b->extent, sizeof a->extent);
    ck_assert_int_eq(a->exponent, b->exponent);
    ck_assert_mem_eq(&a->unit, &b->unit, sizeof a->unit);
    ck_assert_mem_eq(a->scale, b->scale, sizeof a->scale);
    ck_assert_mem_eq(a->slack, b->slack, sizeof a->slack);
    ck_assert_mem_eq(&a->pointError, &b->pointError, sizeof a->pointError);
    ck_assert_mem_eq(&a->queryDistance, &b->queryDistance, sizeof a->queryDistance);
    ck_assert_mem_eq(a->bounds.lower, b->bounds.lower, sizeof a->bounds.lower);
    ck_assert_mem_eq(a->bounds.upper, b->bounds.upper, sizeof a->bounds.upper);
    ck_assert_mem_eq(&a->bounds.queryDistance, &b->bounds.queryDistance, sizeof a->bounds.queryDistance);
    ck_assert_int_eq(a->bounds.depthAxis, b->bounds.depthAxis);
    ck_assert(a->bounds.transforms == b->bounds.transforms);
}

START_TEST(bounds_that_no_frame_can_hold_are_refused_and_the_frame_stays)
{
    const qcGridBounds bounds = MakeUnitBounds();
    qcGridBounds bad[5] = {bounds, bounds, bounds, bounds, bounds};
    bad[0].upper[1] = 0x1p961;
    bad[1].lower[0] = -DBL_MAX, bad[1].upper[0] = DBL_MAX;
    bad[2].queryDistance = DBL_MAX;
    bad[3].upper[0] = 0x1p-970, bad[3].upper[1] = bad[3].upper[2] = 0.0;
    bad[4].queryDistance = 4e7;
    qcGridFrame frame = {0};
    for (int pass = 0; pass < 2; pass++)
    {
        for (int i = 0; i < 5; i++)
        {
            qcGridFrame before = frame;
            ck_assert(!qcGridFrame_Fit(&frame, &bad[i]));
            CheckSameFrame(&before, &frame);
        }
        ck_assert(qcGridFrame_Fit(&frame, &bounds));
        ck_assert_uint_eq(frame.number, 1);
    }
}
END_TEST

QC_RUN_TESTS("layers, frame", an_uploaded_position_lies_in_the_frame_within_the_point_error,
             boxes_of_points_within_the_query_distance_overlap_under_any_rounding,
             a_world_box_overlaps_boxes_of_points_within_the_query_distance,
             a_transformed_vertex_lies_in_the_frame_within_the_point_error,
             the_thinnest_axis_is_the_depth_unless_another_is_given,
             a_frame_stays_while_the_bounds_fit_and_are_more_than_half_as_wide,
             another_query_distance_or_axis_or_transforms_need_a_new_frame,
             bounds_that_no_frame_can_hold_are_refused_and_the_frame_stays)
