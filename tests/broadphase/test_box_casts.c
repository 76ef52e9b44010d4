// Ray and swept-box casts against rational arithmetic: every box that is hit is visited, few others are.
#include "broadphase/box_model.h"
#include "support/suite.h"

#include <gmp.h>

typedef struct Path
{
    double from[3], to[3], castLower[3], castUpper[3];
} Path;

/// The exact fraction of the path at which the box is first hit. False: it is not hit up to `last`. All numbers are
/// finite.
static bool HitExactly(const Path* path, const double lower[3], const double upper[3], double last, mpq_t entry)
{
    mpq_t leave, p, d, side[2], low;
    mpq_inits(leave, p, d, side[0], side[1], low, NULL);
    mpq_set_ui(entry, 0, 1);
    mpq_set_d(leave, last);
    bool hit = true;
    for (int k = 0; k < 3; k++)
    {
        mpq_set_d(p, path->from[k]);
        mpq_set_d(d, path->to[k]);
        mpq_sub(d, d, p);
        for (int s = 0; s < 2; s++)
        {
            // The swept box's upper side touches the lower side of the box, and the reverse.
            mpq_set_d(side[s], s == 0 ? lower[k] : upper[k]);
            mpq_set_d(low, s == 0 ? path->castUpper[k] : path->castLower[k]);
            mpq_sub(side[s], side[s], low);
            mpq_sub(side[s], side[s], p);
        }
        if (mpq_sgn(d) == 0)
        {
            hit = hit && mpq_sgn(side[0]) <= 0 && mpq_sgn(side[1]) >= 0;
            continue;
        }
        int first = mpq_sgn(d) > 0 ? 0 : 1;
        mpq_div(side[0], side[0], d);
        mpq_div(side[1], side[1], d);
        if (mpq_cmp(side[first], entry) > 0)
            mpq_set(entry, side[first]);
        if (mpq_cmp(side[1 - first], leave) < 0)
            mpq_set(leave, side[1 - first]);
    }
    hit = hit && mpq_cmp(entry, leave) <= 0;
    mpq_clears(leave, p, d, side[0], side[1], low, NULL);
    return hit;
}

typedef struct Visits
{
    uint8_t times[qc_modelRoom];
    uint32_t total;
    double fraction;
    const Path* shortening; ///< each visit ends this path where its box is hit; null: no visit ends the query
    const qcModel* model;
} Visits;

static bool Visit(uint32_t id, void* userData, void* context)
{
    (void)userData;
    Visits* visits = context;
    visits->times[id]++;
    visits->total++;
    if (visits->shortening != NULL)
    {
        mpq_t entry;
        mpq_init(entry);
        const qcModelBox* box = &visits->model->boxes[id];
        if (HitExactly(visits->shortening, box->lower, box->upper, visits->fraction, entry))
            visits->fraction = mpq_get_d(entry); // rounds down
        mpq_clear(entry);
    }
    return true;
}

/// Returns the number of boxes that are hit; adds the number of boxes visited in vain to `*inVain`.
static uint32_t CheckCast(const qcModel* model, const Path* path, bool shorten, uint32_t* inVain)
{
    Visits visits = {.fraction = 1.0, .shortening = shorten ? path : NULL, .model = model};
    qcBoxes_CastBox(model->set, path->from, path->to, path->castLower, path->castUpper, &visits.fraction, Visit,
                    &visits);
    uint32_t hits = 0;
    mpq_t entry;
    mpq_init(entry);
    for (uint32_t id = 0; id < model->ends; id++)
    {
        const qcModelBox* box = &model->boxes[id];
        CHECK_QUICKLY(visits.times[id] <= box->alive);
        // A box hit up to the end of the path must have been visited, in any order.
        if (box->alive && HitExactly(path, box->lower, box->upper, visits.fraction, entry))
        {
            if (visits.times[id] == 0)
                ck_abort_msg("box %u is hit at %.17g and was not visited", id, mpq_get_d(entry));
            hits++;
        }
        else if (!shorten)
            *inVain += visits.times[id];
    }
    mpq_clear(entry);
    return hits;
}

static void Scale(double v[3], double factor)
{
    for (int k = 0; k < 3; k++)
        v[k] *= factor;
}

