// A set of boxes beside a plain list of the same boxes: the list is asked box by box, the set must say the same.
#ifndef QC_TESTS_BOX_MODEL_H
#define QC_TESTS_BOX_MODEL_H

#include "box_set.h"
#include "check_ok.h"
#include "soups.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/// For loops that run a million times: ck_assert writes to a file each time that it is passed.
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

/// Each box's user data is its place in the list.
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

static inline bool qcModel_Meet(const double lowerA[3], const double upperA[3], const double lowerB[3],
                                const double upperB[3])
{
    for (int k = 0; k < 3; k++)
        if (lowerA[k] > upperB[k] || lowerB[k] > upperA[k])
            return false;
    return true;
}

/// Asks the set for the pairs of moved boxes, and the list box by box. Returns their number.
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
                !qcModel_Meet(x->lower, x->upper, y->lower, y->upper))
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

/// Every node holds its children and is in balance; every leaf holds its box; nothing hangs elsewhere.
static inline void qcModel_CheckTree(const qcModel* model)
{
    const qcBoxTree* tree = &model->set->tree;
    uint32_t stack[qc_treeStack], count = 0, leaves = 0;
    if (tree->root != QC_NO_NODE)
    {
        ck_assert_uint_eq(qcBoxTree_Node(tree, tree->root)->parent, QC_NO_NODE);
        stack[count++] = tree->root;
    }
    while (count > 0)
    {
        uint32_t at = stack[--count];
        const qcTreeNode* node = qcBoxTree_Node(tree, at);
        if (node->height == 0)
        {
            const qcModelBox* box = &model->boxes[node->child[0]];
            CHECK_QUICKLY(box->alive);
            CHECK_QUICKLY(qcBounds_Contain(node->lower, node->upper, box->lower, box->upper));
            leaves++;
            continue;
        }
        const qcTreeNode *x = qcBoxTree_Node(tree, node->child[0]), *y = qcBoxTree_Node(tree, node->child[1]);
        CHECK_QUICKLY(x->parent == at);
        CHECK_QUICKLY(y->parent == at);
        CHECK_QUICKLY(qcBounds_Contain(node->lower, node->upper, x->lower, x->upper));
        CHECK_QUICKLY(qcBounds_Contain(node->lower, node->upper, y->lower, y->upper));
        CHECK_QUICKLY(node->height == 1 + (x->height > y->height ? x->height : y->height));
        CHECK_QUICKLY(x->height <= y->height + qc_treeSlack);
        CHECK_QUICKLY(y->height <= x->height + qc_treeSlack);
        stack[count++] = node->child[0];
        stack[count++] = node->child[1];
    }
    ck_assert_uint_eq(leaves, qcBoxes_GetCount(model->set));
}

#endif
