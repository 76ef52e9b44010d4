// Insertion by branch and bound over surface area, rotations on the way up.
// After Bittner, Hapala, Havran: Fast insertion-based optimization of BVHs, 2013; Catto: Dynamic BVHs, GDC 2019.
//
// Why no box is missed: a node's bounds are the plain minimum and maximum of its children's, without arithmetic, and so
// contain every box below; areas, which round, only choose where a box goes.
//
// Infinite boxes: an extent counts as 1e100 at most (also infinity minus infinity, which is NaN), so that areas and
// their sums stay finite and comparable. Infinite boxes gather on one path from the root, as balance allows no branch
// shorter; all else is sorted among itself below that path.
//
// Boxes in one place: areas tie, and the lower of two subtrees is taken. Whatever the areas say, the heights of
// siblings never differ by more than qc_treeSlack: a leaf is only paired with a node no higher than that, so each
// insertion or removal changes the height of a subtree by at most one, rotations that would do more are not taken, and
// then one rotation restores the balance of the parent: with h(B) = h(C) + slack + 1, exchange C and the higher child F
// of B; G, B's other child, has h(C) <= h(G) <= h(F) = h(C) + slack, so both pairs (C, G) and (F, B) are in balance
// again, and the subtree's height is within one of what it was.
#include "box_tree.h"

#include <assert.h>
#include <float.h>

static qcTreeNode* Node(qcBoxTree* tree, uint32_t node)
{
    return &QC_AT(qcTreeNode, tree->nodes, node);
}

static double Extent(double lower, double upper)
{
    double extent = upper - lower;
    return extent < 1e100 ? extent : 1e100;
}

/// Half the surface area, and a thousandth of the squared diagonal, which tells boxes on a line apart: their area is 0.
static double Area(double x, double y, double z)
{
    return x * y + y * z + z * x + 1e-3 * (x * x + y * y + z * z);
}

static double AreaOf(const qcTreeNode* a)
{
    return Area(Extent(a->lower[0], a->upper[0]), Extent(a->lower[1], a->upper[1]), Extent(a->lower[2], a->upper[2]));
}

static double AreaOfUnion(const qcTreeNode* a, const qcTreeNode* b)
{
    double extent[3];
    for (int k = 0; k < 3; k++)
        extent[k] = Extent(qcLower(a->lower[k], b->lower[k]), qcUpper(a->upper[k], b->upper[k]));
    return Area(extent[0], extent[1], extent[2]);
}

static bool InBalance(uint32_t heightA, uint32_t heightB)
{
    return heightA <= heightB + qc_treeSlack && heightB <= heightA + qc_treeSlack;
}

static uint32_t HeightAbove(uint32_t heightA, uint32_t heightB)
{
    return (heightA > heightB ? heightA : heightB) + 1;
}

/// Exchanges a child with a grandchild where that makes the tree better or where balance demands it.
static bool Rotate(qcBoxTree* tree, qcTreeNode* a, uint32_t nodeA, uint32_t oldHeight)
{
    const qcTreeNode* child[2] = {Node(tree, a->child[0]), Node(tree, a->child[1])};
    double bestGain = InBalance(child[0]->height, child[1]->height) ? 0.0 : -DBL_MAX;
    int bestB = -1, bestF = 0;
    for (int i = 0; i < 2; i++)
    {
        const qcTreeNode *b = child[i], *c = child[1 - i];
        if (b->height == 0)
            continue;
        double area = AreaOf(b);
        for (int j = 0; j < 2; j++)
        {
            const qcTreeNode *f = Node(tree, b->child[j]), *g = Node(tree, b->child[1 - j]);
            uint32_t heightB = HeightAbove(c->height, g->height), heightA = HeightAbove(f->height, heightB);
            if (!InBalance(c->height, g->height) || !InBalance(f->height, heightB) || heightA > oldHeight + 1 ||
                heightA + 1 < oldHeight)
                continue;
            double gain = area - AreaOfUnion(c, g);
            if (gain > bestGain)
            {
                bestGain = gain;
                bestB = i;
                bestF = j;
            }
        }
    }
    if (bestB < 0)
        return false;
    uint32_t nodeB = a->child[bestB], nodeC = a->child[1 - bestB];
    qcTreeNode *b = Node(tree, nodeB), *c = Node(tree, nodeC);
    uint32_t nodeF = b->child[bestF], nodeG = b->child[1 - bestF];
    qcTreeNode *f = Node(tree, nodeF), *g = Node(tree, nodeG);
    a->child[1 - bestB] = nodeF;
    f->parent = nodeA;
    b->child[bestF] = nodeC;
    c->parent = nodeB;
    for (int k = 0; k < 3; k++)
    {
        b->lower[k] = qcLower(c->lower[k], g->lower[k]);
        b->upper[k] = qcUpper(c->upper[k], g->upper[k]);
    }
    b->height = HeightAbove(c->height, g->height);
    a->height = HeightAbove(f->height, b->height);
    return true;
}

