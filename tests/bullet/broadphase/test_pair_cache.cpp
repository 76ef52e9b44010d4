// The pair cache that qcBroadphase makes, beside a btHashedOverlappingPairCache that it is given: the same pairs in the
// same order, whatever is added at once.
#include "bullet/broadphase/broadphase_model.h"

namespace
{
/// Boxes of edge 1 in a cube so dense that each overlaps about `density` others.
void CreateBoxes(qcBroadphaseModel& model, uint64_t seed, uint32_t count, double density)
{
    qcRandom random = {seed};
    const double side = std::cbrt(8.0 * count / density);
    for (uint32_t i = 0; i < count; i++)
    {
        btVector3 corner;
        for (int k = 0; k < 3; k++)
            corner[k] = btScalar(qcRandom_Uniform(&random, 0.0, side));
        model.Create(corner, corner + btVector3(1, 1, 1));
    }
}

void CheckSameOrder(qcBroadphaseModel& own, qcBroadphaseModel& given)
{
    own.broadphase.calculateOverlappingPairs(&own.dispatcher);
    given.broadphase.calculateOverlappingPairs(&given.dispatcher);
    const btBroadphasePairArray &a = own.cache->getOverlappingPairArray(), &b = given.cache->getOverlappingPairArray();
    ck_assert_int_eq(a.size(), b.size());
    for (int i = 0; i < a.size(); i++)
    {
        CHECK_QUICKLY(a[i].m_pProxy0->m_uniqueId == b[i].m_pProxy0->m_uniqueId);
        CHECK_QUICKLY(a[i].m_pProxy1->m_uniqueId == b[i].m_pProxy1->m_uniqueId);
        CHECK_QUICKLY(own.cache->findPair(a[i].m_pProxy0, a[i].m_pProxy1) == &a[i]);
    }
}

void Check(uint32_t first, uint32_t second, double density)
{
    btHashedOverlappingPairCache cache;
    qcBroadphaseModel own, given(&cache);
    for (qcBroadphaseModel* model : {&own, &given})
        CreateBoxes(*model, 1, first, density);
    CheckSameOrder(own, given);
    for (qcBroadphaseModel* model : {&own, &given})
        CreateBoxes(*model, 2, second, density);
    CheckSameOrder(own, given);
    ck_assert_int_gt(own.cache->getNumOverlappingPairs(), 0);
    // Every second box goes, and others come.
    for (qcBroadphaseModel* model : {&own, &given})
        for (size_t i = model->proxies.size() / 2; i-- > 0;)
            model->Destroy(2 * i);
    CheckSameOrder(own, given);
    for (qcBroadphaseModel* model : {&own, &given})
        CreateBoxes(*model, 3, second, density);
    CheckSameOrder(own, given);
}
} // namespace

START_TEST(pairs_of_many_new_boxes_are_in_the_order_of_bullets_own_cache)
{
    // No pairs before, few, many; few new ones; so dense that the first boxes have pairs before the search.
    Check(0, 3000, 4);
    Check(20, 3000, 4);
    Check(800, 3000, 8);
    Check(3000, 40, 4);
    Check(2, 700, 300);
    Check(80, 81, 900);
}
END_TEST

QC_RUN_TESTS("pair cache", pairs_of_many_new_boxes_are_in_the_order_of_bullets_own_cache)