/// Boxes and paths on a grid of integers, so that paths run along faces and through edges and corners, times a factor,
/// so that sums round.
static void CastThroughGrid(uint64_t seed, double factor, double offset, bool swept)
{
    qcRandom random = {seed};
    qcModel* model = qcModel_Make();
    for (int i = 0; i < 200; i++)
    {
        double lower[3], upper[3];
        for (int k = 0; k < 3; k++)
        {
            lower[k] = offset + qcRandom_Integer(&random, 0, 12);
            upper[k] = lower[k] + qcRandom_Integer(&random, 0, 2);
        }
        Scale(lower, factor);
        Scale(upper, factor);
        qcModel_Add(model, lower, upper);
    }
    uint32_t hits = 0, inVain = 0;
    for (int i = 0; i < 70; i++)
    {
        Path path = {.castLower = {0}};
        for (int k = 0; k < 3; k++)
        {
            path.from[k] = offset + qcRandom_Integer(&random, -2, 14);
            // Many are parallel to an axis or to a plane, some have no length.
            path.to[k] = qcRandom_Below(&random, 2) ? path.from[k] : offset + qcRandom_Integer(&random, -2, 14);
            if (swept)
            {
                path.castLower[k] = -qcRandom_Integer(&random, 0, 2);
                path.castUpper[k] = qcRandom_Integer(&random, 0, 2);
            }
        }
        Scale(path.from, factor);
        Scale(path.to, factor);
        Scale(path.castLower, factor);
        Scale(path.castUpper, factor);
        hits += CheckCast(model, &path, false, &inVain);
        CheckCast(model, &path, true, NULL);
    }
    ck_assert_uint_gt(hits, 60);
    // Few boxes are visited in vain: those that the path misses by rounding. Directions without an inverse are an
    // exception.
    ck_assert(factor < 1e-300 || inVain < hits / 2);
    qcModel_Free(model);
}

START_TEST(each_box_hit_is_visited_also_at_faces_edges_and_corners)
{
    for (uint64_t seed = 1; seed <= 2; seed++)
        for (int swept = 0; swept <= 1; swept++)
        {
            CastThroughGrid(seed, 1.0, 0.0, swept);
            CastThroughGrid(seed, 0.1, 0.0, swept);
            CastThroughGrid(seed, 1.0 / 3.0, 1000.0, swept);
            CastThroughGrid(seed, 1e-160, 0.0, swept);
            CastThroughGrid(seed, 0x1p-1074, 0.0, swept);
            // So far from zero that floats are relative to an origin.
            CastThroughGrid(seed, 1.0, 1e9, swept);
            CastThroughGrid(seed, 1.0 / 3.0, -3e14, swept);
            CastThroughGrid(seed, 1e-30, 1e12, swept);
            // The ends of the range of floats.
            CastThroughGrid(seed, 3e-38, 0.0, swept);
            CastThroughGrid(seed, 1e-38, 1e-30, swept);
            CastThroughGrid(seed, 1e36, 0.0, swept);
            CastThroughGrid(seed, 1e38, 0.0, swept);
            CastThroughGrid(seed, 1e300, 0.0, swept);
        }
}
END_TEST

START_TEST(each_box_hit_is_visited_in_general_position)
{
    qcRandom random = {3};
    qcModel* model = qcModel_Make();
    uint32_t hits = 0, inVain = 0;
    for (int i = 0; i < 1000; i++)
    {
        double lower[3], upper[3];
        for (int k = 0; k < 3; k++)
        {
            lower[k] = qcRandom_Uniform(&random, -10.0, 10.0);
            upper[k] = lower[k] + qcRandom_Uniform(&random, 0.0, 2.0);
        }
        qcModel_Add(model, lower, upper);
    }
    for (int i = 0; i < 100; i++)
    {
        Path path = {.castLower = {0}};
        for (int k = 0; k < 3; k++)
        {
            path.from[k] = qcRandom_Uniform(&random, -12.0, 12.0);
            path.to[k] = qcRandom_Uniform(&random, -12.0, 12.0);
            path.castUpper[k] = i % 2 ? 0.0 : qcRandom_Uniform(&random, 0.0, 1.0);
            path.castLower[k] = i % 2 ? 0.0 : -path.castUpper[k];
        }
        hits += CheckCast(model, &path, false, &inVain);
        CheckCast(model, &path, true, NULL);
    }
    ck_assert_uint_gt(hits, 500);
    ck_assert_uint_eq(inVain, 0);
    qcModel_Free(model);
}
END_TEST

