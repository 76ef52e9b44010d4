// Rigid transforms and the relative transform of two bodies, against long double and against vertices as
// qcBody_GetVertex rounds them.
#include "base/rigid_transform.h"

#include "base/status.h"
#include "scene/float_positions.h"
#include "support/suite.h"
#include "sweep/sample_bodies.h"
#include "support/transforms.h"

#include <float.h>
#include <math.h>

//  ---- invertible transforms -----------------------------------------------------------------------

static void GetWorld(const qcTransform* transform, const double x[3], double world[3])
{
    double local[3] = {x[0], x[1], x[2]};
    qcBody body = {.local = local, .transform = *transform};
    qcBody_GetVertex(&body, 0, world);
}

static long double RowSum(const long double m[9])
{
    long double largest = 0.0L;
    for (int i = 0; i < 3; i++)
        largest = fmaxl(largest, fabsl(m[3 * i]) + fabsl(m[3 * i + 1]) + fabsl(m[3 * i + 2]));
    return largest;
}

/// The condition number by row sums, or infinity if even long double finds no inverse (its product with the matrix is
/// checked).
static long double InvertWell(const double m[9], long double inverse[9])
{
    long double wide[9], rest[9];
    for (int i = 0; i < 9; i++)
        wide[i] = m[i];
    for (int i = 0; i < 9; i++)
    {
        int r = (i % 3 + 1) % 3, s = (i % 3 + 2) % 3, u = (i / 3 + 1) % 3, v = (i / 3 + 2) % 3;
        inverse[i] = wide[3 * r + u] * wide[3 * s + v] - wide[3 * r + v] * wide[3 * s + u];
    }
    long double determinant = wide[0] * inverse[0] + wide[1] * inverse[3] + wide[2] * inverse[6];
    if (determinant == 0.0L)
        return INFINITY;
    for (int i = 0; i < 9; i++)
        inverse[i] /= determinant;
    for (int i = 0; i < 9; i++)
    {
        rest[i] = i % 4 == 0 ? -1.0L : 0.0L;
        for (int k = 0; k < 3; k++)
            rest[i] += wide[i / 3 * 3 + k] * inverse[3 * k + i % 3];
    }
    return RowSum(rest) < 0.01L ? RowSum(wide) * RowSum(inverse) : INFINITY;
}

START_TEST(a_transform_is_invertible_up_to_a_condition_number_of_4096)
{
    qcRandom random = {1};
    size_t count[2] = {0, 0};
    for (int i = 0; i < 200000; i++)
    {
        qcTransform t = qcIdentityTransform();
        double share = exp2(-qcRandom_Uniform(&random, 0.0, i % 2 == 0 ? 16.0 : 70.0));
        qcMakeLinear(&random, (qcShape)qcRandom_Below(&random, qc_shapeCount), share, 1.0, t.linear);
        for (int k = 0; k < 9 && i % 16 == 0; k++)
            t.linear[k] = qcRandom_Integer(&random, -1, 1);
        long double inverse[9], condition = InvertWell(t.linear, inverse);
        int exponent = (int)qcRandom_Integer(&random, -190, 190);
        for (int k = 0; k < 9; k++)
            t.linear[k] = ldexp(t.linear[k], exponent);
        bool invertible = qcTransform_IsInvertible(&t);
        CHECK_THAT(invertible || condition > 4095.9L, "refused: condition %Lg, share %g", condition, share);
        CHECK_THAT(!invertible || condition < 4096.1L, "accepted: condition %Lg, share %g", condition, share);
        count[invertible]++;
    }
    ck_assert(count[0] > 20000 && count[1] > 20000);
}
END_TEST

START_TEST(a_transform_without_an_inverse_in_double_is_not_invertible)
{
    const double scales[] = {0.0, 1e-300, 1e-61, 1e61, 1e300, DBL_MAX};
    for (size_t i = 0; i < sizeof scales / sizeof scales[0]; i++)
    {
        qcTransform t = qcIdentityTransform();
        for (int k = 0; k < 3; k++)
            t.linear[4 * k] = scales[i];
        CHECK_THAT(!qcTransform_IsInvertible(&t), "a scale of %g", scales[i]);
    }
    for (int flat = 1; flat < 8; flat++)
    {
        qcTransform t = qcIdentityTransform();
        for (int k = 0; k < 3; k++)
            t.linear[4 * k] = (flat >> k & 1) != 0 ? 0.0 : 1.0;
        CHECK_THAT(!qcTransform_IsInvertible(&t), "flat along axes %d", flat);
    }
}
END_TEST

