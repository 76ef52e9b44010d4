// Boxes that overlap none, against brute force; stretched chains, against exact distances and certificates.
#include "soft_body/scene/lone_bodies.h"

#include "quickcullide/scene.h"

#include "bullet/random_numbers.h"

#include <array>
#include <limits>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
using NodePositions = std::vector<btVector3>;

struct Box
{
    btVector3 lower, upper;
    bool needsPartner;
};

bool Overlap(const Box& a, const Box& b)
{
    bool overlap = !(a.needsPartner && b.needsPartner);
    for (int axis = 0; axis < 3; axis++)
        overlap = overlap && a.lower[axis] <= b.upper[axis] && b.lower[axis] <= a.upper[axis];
    return overlap;
}

/// A link as a triangle.
std::array<double, 9> LinkOf(const NodePositions& positions, size_t link)
{
    std::array<double, 9> corners;
    for (size_t i = 0; i < 9; i++)
        corners[i] = double(positions[link + (i >= 3)][int(i % 3)]);
    return corners;
}

/// A chain of six nodes along `direction`, crooked by `noise`, far from the origin.
NodePositions MakeChain(qcRandomNumbers& random, const btVector3& direction, double noise)
{
    NodePositions chain;
    const btVector3 place = random.Vector(50);
    for (int i = 0; i < 6; i++)
        chain.push_back(place + direction * btScalar(i) + random.Vector(noise));
    return chain;
}

void CheckApart(const NodePositions& start, const NodePositions& end, btScalar distance)
{
    double direction[3];
    for (size_t a = 0; a + 1 < end.size(); a++)
        for (size_t b = a + 2; b + 1 < end.size(); b++)
        {
            ck_assert(!qcTrianglesWithin(LinkOf(end, a).data(), LinkOf(end, b).data(), double(distance), nullptr));
            ck_assert(qcTrianglesStayApart(LinkOf(start, a).data(), LinkOf(end, a).data(), LinkOf(start, b).data(),
                                           LinkOf(end, b).data(), direction));
        }
}
} // namespace

START_TEST(boxes_that_overlap_another_one_are_found)
{
    int found[2] = {0, 0};
    for (unsigned run = 1; run <= 500; run++)
    {
        qcRandomNumbers random(run);
        std::vector<Box> boxes;
        qcMotionBoxes motion;
        for (int i = 0; i < 20; i++)
        {
            // Whole numbers: boxes touch.
            btVector3 lower(btScalar(int(random.Number(0, 9))), btScalar(int(random.Number(0, 9))),
                            btScalar(int(random.Number(0, 9))));
            btScalar size = btScalar(int(random.Number(0, 4)));
            boxes.push_back({lower, lower + btVector3(size, size, size), random.Number(0, 1) < btScalar(0.4)});
            motion.Add(boxes.back().lower, boxes.back().upper, boxes.back().needsPartner);
        }
        motion.Find();
        for (size_t i = 0; i < boxes.size(); i++)
        {
            bool overlaps = false;
            for (size_t k = 0; k < boxes.size(); k++)
                overlaps = overlaps || (i != k && Overlap(boxes[i], boxes[k]));
            ck_assert(motion.Overlaps(i) == overlaps);
            found[overlaps]++;
        }
    }
    ck_assert(found[0] > 500 && found[1] > 500);
    qcMotionBoxes none;
    none.Find();
}
END_TEST

START_TEST(links_of_a_stretched_chain_are_apart_over_the_step)
{
    int found[2] = {0, 0};
    for (unsigned run = 1; run <= 4000; run++)
    {
        qcRandomNumbers random(run);
        btVector3 direction = random.Vector(1);
        const double noise = double(random.Number(0, 0.6));
        NodePositions start = MakeChain(random, direction + random.Vector(noise), noise),
                      end = MakeChain(random, direction, noise);
        btScalar distance = random.Number(0.05, 0.5);
        bool isStretched = qcIsStretchedChain(start, end, distance);
        found[isStretched]++;
        if (isStretched)
            CheckApart(start, end, distance);
    }
    ck_assert(found[0] > 500 && found[1] > 500);
}
END_TEST

START_TEST(a_folded_loose_or_infinite_chain_is_not_stretched)
{
    NodePositions chain;
    for (int i = 0; i < 5; i++)
        chain.emplace_back(btScalar(i), btScalar(0), btScalar(0));
    ck_assert(qcIsStretchedChain(chain, chain, btScalar(0.9)));
    ck_assert(!qcIsStretchedChain(chain, chain, btScalar(1)));
    // The last node lies back over the other links, but only a link away from its neighbour.
    for (size_t folded : {size_t(0), size_t(4)})
        for (bool atStart : {false, true})
        {
            NodePositions other = chain;
            other[folded] = btVector3(2, btScalar(0.01), 0);
            ck_assert(!qcIsStretchedChain(atStart ? other : chain, atStart ? chain : other, btScalar(0.1)));
        }
    NodePositions infinite = chain;
    infinite[2].setY(std::numeric_limits<btScalar>::quiet_NaN());
    ck_assert(!qcIsStretchedChain(chain, infinite, btScalar(0.1)) &&
              !qcIsStretchedChain(infinite, chain, btScalar(0.1)));
    const NodePositions same(5, btVector3(1, 2, 3));
    ck_assert(!qcIsStretchedChain(same, same, 0));
    // Links of three nodes have a common one.
    ck_assert(qcIsStretchedChain({same[0], same[1], same[2]}, {same[0], same[1], same[2]}, btScalar(0.1)));
}
END_TEST

START_TEST(a_motion_box_holds_the_motion_and_its_reach)
{
    qcRandomNumbers random(1);
    for (int i = 0; i < 200; i++)
    {
        NodePositions start = MakeChain(random, random.Vector(1), 1), end = MakeChain(random, random.Vector(1), 1);
        const btScalar reach = random.Number(0, 1);
        btVector3 box[2];
        ck_assert(qcFindMotionBox(start, end, reach, box));
        for (const NodePositions* nodes : {&start, &end})
            for (const btVector3& node : *nodes)
                for (int axis = 0; axis < 3; axis++)
                    ck_assert(double(box[0][axis]) <= double(node[axis]) - double(reach) &&
                              double(box[1][axis]) >= double(node[axis]) + double(reach));
        start[3].setZ(std::numeric_limits<btScalar>::infinity());
        ck_assert(!qcFindMotionBox(start, end, reach, box) && !qcFindMotionBox({}, {}, reach, box));
    }
}
END_TEST

QC_RUN_TESTS("lone_bodies", boxes_that_overlap_another_one_are_found,
             links_of_a_stretched_chain_are_apart_over_the_step, a_folded_loose_or_infinite_chain_is_not_stretched,
             a_motion_box_holds_the_motion_and_its_reach)
