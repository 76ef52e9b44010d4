// Boxes of nodes, and the image: each node is added to the list of every cell that its box covers.
layout(std430, binding = 1) buffer NodeBoxes { uvec4 outNodeBoxes[]; };
layout(std430, binding = 2) buffer Heads { uint heads[]; };
layout(std430, binding = 3) buffer Entries { uvec4 outEntries[]; }; // node, next entry, cell, body
#ifdef IMAGE_ONLY
layout(std430, binding = 5) buffer NodeGroups { uint outGroups[]; };
#else
layout(std430, binding = 4) buffer NodePairs { uvec2 outNodePairs[]; };
#endif
uniform uint nodeCount, entryCapacity, nodePairCapacity;

void main()
{
#ifdef IMAGE_ONLY
    MARK_FINISHED
#endif
    uint i = ITEM;
    if (i >= nodeCount)
        return;

    int node = int(texelFetch(activeNodes, int(i)).x);
    uvec4 lower = uvec4(0x7fffu), upper = uvec4(0u);
    for (int k = 0; k < 8; k += 2)
    {
        uvec4 first = texelFetch(clusterBoxes, node * 8 + k), second = texelFetch(clusterBoxes, node * 8 + k + 1);
        uvec4 lowers[] = uvec4[](lowerEnds(first), lowerEnds(second)),
              uppers[] = uvec4[](upperEnds(first), upperEnds(second));
#ifdef IMAGE_ONLY
        WRITE_TWO_OF_GROUP(outGroups, node, k, lowers, uppers)
#endif
        lower = min(lower, min(lowers[0], lowers[1]));
        upper = max(upper, max(uppers[0], uppers[1]));
    }
    uvec4 box = packBox(lower, upper);
    outNodeBoxes[node] = box;
    // Nodes outside the AABB of their body's partners are skipped.
    uint body = texelFetch(nodes, node).x;
    uvec4 interest = texelFetch(bodies, int(body) * BODY_TEXELS + 1);
    if (OVERLAP(box, interest))
    {
        uvec3 first = lower.xyz >> cellShift, last = upper.xyz >> cellShift, size = last - first + 1u;
        uint count = size.x * size.y * size.z;
        uint index = append(entryCounter, count, entryCapacity), end = index + count;
        for (uvec3 at = first; index != end && index < entryCapacity; index++)
        {
            uint cell = cellAt(at), next = atomicExchange(heads[cell], index);
            outEntries[index] = uvec4(uint(node), next, cell, body);
            at.x++;
            at = at.x > last.x ? uvec3(first.x, at.y + 1u, at.z) : at;
            at = at.y > last.y ? uvec3(first.xy, at.z + 1u) : at;
        }
        // Some implementations stop the loops of an invocation after 65 535 iterations in all.
        if (index < min(end, entryCapacity))
            counters[stoppedCounter] = 1u;
#ifndef IMAGE_ONLY
        // A node with itself: appended here, so that these pairs, which yield more than others, lie together.
        if (bodySelfCollides(body))
            outNodePairs[min(append(nodePairCounter, 1u, nodePairCapacity), nodePairCapacity)] = uvec2(node);
#endif
        if (end >= 0x80000000u)
            counters[overflowCounter] = 1u;
    }
    else
        atomicAdd(counters[skippedCounter], 1u);
}