//  ---- relative transforms -------------------------------------------------------------------------

/// Two bodies whose local points x[0] and x[1] coincide in the world, and boxes around the points.
typedef struct BodyPair
{
    qcRigidTransform placement[2];
    double x[2][3];
    double apart; ///< max difference of a coordinate of the two points in the world
} BodyPair;

static double FindApart(const qcTransform* transform, const double x[3], const double world[3])
{
    double at[3], apart = 0.0;
    GetWorld(transform, x, at);
    for (int axis = 0; axis < 3; axis++)
        apart = fmax(apart, fabs(at[axis] - world[axis]));
    return apart;
}

/// Another local point with the same image in the world, or nearly the same.
static void MoveWithin(qcRandom* random, BodyPair* m, const long double inverse[9], const double world[3])
{
    const qcTransform* t = &m->placement[0].transform;
    for (int attempt = 0; attempt < 12; attempt++)
    {
        long double step[3];
        double x[3];
        for (int axis = 0; axis < 3; axis++)
        {
            double size = fabs(t->translation[axis]) + fabs(world[axis]);
            step[axis] = (long double)(size * 0x1p-53 * qcRandom_Uniform(random, -1.0, 1.0));
        }
        for (int i = 0; i < 3; i++)
            x[i] = (double)(m->x[0][i] + inverse[3 * i] * step[0] + inverse[3 * i + 1] * step[1] +
                            inverse[3 * i + 2] * step[2]);
        double apart = FindApart(t, x, world);
        if (apart > m->apart || (apart == m->apart && attempt > 8))
            continue;
        m->apart = apart;
        memcpy(m->x[0], x, sizeof x);
    }
}

static void MakeBox(qcRandom* random, const double x[3], double size, qcRigidTransform* placement)
{
    bool tight = qcRandom_Below(random, 2) == 0;
    for (int axis = 0; axis < 3; axis++)
    {
        placement->lower[axis] = tight ? x[axis] : x[axis] - qcRandom_Uniform(random, 0.0, size);
        placement->upper[axis] = tight ? x[axis] : x[axis] + qcRandom_Uniform(random, 0.0, size);
    }
}

/// Makes two bodies with points that coincide in the world. False: the first transform is not invertible.
static bool PlaceClose(qcRandom* random, BodyPair* m)
{
    int range = (int)qcRandom_Below(random, 3) * 60;
    double size = ldexp(1.0, (int)qcRandom_Integer(random, -range, range)), world[3], scale[2];
    double away = qcRandom_Below(random, 3) == 0 ? 0.0 : pow(10.0, qcRandom_Integer(random, 0, 12));
    for (int side = 0; side < 2; side++)
    {
        qcTransform* t = &m->placement[side].transform;
        *t = qcIdentityTransform();
        if (qcRandom_Below(random, 6) != 0)
            qcMakeAnyLinear(random, -range, range, t->linear);
        scale[side] = fabs(t->linear[0]) + fabs(t->linear[1]) + fabs(t->linear[2]);
        for (int axis = 0; axis < 3; axis++)
            t->translation[axis] = size * (side == 0 ? away * qcRandom_Uniform(random, -1.0, 1.0)
                                                     : m->placement[0].transform.translation[axis]) +
                                   size * qcRandom_Uniform(random, -1.0, 1.0);
        // Local coordinates may be far from their origin too.
        double local = size / scale[side] * (qcRandom_Below(random, 3) == 0 ? 1e3 : 1.0);
        for (int axis = 0; axis < 3; axis++)
            m->x[side][axis] = qcRandom_Below(random, 8) == 0 ? 0.0 : local * qcRandom_Uniform(random, -1.0, 1.0);
    }
    qcTransform* a = &m->placement[0].transform;
    long double inverse[9];
    InvertWell(a->linear, inverse);
    if (!qcTransform_IsInvertible(a))
        return false;
    // The second body is moved so that the points coincide; then the first body's point is searched near the image.
    double to[3];
    GetWorld(a, m->x[0], to);
    GetWorld(&m->placement[1].transform, m->x[1], world);
    for (int axis = 0; axis < 3; axis++)
        m->placement[1].transform.translation[axis] += to[axis] - world[axis];
    GetWorld(&m->placement[1].transform, m->x[1], world);
    for (int i = 0; i < 3; i++)
    {
        long double x = 0.0L;
        for (int k = 0; k < 3; k++)
            x += inverse[3 * i + k] * ((long double)world[k] - (long double)a->translation[k]);
        m->x[0][i] = (double)x;
    }
    m->apart = FindApart(a, m->x[0], world);
    MoveWithin(random, m, inverse, world);
    for (int side = 0; side < 2; side++)
        MakeBox(random, m->x[side], size / scale[side], &m->placement[side]);
    return true;
}

