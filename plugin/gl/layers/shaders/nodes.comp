// A workgroup for each node: boxes of its triangles and clusters and its own, rounded outward to levels. Joins the node's
// box to that of its tile, TILE_NODES active nodes.
// BOXES_OF_NODE a node: triangles, clusters, the node; then those of active nodes, see nodeBoxesAt.
layout(std430, binding = 2) buffer Boxes { uvec4 outBoxes[]; };

shared uvec4 lowers[64], uppers[64];

// The box of several boxes, in the place of the first.
void mergeBoxes(uint first, uint stride)
{
    for (uint k = 1u; k < 8u; k++)
    {
        lowers[first] = min(lowers[first], lowers[first + k * stride]);
        uppers[first] = max(uppers[first], uppers[first + k * stride]);
    }
}

void findBoxes(uint node, uint k)
{
    uint base = node * uint(BOXES_OF_NODE);
    findBox(int(node * 64u + k), lowers[k], uppers[k]);
    outBoxes[base + k] = packBox(lowers[k], uppers[k]);
    barrier();
    if (k < 8u)
    {
        mergeBoxes(8u * k, 1u);
        outBoxes[base + 64u + k] = packBox(lowers[8u * k], uppers[8u * k]);
    }
    barrier();
    if (k == 0u)
    {
        mergeBoxes(0u, 8u);
        outBoxes[base + 72u] = packBox(lowers[0], uppers[0]);
    }
}

// Nodes outside the AABB of their body's partners are skipped: their boxes are empty here, and change no tile's.
void addNode(uint i, uint node, uvec4 lower, uvec4 upper)
{
    if (!IS_OF_INTEREST(packBox(lower, upper), texelFetch(nodes, int(node)).x))
    {
        atomicAdd(counters[skippedCounter], 1u);
        lower = uvec4(highestLevel), upper = uvec4(0u);
    }
    outBoxes[nodeBoxesAt + i] = packBox(lower, upper);
    uint tile = COUNTER_WORDS + i / TILE_NODES * tileWords;
    for (uint axis = 0u; axis < 4u; axis++)
    {
        atomicMin(counters[tile + axis], lower[axis]);
        atomicMin(counters[tile + 4u + axis], highestLevel - upper[axis]);
    }
}

void main()
{
    countKernel(nodesRan);
    uint i = GROUP, k = gl_LocalInvocationID.x;
    if (i >= activeNodes)
        return;

    uint node = activeNode(i);
    if (i < changedNodes)
        findBoxes(node, k);
    else if (k == 0u)
    {
        uvec4 box = outBoxes[node * uint(BOXES_OF_NODE) + 72u];
        lowers[0] = lowerEnds(box), uppers[0] = upperEnds(box);
    }
    if (k == 0u)
        addNode(i, node, lowers[0], uppers[0]);
}