/// Brings bounds, heights and balance up to date from `node` to the root.
static void Repair(qcBoxTree* tree, uint32_t node)
{
    bool changed = true;
    while (node != QC_NO_NODE && changed)
    {
        qcTreeNode* a = Node(tree, node);
        const qcTreeNode *x = Node(tree, a->child[0]), *y = Node(tree, a->child[1]);
        uint32_t oldHeight = a->height;
        a->height = HeightAbove(x->height, y->height);
        changed = false;
        for (int k = 0; k < 3; k++)
        {
            double lower = qcLower(x->lower[k], y->lower[k]), upper = qcUpper(x->upper[k], y->upper[k]);
            changed |= lower != a->lower[k] || upper != a->upper[k];
            a->lower[k] = lower;
            a->upper[k] = upper;
        }
        bool rotated = Rotate(tree, a, node, oldHeight);
        assert(InBalance(Node(tree, a->child[0])->height, Node(tree, a->child[1])->height));
        changed |= rotated || a->height != oldHeight;
        node = a->parent;
    }
}

typedef struct Branch
{
    uint32_t node;
    /// What the nodes above grow by when the box goes below them.
    double inherited;
} Branch;

/// The node at or below `top` whose union with the box, and the growth of the nodes above it, adds the least area.
static uint32_t FindSibling(const qcBoxTree* tree, uint32_t top, const qcTreeNode* box)
{
    Branch stack[qc_treeStack];
    uint32_t count = 0, best = QC_NO_NODE, bestHeight = UINT32_MAX;
    double bestCost = DBL_MAX, area = AreaOf(box);
    // One descent, and what its pruning left over. With 10 000 moving boxes, four times as many looks made moves 2.6
    // times as slow and searches no faster.
    uint32_t left = qcBoxTree_Node(tree, top)->height + 1;
    stack[count++] = (Branch){top, 0.0};
    while (count > 0 && (left > 0 || best == QC_NO_NODE))
    {
        Branch branch = stack[--count];
        const qcTreeNode* node = qcBoxTree_Node(tree, branch.node);
        double bound = branch.inherited + area;
        // Among equals only lower subtrees are worth a look.
        if (bound > bestCost || (bound == bestCost && node->height >= bestHeight))
            continue;
        left -= left > 0;
        double direct = AreaOfUnion(node, box), cost = branch.inherited + direct;
        if (node->height <= qc_treeSlack && (cost < bestCost || (cost == bestCost && node->height < bestHeight)))
        {
            best = branch.node;
            bestCost = cost;
            bestHeight = node->height;
        }
        if (node->height == 0)
            continue;
        const qcTreeNode *x = qcBoxTree_Node(tree, node->child[0]), *y = qcBoxTree_Node(tree, node->child[1]);
        // Down the child that grows least, and rather down a small one: one that holds everything, as a ground or an
        // infinite box makes it, does not grow, but nothing good comes below. With five infinite boxes among 3000, a
        // query looks at 58 nodes instead of 314; without them at 25 instead of 27.
        double growthX = AreaOfUnion(x, box) - 0.95 * AreaOf(x), growthY = AreaOfUnion(y, box) - 0.95 * AreaOf(y);
        int first = growthX < growthY || (growthX == growthY && x->height <= y->height) ? 0 : 1;
        double inherited = branch.inherited + direct - AreaOf(node);
        stack[count++] = (Branch){node->child[1 - first], inherited};
        stack[count++] = (Branch){node->child[first], inherited};
    }
    return best;
}