START_TEST(points_that_coincide_in_the_world_coincide_in_local_coordinates)
{
    qcRandom random = {2};
    size_t same = 0;
    double worst = 0.0;
    for (int i = 0; i < 100000; i++)
    {
        BodyPair m;
        if (!PlaceClose(&random, &m))
            continue;
        same += m.apart == 0.0;
        qcRelativeTransform r = qcRelativeTransform_Find(&m.placement[0], &m.placement[1]);
        for (int axis = 0; axis < 3; axis++)
        {
            long double at = (long double)r.shift[axis] - (long double)m.x[0][axis];
            for (int k = 0; k < 3; k++)
                at += (long double)r.linear[axis][k] * (long double)m.x[1][k];
            double off = (double)fabsl(at);
            CHECK_THAT(off <= r.error[axis] + r.reach[axis] * m.apart, "meeting %d: %a off, %a allowed", i, off,
                       r.error[axis]);
            worst = m.apart == 0.0 ? fmax(worst, off / r.error[axis]) : worst;
        }
    }
    ck_assert_uint_gt(same, 10000);
    // The bound is tight.
    ck_assert(worst > 0x1p-12);
}
END_TEST

/// The longest image of a vector of length 1, by iteration.
static long double FindLongestImage(const long double m[9])
{
    long double v[3] = {0.57L, 0.61L, 0.55L}, longest = 0.0L;
    for (int step = 0; step < 30; step++)
    {
        long double w[3] = {0}, u[3] = {0}, length = hypotl(v[0], hypotl(v[1], v[2]));
        for (int k = 0; k < 9; k++)
            w[k / 3] += m[k] * v[k % 3] / length;
        for (int k = 0; k < 9; k++)
            u[k % 3] += m[k] * w[k / 3];
        longest = fmaxl(longest, hypotl(w[0], hypotl(w[1], w[2])));
        memcpy(v, u, sizeof v);
    }
    return longest;
}

static void CheckNorm(const long double m[9], double bound, int i, const char* what)
{
    long double longest = FindLongestImage(m);
    CHECK_THAT((double)longest <= bound, "transform %d: %s: vectors grow %La times, not %a", i, what, longest, bound);
    CHECK_THAT((double)longest > 0.57 * bound, "transform %d: %s: vectors grow only %La times", i, what, longest);
}

START_TEST(reach_and_stretch_are_those_of_the_inverse_and_growth_is_that_of_the_transform)
{
    qcRandom random = {3};
    for (int i = 0; i < 30000; i++)
    {
        qcRigidTransform a = {.transform = qcIdentityTransform()}, b = a;
        qcMakeAnyLinear(&random, -100, 100, a.transform.linear);
        qcMakeAnyLinear(&random, -100, 100, b.transform.linear);
        long double inverse[9], linear[9];
        if (!isfinite(InvertWell(a.transform.linear, inverse)) || !qcTransform_IsInvertible(&a.transform))
            continue;
        for (int k = 0; k < 9; k++)
            linear[k] = a.transform.linear[k];
        qcRelativeTransform r = qcRelativeTransform_Find(&a, &b);
        CheckNorm(inverse, r.stretch, i, "stretch");
        CheckNorm(linear, r.growth, i, "growth");
        for (int axis = 0; axis < 3; axis++)
        {
            const long double* row = inverse + 3 * axis;
            long double reach = fabsl(row[0]) + fabsl(row[1]) + fabsl(row[2]);
            double off = fabs((double)(reach / (long double)r.reach[axis]) - 1.0);
            CHECK_THAT(off < 1e-9, "transform %d: reach wrong by %g", i, off);
        }
    }
}
END_TEST

