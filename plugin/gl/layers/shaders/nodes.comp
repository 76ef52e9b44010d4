// A workgroup for each node: boxes of its triangles and clusters and its own, rounded outward to levels; and the image. The
// node is added to the list of every cell that its box covers.
layout(std430, binding = 2) buffer Boxes { uvec4 outBoxes[]; }; // BOXES_OF_NODE a node: triangles, clusters, the node
layout(std430, binding = 4) buffer Entries { uvec4 outEntries[]; }; // node, next entry, cell, body
layout(std430, binding = 5) buffer NodePairs { uvec2 outNodePairs[]; };

shared uvec4 lowers[64], uppers[64];
shared uint firstEntry;

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

// Room in the list of entries. A node with itself is a pair of nodes: appended here, so that these pairs, which yield more
// than others, lie together.
void reserveEntries(uint node, uint body, uint count)
{
    firstEntry = append(entryCounter, count, entryCapacity);
    if (firstEntry + count >= 0x80000000u)
        counters[overflowCounter] = 1u;
    if (bodySelfCollides(body))
        outNodePairs[min(append(nodePairCounter, 1u, nodePairCapacity), nodePairCapacity)] = uvec2(node);
}

void main()
{
    uint i = GROUP, k = gl_LocalInvocationID.x;
    if (i >= activeNodes)
        return;

    uint node = activeNode(i), body = texelFetch(nodes, int(node)).x;
    if (i < changedNodes)
        findBoxes(node, k);
    else if (k == 0u)
    {
        uvec4 box = outBoxes[node * uint(BOXES_OF_NODE) + 72u];
        lowers[0] = lowerEnds(box), uppers[0] = upperEnds(box);
    }
    barrier();

    uvec4 lower = lowers[0], upper = uppers[0];
    // Nodes outside the AABB of their body's partners are skipped.
    bool isOfInterest = IS_OF_INTEREST(packBox(lower, upper), body);
    uvec3 first = lower.xyz >> cellShift, last = upper.xyz >> cellShift, size = last - first + 1u;
    uint count = isOfInterest ? size.x * size.y * size.z : 0u;
    if (k == 0u && isOfInterest)
        reserveEntries(node, body, count);
    else if (k == 0u)
        atomicAdd(counters[skippedCounter], 1u);
    barrier();

    uint cellIndex = k;
    for (; cellIndex < count && firstEntry + cellIndex < entryCapacity; cellIndex += 64u)
    {
        uint row = cellIndex / size.x, index = firstEntry + cellIndex;
        uint cell = cellAt(first + uvec3(cellIndex - row * size.x, row % size.y, row / size.y));
        uint next = atomicExchange(counters[COUNTER_WORDS + cell], index);
        outEntries[index] = uvec4(node, next, cell, body);
    }
    // Some implementations stop the loops of an invocation after 65 535 iterations in all.
    if (cellIndex < count && firstEntry + cellIndex < entryCapacity)
        counters[stoppedCounter] = 1u;
}
