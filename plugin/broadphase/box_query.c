// Traversal of the BVH forest: the list of new boxes first, then each tree from its root.
#include "broadphase/box_query.h"

#include <math.h>
#include <string.h>

bool qcHostFunction_Call(uint32_t id, void* userData, void* context)
{
    qcHostFunction* host = context;
    qcFloatMode_End(host->mode);
    bool more = host->function(id, userData, host->context);
    host->mode = qcFloatMode_Begin();
    return more;
}

qcBoxQuery qcBoxQuery_Make(const qcBoxes* set, const double lower[3], const double upper[3], qcBoxFunction* function,
                           void* context)
{
    qcBoxQuery query = {.set = set, .function = function, .context = context};
    for (int k = 0; k < 3; k++)
    {
        query.bounds.lower[k] = isnan(lower[k]) ? -INFINITY : lower[k];
        query.bounds.upper[k] = isnan(upper[k]) ? INFINITY : upper[k];
    }
    query.exact = qcBoxOrigin_Enclose(&set->origin, &query.box, query.bounds.lower, query.bounds.upper);
    return query;
}

qcBoxQuery qcBoxQuery_MakeFor(const qcBoxes* set, uint32_t id, qcBoxFunction* function, void* context)
{
    const qcBox* box = qcBoxes_Box(set, id);
    // Field by field: clearing the struct first takes longer.
    qcBoxQuery query;
    query.set = set;
    query.bounds = qcBoxes_Bounds(set, id);
    memcpy(query.box.lower, box->lower, sizeof box->lower);
    memcpy(query.box.upper, box->upper, sizeof box->upper);
    query.exact = box->exact;
    query.fat = false;
    query.function = function;
    query.context = context;
    return query;
}

static bool Overlaps(const qcBoxQuery* query, uint32_t id)
{
    const qcBox* box = qcBoxes_Box(query->set, id);
    bool overlap = qcBox_OverlapsFloats(box, query->box.lower, query->box.upper);
    if (!overlap || (box->exact & query->exact))
        return overlap;
    qcBounds bounds = qcBoxes_Bounds(query->set, id);
    return qcBounds_Overlap(&bounds, &query->bounds);
}

static inline bool Test(const qcBoxQuery* query, uint32_t id)
{
    if (!query->fat && !Overlaps(query, id))
        return true;
    return query->function(id, QC_AT(void*, query->set->userData, id), query->context);
}

bool qcBoxQuery_Test(const qcBoxQuery* query, uint32_t id)
{
    return Test(query, id);
}

static bool TestLanes(const qcBoxQuery* query, const qcOctet* octet, const uint32_t* ids)
{
    uint32_t lanes = query->set->forest.kernels->overlap(octet, &query->box);
    for (; lanes != 0; lanes &= lanes - 1)
        if (!Test(query, ids[__builtin_ctz(lanes)]))
            return false;
    return true;
}

static bool TestList(const qcBoxQuery* query)
{
    const qcForest* forest = &query->set->forest;
    for (size_t i = 0; i < forest->listIds.count; i += qc_lanes)
        if (!TestLanes(query, &QC_AT(qcOctet, forest->listOctets, i / qc_lanes), &QC_AT(uint32_t, forest->listIds, i)))
            return false;
    return true;
}

typedef struct Node
{
    uint32_t level, octet;
} Node;

static bool TestTree(const qcBoxQuery* query, const qcBoxTree* tree)
{
    const qcOctetTree* shape = &tree->shape;
    Node stack[7 * qc_treeLevels + 1];
    uint32_t stackCount = 1;
    stack[0] = (Node){shape->levelCount - 1, 0};
    while (stackCount > 0)
    {
        Node node = stack[--stackCount];
        const qcOctet* octet = &shape->octets[shape->first[node.level] + node.octet];
        if (node.level == 0)
        {
            if (!TestLanes(query, octet, &QC_AT(uint32_t, tree->ids, (size_t)qc_lanes * node.octet)))
                return false;
            continue;
        }
        uint32_t lanes = query->set->forest.kernels->overlap(octet, &query->box);
        for (; lanes != 0; lanes &= lanes - 1)
            stack[stackCount++] = (Node){node.level - 1, qc_lanes * node.octet + (uint32_t)__builtin_ctz(lanes)};
    }
    return true;
}

void qcBoxQuery_Run(const qcBoxQuery* query, unsigned parts)
{
    const qcForest* forest = &query->set->forest;
    bool more = (parts & qc_dynamicBoxes) == 0 || TestList(query);
    uint64_t trees = ((parts & qc_dynamicBoxes) != 0 ? forest->dynamicTrees : 0) |
                     ((parts & qc_staticBoxes) != 0 ? forest->staticTrees : 0);
    while (more && trees != 0)
        more = TestTree(query, &forest->trees[qcForest_NextTree(&trees)]);
}