//  ---- boxes ---------------------------------------------------------------------------------------

static uint32_t AddRigid(qcBodies* bodies, const qcSoup* soup)
{
    qcBodyDef def = qcBodyDefOf(soup);
    qcBodyId id;
    CHECK_OK(qcBodies_Add(bodies, &def, &id));
    return id.slot;
}

/// A random soup, with `spare` more vertices far outside that no triangle has.
static qcSoup MakeWithSpare(qcRandom* random, uint32_t spare)
{
    qcSoup soup = qcMakeSoup((qcSoupKind)qcRandom_Below(random, qc_soupKindCount), qcRandom_Next(random));
    soup.positions = realloc(soup.positions, 3 * sizeof(double) * (soup.vertexCount + spare));
    ck_assert_ptr_nonnull(soup.positions);
    for (size_t i = 3 * (size_t)soup.vertexCount; i < 3 * (size_t)(soup.vertexCount + spare); i++)
        soup.positions[i] = 7.0;
    soup.vertexCount += spare;
    return soup;
}

static void FindWorldBox(const qcBody* body, double lower[3], double upper[3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        lower[axis] = DBL_MAX;
        upper[axis] = -DBL_MAX;
    }
    for (uint32_t t = 0; t < body->triangleCount; t++)
    {
        double low[3], high[3];
        qcBody_GetTriangleBox(body, t, low, high);
        for (int axis = 0; axis < 3; axis++)
        {
            lower[axis] = fmin(lower[axis], low[axis]);
            upper[axis] = fmax(upper[axis], high[axis]);
        }
    }
}