static uint32_t TakeNode(qcBoxTree* tree)
{
    uint32_t node = tree->firstFree;
    if (node == QC_NO_NODE)
        return (uint32_t)tree->nodes.count++;
    tree->firstFree = Node(tree, node)->parent;
    return node;
}

static void GiveNode(qcBoxTree* tree, uint32_t node)
{
    Node(tree, node)->parent = tree->firstFree;
    tree->firstFree = node;
}

/// Hangs a leaf in at or below `top`.
static void Attach(qcBoxTree* tree, uint32_t leaf, uint32_t top)
{
    qcTreeNode* box = Node(tree, leaf);
    box->parent = QC_NO_NODE;
    if (tree->root == QC_NO_NODE)
    {
        tree->root = leaf;
        return;
    }
    uint32_t sibling = FindSibling(tree, top, box), parent = TakeNode(tree);
    qcTreeNode *s = Node(tree, sibling), *p = Node(tree, parent);
    *p = (qcTreeNode){.parent = s->parent, .child = {sibling, leaf}, .height = s->height};
    if (s->parent == QC_NO_NODE)
        tree->root = parent;
    else
    {
        qcTreeNode* above = Node(tree, s->parent);
        above->child[above->child[1] == sibling] = parent;
    }
    s->parent = parent;
    box->parent = parent;
    Repair(tree, parent);
}

/// Takes a leaf out and returns the node above the gap, or the root.
static uint32_t Detach(qcBoxTree* tree, uint32_t leaf)
{
    uint32_t parent = Node(tree, leaf)->parent;
    if (parent == QC_NO_NODE)
    {
        tree->root = QC_NO_NODE;
        return QC_NO_NODE;
    }
    const qcTreeNode* p = Node(tree, parent);
    uint32_t sibling = p->child[p->child[0] == leaf], above = p->parent;
    Node(tree, sibling)->parent = above;
    if (above == QC_NO_NODE)
        tree->root = sibling;
    else
        Node(tree, above)->child[Node(tree, above)->child[1] == parent] = sibling;
    GiveNode(tree, parent);
    Repair(tree, above);
    return above == QC_NO_NODE ? sibling : above;
}

static void SetBounds(qcTreeNode* node, const double lower[3], const double upper[3])
{
    for (int k = 0; k < 3; k++)
    {
        node->lower[k] = lower[k];
        node->upper[k] = upper[k];
    }
}

qcStatus qcBoxTree_Reserve(qcBoxTree* tree, uint32_t leafCount)
{
    return qcArray_Reserve(&tree->nodes, 2 * (size_t)leafCount, sizeof(qcTreeNode), "nodes of a box tree");
}

void qcBoxTree_Clear(qcBoxTree* tree)
{
    tree->nodes.count = 0;
    tree->root = QC_NO_NODE;
    tree->firstFree = QC_NO_NODE;
}

void qcBoxTree_Free(qcBoxTree* tree)
{
    qcArray_Free(&tree->nodes);
    qcBoxTree_Clear(tree);
}

uint32_t qcBoxTree_Insert(qcBoxTree* tree, const double lower[3], const double upper[3], uint32_t id)
{
    uint32_t leaf = TakeNode(tree);
    qcTreeNode* node = Node(tree, leaf);
    SetBounds(node, lower, upper);
    node->child[0] = id;
    node->child[1] = QC_NO_NODE;
    node->height = 0;
    Attach(tree, leaf, tree->root);
    return leaf;
}

void qcBoxTree_Remove(qcBoxTree* tree, uint32_t leaf)
{
    Detach(tree, leaf);
    GiveNode(tree, leaf);
}

void qcBoxTree_Move(qcBoxTree* tree, uint32_t leaf, const double lower[3], const double upper[3])
{
    qcTreeNode* node = Node(tree, leaf);
    SetBounds(node, lower, upper);
    uint32_t top = Detach(tree, leaf);
    // Above a node that holds the box nothing would grow: no need to go down from the root.
    while (top != QC_NO_NODE && Node(tree, top)->parent != QC_NO_NODE &&
           !qcBounds_Contain(Node(tree, top)->lower, Node(tree, top)->upper, lower, upper))
        top = Node(tree, top)->parent;
    Attach(tree, leaf, top);
}
