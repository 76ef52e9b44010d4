// A reference model of a set of boxes: a plain list with brute-force queries. The set's results must equal the list's.
#ifndef QC_TESTS_BROADPHASE_BOX_MODEL_H
#define QC_TESTS_BROADPHASE_BOX_MODEL_H

#include "broadphase/box_set.h"
#include "support/check_ok.h"
#include "support/soups.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/// For loops that run a million times: ck_assert writes to a file each time it passes.
#define CHECK_QUICKLY(claim)                                                                                           \
    do                                                                                                                 \
    {                                                                                                                  \
        if (!(claim))                                                                                                  \
            ck_abort_msg("%s", #claim);                                                                                \
    } while (0)

enum
{
    qc_modelRoom = 4096
};

typedef struct qcModelBox
{
    bool alive, moved;
    double lower[3], upper[3];
} qcModelBox;

typedef struct qcModel
{
    qcBoxes* set;
    qcModelBox boxes[qc_modelRoom]; ///< by id
    uint32_t ends;                  ///< ids are below it
    uint8_t
        overlapped[qc_modelRoom * (size_t)qc_modelRoom / 8]; ///< pairs that overlapped at the last search for changes
} qcModel;

static inline qcModel* qcModel_Make(void)
{
    qcModel* model = calloc(1, sizeof *model);
    ck_assert_ptr_nonnull(model);
    CHECK_OK(qcBoxes_Create(&model->set));
    return model;
}

static inline void qcModel_Free(qcModel* model)
{
    qcBoxes_Destroy(model->set);
    free(model);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

/// True if a pair a < b overlapped at the last search for changes.
static inline bool qcModel_Overlapped(const qcModel* model, uint32_t a, uint32_t b)
{
    size_t bit = a * (size_t)qc_modelRoom + b;
    return (model->overlapped[bit / 8] >> bit % 8 & 1) != 0;
}

static inline void qcModel_SetOverlapped(qcModel* model, uint32_t a, uint32_t b, bool overlapped)
{
    size_t bit = a * (size_t)qc_modelRoom + b;
    model->overlapped[bit / 8] =
        (uint8_t)((model->overlapped[bit / 8] & ~(1u << bit % 8)) | (unsigned)overlapped << bit % 8);
}

/// Each box's user data is its address in the list.
static inline uint32_t qcModel_Add(qcModel* model, const double lower[3], const double upper[3])
{
    uint32_t lowestFree = 0, id;
    while (lowestFree < model->ends && model->boxes[lowestFree].alive)
        lowestFree++;
    ck_assert_uint_lt(lowestFree, qc_modelRoom);
    qcModelBox* box = &model->boxes[lowestFree];
    CHECK_OK(qcBoxes_Add(model->set, lower, upper, box, &id));
    ck_assert_uint_eq(id, lowestFree);
    if (id == model->ends)
        model->ends++;
    box->alive = box->moved = true;
    memcpy(box->lower, lower, sizeof box->lower);
    memcpy(box->upper, upper, sizeof box->upper);
    return id;
}

static inline void qcModel_Remove(qcModel* model, uint32_t id)
{
    CHECK_OK(qcBoxes_Remove(model->set, id));
    model->boxes[id].alive = false;
    for (uint32_t other = 0; other < model->ends; other++)
        qcModel_SetOverlapped(model, other < id ? other : id, other < id ? id : other, false);
}

static inline void qcModel_Move(qcModel* model, uint32_t id, const double lower[3], const double upper[3])
{
    qcModelBox* box = &model->boxes[id];
    CHECK_OK(qcBoxes_Move(model->set, id, lower, upper));
    for (int k = 0; k < 3; k++)
        box->moved = box->moved || box->lower[k] != lower[k] || box->upper[k] != upper[k];
    memcpy(box->lower, lower, sizeof box->lower);
    memcpy(box->upper, upper, sizeof box->upper);
}

static inline bool qcModel_Overlap(const double lowerA[3], const double upperA[3], const double lowerB[3],
                                   const double upperB[3])
{
    for (int k = 0; k < 3; k++)
        if (lowerA[k] > upperB[k] || lowerB[k] > upperA[k])
            return false;
    return true;
}

/// Compares the set's pairs of moved boxes with the list's. Returns their number.
static inline size_t qcModel_CheckMovedPairs(qcModel* model)
{
    const qcBoxPair* pairs;
    size_t count, expected = 0;
    CHECK_OK(qcBoxes_FindMovedPairs(model->set, &pairs, &count));
    for (uint32_t a = 0; a < model->ends; a++)
        for (uint32_t b = a + 1; b < model->ends; b++)
        {
            const qcModelBox *x = &model->boxes[a], *y = &model->boxes[b];
            if (!x->alive || !y->alive || (!x->moved && !y->moved) ||
                !qcModel_Overlap(x->lower, x->upper, y->lower, y->upper))
                continue;
            if (expected >= count || pairs[expected].a != a || pairs[expected].b != b)
                ck_abort_msg("pair %zu of %zu should be %u %u", expected, count, a, b);
            expected++;
        }
    ck_assert_uint_eq(count, expected);
    for (uint32_t a = 0; a < model->ends; a++)
        model->boxes[a].moved = false;
    return count;
}

/// Compares the set's changed pairs with the list's. Returns the number of changes.
static inline size_t qcModel_CheckChangedPairs(qcModel* model)
{
    qcBoxChanges changes;
    size_t began = 0, ended = 0;
    CHECK_OK(qcBoxes_FindChangedPairs(model->set, &changes));
    CHECK_QUICKLY(!changes.all);
    for (uint32_t a = 0; a < model->ends; a++)
        for (uint32_t b = a + 1; b < model->ends; b++)
        {
            const qcModelBox *x = &model->boxes[a], *y = &model->boxes[b];
            bool overlap = x->alive && y->alive && qcModel_Overlap(x->lower, x->upper, y->lower, y->upper);
            if (overlap == qcModel_Overlapped(model, a, b))
                continue;
            size_t at = overlap ? began++ : ended++;
            const qcBoxPair* pair = (overlap ? changes.began : changes.ended) + at;
            if (at >= (overlap ? changes.beganCount : changes.endedCount) || pair->a != a || pair->b != b)
                ck_abort_msg("pair %zu that %s should be %u %u", at, overlap ? "began" : "ended", a, b);
            qcModel_SetOverlapped(model, a, b, overlap);
        }
    ck_assert_uint_eq(changes.beganCount, began);
    ck_assert_uint_eq(changes.endedCount, ended);
    return began + ended;
}

/// Checks that a lane of the forest holds the box of its id, at the position stored for the id.
static inline void qcModel_CheckLane(const qcModel* model, const qcOctet* octet, uint32_t tree, uint32_t at,
                                     uint32_t id)
{
    const qcForest* forest = &model->set->forest;
    uint32_t lane = at % qc_lanes;
    const qcModelBox* box = &model->boxes[id];
    const qcLeafPosition* position = &QC_AT(qcLeafPosition, forest->positions, id);
    const qcFloatBox* fat = &QC_AT(qcFloatBox, forest->boxes, id);
    CHECK_QUICKLY(box->alive);
    CHECK_QUICKLY(position->tree == tree && position->lane == at);
    for (int k = 0; k < 3; k++)
    {
        CHECK_QUICKLY(octet->lower[k][lane] == fat->lower[k] && octet->upper[k][lane] == fat->upper[k]);
        double origin = model->set->origin.at[k];
        CHECK_QUICKLY((double)fat->lower[k] <= box->lower[k] - origin);
        CHECK_QUICKLY((double)fat->upper[k] >= box->upper[k] - origin);
    }
}

/// Checks that every lane bounds its box, or the octet below it, or is empty, and that the lanes of boxes which have
/// not moved are tight. Returns the number of boxes.
static inline uint32_t qcModel_CheckTree(const qcModel* model, uint32_t number)
{
    const qcBoxTree* tree = &model->set->forest.trees[number];
    const qcOctetTree* shape = &tree->shape;
    uint32_t boxes = 0;
    for (uint32_t i = 0; i < tree->laneCount; i++)
    {
        uint32_t id = QC_AT(uint32_t, tree->ids, i);
        const qcOctet* octet = &shape->octets[i / qc_lanes];
        if (id != QC_NO_BOX)
        {
            const qcBox* box = qcBoxes_Box(model->set, id);
            bool tight = (QC_AT(uint8_t, tree->tight, i / qc_lanes) >> i % qc_lanes & 1) != 0;
            qcModel_CheckLane(model, octet, number, i, id);
            CHECK_QUICKLY(tight == (box->stationary && box->exact));
        }
        boxes += id != QC_NO_BOX;
        for (int k = 0; id == QC_NO_BOX && k < 3; k++)
            CHECK_QUICKLY(isnan(octet->lower[k][i % qc_lanes]) && isnan(octet->upper[k][i % qc_lanes]));
    }
    for (uint32_t level = 1; level < shape->levelCount; level++)
        for (uint32_t i = 0; i < shape->first[level] - shape->first[level - 1]; i++)
        {
            qcFloatBox below = qcOctet_Around(&shape->octets[shape->first[level - 1] + i]);
            const qcOctet* octet = &shape->octets[shape->first[level] + i / qc_lanes];
            for (int k = 0; k < 3; k++)
                CHECK_QUICKLY(octet->lower[k][i % qc_lanes] <= below.lower[k] &&
                              octet->upper[k][i % qc_lanes] >= below.upper[k]);
        }
    CHECK_QUICKLY(boxes == tree->boxCount);
    return boxes;
}

/// Checks that every box is in the forest once, and that few trees are of one size.
static inline void qcModel_CheckForest(const qcModel* model)
{
    const qcForest* forest = &model->set->forest;
    uint32_t boxes = 0;
    CHECK_QUICKLY((forest->staticTrees & forest->dynamicTrees) == 0);
    for (uint32_t a = 0; a < qc_forestTrees; a++)
    {
        uint64_t bit = (uint64_t)1 << a,
                 same = (forest->staticTrees & bit) != 0 ? forest->staticTrees : forest->dynamicTrees;
        if (((forest->staticTrees | forest->dynamicTrees) & bit) == 0)
            continue;
        boxes += qcModel_CheckTree(model, a);
        for (same &= bit - 1; same != 0;)
        {
            uint32_t x = forest->trees[a].laneCount, y = forest->trees[qcForest_NextTree(&same)].laneCount;
            // Lanes come in eights.
            CHECK_QUICKLY(x + y + 3 * qc_lanes > 3 * (x < y ? x : y));
        }
    }
    for (size_t i = 0; i < forest->listIds.count; i++)
        qcModel_CheckLane(model, &QC_AT(qcOctet, forest->listOctets, i / qc_lanes), qc_inList, (uint32_t)i,
                          QC_AT(uint32_t, forest->listIds, i));
    uint32_t inserted = 0, stale = 0;
    for (uint32_t id = 0; id < model->ends; id++)
    {
        const qcBox* box = qcBoxes_Box(model->set, id);
        inserted += box->alive && box->state != qc_boxInTree;
        stale += box->alive && box->state == qc_boxPairsStale;
    }
    CHECK_QUICKLY(inserted == model->set->insertedCount && stale == model->set->staleCount);
    ck_assert_uint_eq(boxes + forest->listIds.count, qcBoxes_GetCount(model->set));
    ck_assert_uint_eq(forest->boxCount, qcBoxes_GetCount(model->set));
}

#endif
