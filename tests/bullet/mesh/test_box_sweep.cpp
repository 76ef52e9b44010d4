// The pairs of swept objects whose boxes are compared: all that count, and few others, wherever the objects lie.
#include "mesh_contact/limits/box_sweep.h"

#include "bullet/random_numbers.h"

#include <memory>
#include <set>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
constexpr int s_side = 40;

struct Boxes
{
    std::vector<std::unique_ptr<qcSweptObject>> kept;
    std::vector<qcSweptObject*> all;

    qcSweptObject* Add(const btVector3& centre, const btVector3& half, bool isOurs, bool moves)
    {
        kept.push_back(std::make_unique<qcSweptObject>());
        qcSweptObject* swept = kept.back().get();
        swept->number = uint32_t(kept.size());
        swept->lower = centre - half;
        swept->upper = centre + half;
        swept->isOurs = isOurs;
        swept->moves = moves;
        all.push_back(swept);
        return swept;
    }
    /// Boxes that don't overlap, in a plane.
    void AddWall(int normal, bool isOurs)
    {
        const btScalar half = btScalar(0.3);
        for (int i = 0; i < s_side * s_side; i++)
        {
            btVector3 centre(0, 0, 0);
            centre[(normal + 1) % 3] = btScalar(i % s_side);
            centre[(normal + 2) % 3] = btScalar(i / s_side) * btScalar(1.1);
            Add(centre, btVector3(half, half, half), isOurs, true);
        }
    }
    size_t CountVisits() const
    {
        size_t visits = 0;
        qcSweepBoxes(all, [&visits](const qcSweptObject*, const qcSweptObject*) { visits++; });
        return visits;
    }
};

START_TEST(boxes_in_a_wall_are_compared_along_it)
{
    Boxes boxes;
    boxes.AddWall(_i, true);
    ck_assert_int_ne(qcAxisOfSpread(boxes.all), _i);
    ck_assert_uint_le(boxes.CountVisits(), size_t(s_side * s_side * s_side / 2));
}
END_TEST

START_TEST(objects_that_hold_no_mesh_of_ours_are_not_compared_with_each_other)
{
    Boxes boxes;
    boxes.AddWall(_i, false);
    ck_assert_uint_eq(boxes.CountVisits(), 0);
    boxes.Add(btVector3(0, 0, 0), btVector3(100, 100, 100), true, false);
    ck_assert_uint_eq(boxes.CountVisits(), size_t(s_side * s_side));
}
END_TEST

bool Overlap(const qcSweptObject& a, const qcSweptObject& b)
{
    for (int axis = 0; axis < 3; axis++)
        if (a.lower[axis] > b.upper[axis] || b.lower[axis] > a.upper[axis])
            return false;
    return true;
}

START_TEST(each_pair_that_counts_is_compared_once)
{
    qcRandomNumbers random(7);
    for (int run = 0; run < 50; run++)
    {
        Boxes boxes;
        const btVector3 extent(random.Number(0, 10), random.Number(0, 10), random.Number(0, 10));
        for (int i = 0; i < 60; i++)
            boxes.Add(random.Vector(1) * extent, btVector3(1, 1, 1) * random.Number(0.1, 3), random.Number(0, 2) < 1,
                      random.Number(0, 2) < 1);
        std::set<std::pair<uint32_t, uint32_t>> visited;
        qcSweepBoxes(boxes.all, [&visited](const qcSweptObject* a, const qcSweptObject* b)
                     { ck_assert(visited.insert(std::minmax(a->number, b->number)).second); });
        for (const qcSweptObject* a : boxes.all)
            for (const qcSweptObject* b : boxes.all)
                if (a->number < b->number && (a->isOurs || b->isOurs) && (a->moves || b->moves) && Overlap(*a, *b))
                    ck_assert_uint_eq(visited.count({a->number, b->number}), 1);
    }
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("box sweep");
    tcase_add_loop_test(tests, boxes_in_a_wall_are_compared_along_it, 0, 3);
    tcase_add_loop_test(tests, objects_that_hold_no_mesh_of_ours_are_not_compared_with_each_other, 0, 3);
    tcase_add_test(tests, each_pair_that_counts_is_compared_once);
    return qcRunCase("box sweep", tests);
}