START_TEST(the_box_of_a_moved_body_contains_its_rounded_vertices)
{
    qcRandom random = {4};
    size_t larger = 0;
    for (int i = 0; i < 300; i++)
    {
        qcBodies bodies = {0};
        qcSoup soup = MakeWithSpare(&random, qcRandom_Below(&random, 3));
        qcSoup_Place(&soup, 1.0, qcRandom_Uniform(&random, -2.0, 2.0), 0.0, qcRandom_Uniform(&random, -1e3, 1e3));
        const qcBody* body = qcBodyAt(&bodies, AddRigid(&bodies, &soup));
        for (int move = 0; move < 10; move++)
        {
            // For axis-aligned transforms the ends of the box are those of vertices.
            bool tight = move % 2 == 0;
            qcTransform t = qcIdentityTransform();
            if (!tight)
                qcMakeAnyLinear(&random, -100, 100, t.linear);
            else if (move % 4 == 0)
                qcMakeLinear(&random, qc_shapeScaled, 1.0, move == 0 ? 1.0 : -3.0, t.linear);
            double far = move < 2 ? 0.0 : pow(10.0, qcRandom_Integer(&random, -3, 12));
            for (int axis = 0; axis < 3; axis++)
                t.translation[axis] = far * qcRandom_Uniform(&random, -1.0, 1.0);
            CHECK_OK(qcBodies_SetTransform(&bodies, 0, &t));
            double lower[3], upper[3];
            FindWorldBox(body, lower, upper);
            for (int axis = 0; axis < 3; axis++)
            {
                bool same = body->lower[axis] == lower[axis] && body->upper[axis] == upper[axis];
                CHECK_THAT(body->lower[axis] <= lower[axis] && body->upper[axis] >= upper[axis],
                           "body %d, move %d: %a %a outside %a %a", i, move, lower[axis], upper[axis],
                           body->lower[axis], body->upper[axis]);
                CHECK_THAT(!tight || same, "body %d, move %d: %a %a around %a %a", i, move, body->lower[axis],
                           body->upper[axis], lower[axis], upper[axis]);
                larger += !same;
            }
        }
        qcBodies_Free(&bodies);
        qcSoup_Free(&soup);
    }
    ck_assert_uint_gt(larger, 1000);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(an_identity_may_have_zeros_of_either_sign)
{
    qcBodies bodies = {0};
    qcSoup soup = qcSoup_MakeGrid(2);
    for (uint32_t i = 0; i < 3 * soup.vertexCount; i += 2)
        soup.positions[i] = -soup.positions[i];
    const qcBody* body = qcBodyAt(&bodies, AddRigid(&bodies, &soup));
    qcTransform t = qcIdentityTransform();
    for (int i = 0; i < 3; i++)
        t.linear[i == 2 ? 6 : 4 * i + 1] = t.translation[i] = -0.0;
    CHECK_OK(qcBodies_SetTransform(&bodies, 0, &t));
    for (uint32_t v = 0; v < soup.vertexCount; v++)
    {
        double p[3];
        qcBody_GetVertex(body, v, p);
        ck_assert_mem_eq(p, soup.positions + 3 * v, sizeof p);
    }
    ck_assert_mem_eq(body->lower, body->localLower, sizeof body->lower);
    ck_assert_mem_eq(body->upper, body->localUpper, sizeof body->upper);
    qcBodies_Free(&bodies);
    qcSoup_Free(&soup);
}
END_TEST

static void CheckRefused(qcBodies* bodies, const qcTransform* transform, const char* expected)
{
    qcBody before = *qcBodyAt(bodies, 0);
    uint64_t revision = bodies->revision;
    ck_assert_int_eq(qcBodies_SetTransform(bodies, 0, transform), qc_statusBadInput);
    CHECK_THAT(strstr(qcLastMessage(), expected) != NULL, "%s", qcLastMessage());
    ck_assert_mem_eq(&before, qcBodyAt(bodies, 0), sizeof before);
    ck_assert_uint_eq(bodies->revision, revision);
}

START_TEST(a_transform_that_overflows_for_a_vertex_is_refused)
{
    // No triangle has the last vertex.
    double positions[15] = {1e308, 0.0, 0.0, 0.0, 1e308, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.5e308};
    uint32_t indices[6] = {0, 1, 2, 1, 2, 3};
    qcSoup soup = {positions, 5, indices, 2};
    for (uint32_t triangles = 0; triangles <= 2; triangles += 2)
    {
        qcBodies bodies = {0};
        soup.triangleCount = triangles;
        const qcBody* body = qcBodyAt(&bodies, AddRigid(&bodies, &soup));
        // The sum of all largest coordinates overflows, but no vertex does: the box is that of the vertices.
        qcTransform t = qcIdentityTransform();
        t.linear[1] = -1.0;
        t.linear[2] = 1.0;
        t.translation[2] = 5.0;
        CHECK_OK(qcBodies_SetTransform(&bodies, 0, &t));
        const double lower[3] = {-1e308, 0.0, 5.0}, upper[3] = {1e308, 1e308, 6.0};
        for (int axis = 0; axis < 3 && triangles != 0; axis++)
            ck_assert(body->lower[axis] == lower[axis] && body->upper[axis] == upper[axis]);
        ck_assert(triangles != 0 || body->lower[0] > body->upper[0]);
        t.linear[2] = 1.5;
        CheckRefused(&bodies, &t, "vertex 4");
        t.linear[1] = 2.0;
        CheckRefused(&bodies, &t, "vertex 1");
        t.linear[1] = 0.0;
        t.linear[2] = NAN;
        CheckRefused(&bodies, &t, "linear[2]");
        t.linear[2] = 0.0;
        t.translation[1] = INFINITY;
        CheckRefused(&bodies, &t, "translation[1]");
        qcBodies_Free(&bodies);
    }
}
END_TEST

START_TEST(a_body_without_triangles_has_an_empty_box_under_any_transform)
{
    double positions[3] = {1.0, 2.0, 3.0};
    for (uint32_t vertexCount = 0; vertexCount < 2; vertexCount++)
    {
        qcBodies bodies = {0};
        qcSoup soup = {positions, vertexCount, NULL, 0};
        const qcBody* body = qcBodyAt(&bodies, AddRigid(&bodies, &soup));
        qcTransform t = qcIdentityTransform();
        for (int move = 0; move < 3; move++)
        {
            t.translation[1] = 1e300 * move;
            t.linear[0] = move;
            CHECK_OK(qcBodies_SetTransform(&bodies, 0, &t));
            for (int axis = 0; axis < 3; axis++)
                ck_assert(body->lower[axis] > body->upper[axis]);
        }
        qcBodies_Free(&bodies);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

//  ---- fits ----------------------------------------------------------------------------------------

/// True if the BVH was fitted anew. A fit writes all points; the first point is overwritten before, to detect that.
static bool FitsAnew(qcTriangleBvh* bvh, const qcBody* body, double margin)
{
    qcBvhScratch scratch = {0};
    bool fits;
    float* mark = &QC_AT(qcPoint, bvh->fit.points, 0).x[0];
    *mark = -5.0f;
    CHECK_OK(qcTriangleBvh_Fit(bvh, body, margin, qcTriangleKernels_Get(), 1, &scratch, &fits));
    ck_assert(fits);
    qcBvhScratch_Free(&scratch);
    bool anew = *mark != -5.0f;
    *mark = 0.0f;
    return anew;
}

START_TEST(a_rigid_body_without_self_collision_is_fitted_once)
{
    qcRandom random = {6};
    qcBodies bodies = {0};
    qcSoup soup = qcSoup_MakeSphere(2, 1.0);
    AddRigid(&bodies, &soup);
    qcBody* body = &QC_AT(qcBody, bodies.slots, 0);
    qcTriangleBvh bvh;
    CHECK_OK(qcTriangleBvh_Build(&bvh, body, &(qcOrderOptions){.threads = 1}));
    qcTransform t = qcIdentityTransform(), flat = t;
    flat.linear[8] = 0.0;
    body->selfCollision = false;
    ck_assert(FitsAnew(&bvh, body, 0.0) && bvh.fit.isLocal);
    for (int i = 0; i < 20; i++)
    {
        qcMakeAnyLinear(&random, -10, 10, t.linear);
        if (!qcTransform_IsInvertible(&t))
            continue;
        CHECK_OK(qcBodies_SetTransform(&bodies, 0, &t));
        ck_assert(!FitsAnew(&bvh, body, 0.01 * i) && bvh.fit.isLocal);
    }
    for (int i = 0; i < 2; i++)
    {
        CHECK_OK(qcBodies_SetTransform(&bodies, 0, &flat));
        ck_assert(FitsAnew(&bvh, body, 0.0) && !bvh.fit.isLocal);
        ck_assert(!FitsAnew(&bvh, body, 0.0));
        ck_assert(FitsAnew(&bvh, body, 0.5));
        CHECK_OK(qcBodies_SetTransform(&bodies, 0, &t));
        ck_assert(FitsAnew(&bvh, body, 0.5) && bvh.fit.isLocal && bvh.fit.margin == 0.0);
        body->selfCollision = true;
        ck_assert(FitsAnew(&bvh, body, 0.5) && !bvh.fit.isLocal && bvh.fit.margin == 0.5);
        body->activity = qc_activitySleeping;
        ck_assert(FitsAnew(&bvh, body, 0.5) && bvh.fit.isLocal);
        body->activity = qc_activityMoving;
        body->selfCollision = false;
        ck_assert(!FitsAnew(&bvh, body, 0.5));
    }
    qcTriangleBvh_Free(&bvh);
    qcBodies_Free(&bodies);
    qcSoup_Free(&soup);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS("rigid_transform", a_transform_is_invertible_up_to_a_condition_number_of_4096,
             a_transform_without_an_inverse_in_double_is_not_invertible,
             points_that_coincide_in_the_world_coincide_in_local_coordinates,
             reach_and_stretch_are_those_of_the_inverse_and_growth_is_that_of_the_transform,
             the_box_of_a_moved_body_contains_its_rounded_vertices, an_identity_may_have_zeros_of_either_sign,
             a_transform_that_overflows_for_a_vertex_is_refused,
             a_body_without_triangles_has_an_empty_box_under_any_transform,
             a_rigid_body_without_self_collision_is_fitted_once)