START_TEST(near_boxes_come_first_so_that_a_shortened_path_visits_few)
{
    qcModel* model = qcModel_Make();
    for (int i = 0; i < 1000; i++)
        qcModel_Add(model, (double[3]){2 * i, 0, 0}, (double[3]){2 * i + 1, 1, 1});
    Path path = {{-1, 0.5, 0.5}, {2001, 0.5, 0.5}, {0, 0, 0}, {0, 0, 0}};
    Visits visits = {.fraction = 1.0, .shortening = &path, .model = model};
    qcBoxes_CastBox(model->set, path.from, path.to, path.castLower, path.castUpper, &visits.fraction, Visit, &visits);
    ck_assert_uint_eq(visits.times[0], 1);
    ck_assert_uint_le(visits.total, 10);
    path = (Path){{2001, 0.5, 0.5}, {-1, 0.5, 0.5}, {0, 0, 0}, {0, 0, 0}};
    visits = (Visits){.fraction = 1.0, .shortening = &path, .model = model};
    qcBoxes_CastBox(model->set, path.from, path.to, path.castLower, path.castUpper, &visits.fraction, Visit, &visits);
    ck_assert_uint_eq(visits.times[999], 1);
    ck_assert_uint_le(visits.total, 10);
    qcModel_Free(model);
}
END_TEST

static uint32_t CountVisits(const qcModel* model, const Path* path, const double* fraction)
{
    Visits visits = {.model = model};
    qcBoxes_CastBox(model->set, path->from, path->to, path->castLower, path->castUpper, fraction, Visit, &visits);
    return visits.total;
}

START_TEST(infinite_boxes_and_paths_are_hit)
{
    const double inf = INFINITY;
    qcModel* model = qcModel_Make();
    qcModel_Add(model, (double[3]){-inf, -inf, -inf}, (double[3]){inf, inf, inf});
    qcModel_Add(model, (double[3]){-inf, -inf, -inf}, (double[3]){inf, 0, inf}); // below y = 0
    qcModel_Add(model, (double[3]){-1e18, -1e18, -1e18}, (double[3]){1e18, 1e18, 1e18});
    qcModel_Add(model, (double[3]){5, 0, 0}, (double[3]){6, 1, 1});
    static const Path paths[] = {
        // Along the x axis, in the face of the half space and of the last box.
        {{0, 0, 0}, {10, 0, 0}, {0, 0, 0}, {0, 0, 0}},
        // To infinity.
        {{0, 0, 0}, {INFINITY, 0, 0}, {0, 0, 0}, {0, 0, 0}},
        {{-INFINITY, 0, 0}, {INFINITY, 0, 0}, {0, 0, 0}, {0, 0, 0}},
        {{0, 0, 0}, {1.7e308, 0, 0}, {0, 0, 0}, {0, 0, 0}},
        {{-1.7e308, 0, 0}, {1.7e308, 0, 0}, {0, 0, 0}, {0, 0, 0}},
        // Not moving, as large as everything.
        {{0, 0, 0}, {0, 0, 0}, {-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}},
        // A path that is not a number hits everything.
        {{NAN, NAN, NAN}, {NAN, NAN, NAN}, {0, 0, 0}, {0, 0, 0}},
        {{0, 0, 0}, {NAN, 0, 0}, {0, 0, 0}, {0, 0, 0}},
        {{NAN, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}},
        {{0, 0, 0}, {1, 0, 0}, {NAN, NAN, NAN}, {NAN, NAN, NAN}},
    };
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++)
        ck_assert_msg(CountVisits(model, &paths[i], NULL) == 4, "path %zu", i);
    // And one above the half space, ending before the last box.
    Path above = {{0, 1, 0}, {4, 1, 0}, {0, 0, 0}, {0, 0, 0}};
    ck_assert_uint_eq(CountVisits(model, &above, NULL), 2);
    qcModel_Free(model);
}
END_TEST

START_TEST(paths_at_infinity_hit_the_boxes_that_reach_it)
{
    static const Path paths[] = {
        {{0, INFINITY, 0}, {1, INFINITY, 0}, {0, 0, 0}, {0, 0, 0}},
        {{0, INFINITY, 0}, {1, INFINITY, 0}, {-1, -1, -1}, {1, 1, 1}},
        {{0, INFINITY, 0}, {0, INFINITY, 0}, {0, 0, 0}, {0, 0, 0}},
        {{INFINITY, INFINITY, INFINITY}, {INFINITY, INFINITY, INFINITY}, {0, 0, 0}, {0, 0, 0}},
    };
    // One box in the list, then many in a tree.
    for (int count = 1; count <= 1000; count += 999)
        for (size_t i = 0; i < sizeof paths / sizeof *paths; i++)
            for (int sign = -1; sign <= 1; sign += 2)
            {
                const double all[2][3] = {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
                qcModel* model = qcModel_Make();
                qcModel_Add(model, all[0], all[1]);
                for (int j = 1; j < count; j++)
                    qcModel_Add(model, (double[3]){j, 0, 0}, (double[3]){j + 0.5, 1, 1});
                if (count > 1)
                    qcModel_CheckMovedPairs(model);
                Path path = paths[i];
                Scale(path.from, sign);
                Scale(path.to, sign);
                ck_assert_msg(CountVisits(model, &path, NULL) == 1, "%d boxes, path %zu, sign %d", count, i, sign);
                qcModel_Free(model);
            }
}
END_TEST

START_TEST(a_coordinate_that_is_nan_makes_its_axis_unbounded)
{
    // One box in the list, then many in a tree.
    for (int count = 1; count <= 1000; count += 999)
    {
        qcModel* model = qcModel_Make();
        // Above and below all paths in y.
        for (int i = 0; i < count; i++)
            qcModel_Add(model, (double[3]){2, i % 2 ? -6 : 15, 0}, (double[3]){3, i % 2 ? -5 : 16, 1});
        if (count > 1)
            qcModel_CheckMovedPairs(model);
        for (unsigned nans = 0; nans < 16; nans++)
            for (int moving = 0; moving <= 1; moving++)
            {
                Path path = {{0, moving ? -1 : 10, 0.5}, {10, moving ? 11 : 10, 0.5}, {0, 0, 0}, {0, 0, 0}};
                double* coordinates[4] = {&path.from[1], &path.to[1], &path.castLower[1], &path.castUpper[1]};
                for (int i = 0; i < 4; i++)
                    if ((nans >> i & 1) != 0)
                        *coordinates[i] = NAN;
                ck_assert_msg(CountVisits(model, &path, NULL) == (nans != 0 ? (uint32_t)count : 0),
                              "%d boxes, NaN in %x, %d", count, nans, moving);
            }
        qcModel_Free(model);
    }
}
END_TEST

START_TEST(a_fraction_given_beforehand_ends_the_path)
{
    qcModel* model = qcModel_Make();
    for (int i = 0; i < 10; i++)
        qcModel_Add(model, (double[3]){i, 0, 0}, (double[3]){i + 0.5, 1, 1});
    Path path = {{-1, 0.5, 0.5}, {19, 0.5, 0.5}, {0, 0, 0}, {0, 0, 0}};
    const double quarter = 0.25, none = 0.0;
    ck_assert_uint_eq(CountVisits(model, &path, NULL), 10);
    ck_assert_uint_eq(CountVisits(model, &path, &quarter), 5); // up to x = 4, where the fifth begins
    ck_assert_uint_eq(CountVisits(model, &path, &none), 0);
    qcModel_Free(model);
}
END_TEST

QC_RUN_TESTS("box casts", each_box_hit_is_visited_also_at_faces_edges_and_corners,
             each_box_hit_is_visited_in_general_position, near_boxes_come_first_so_that_a_shortened_path_visits_few,
             infinite_boxes_and_paths_are_hit, paths_at_infinity_hit_the_boxes_that_reach_it,
             a_coordinate_that_is_nan_makes_its_axis_unbounded, a_fraction_given_beforehand_ends_the_path)
